"""Motions between random ends, left alone or pushed once, by a naive planner and on a skill manifold.

A motion lasts one unit of time. At t = 0.25 a push moves the arm by a given distance in a random direction of joint
space, and stops it (section V-C). The naive planner then takes a new quintic to the goal. The manifold's moves back
to the projection of where it is, as a controller would, within a tenth of the time, and along a new plan in what is
left. "Unhurried" takes both in one: its way back is no faster than the rest. All of them rest at the ends of every
part, and follow the same time law in between.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.baselines.quintic import timed
from skillfold.motion import Array

PUSHED_AT = 0.25
RETURN = 0.1  # of the time: how long the way back to the manifold takes
STEPS = 101
EVERY = 4  # of the states whose excess is looked at

Costs = Callable[[Array], Array]


@dataclass(frozen=True)
class Task:
    """What is asked of one system.

    Attributes:
        name: of the system.
        skill: learnt from optimal poses.
        ends: (n, 2, D) optimal poses.
        costs: by name, of states (m, D).
        excess: of states (m, D) over the optimum at their own tool positions; NaN where that is unknown.
    """

    name: str
    skill: Any
    ends: Array
    costs: dict[str, Costs]
    excess: Costs


@dataclass(frozen=True)
class Runs:
    """The motions of all trials under one push.

    Attributes:
        push: rad, zero for none.
        pushes: (n, D).
        motions: by method, (n, STEPS, D).
        excess: by method, (n, STEPS / EVERY).
        failed: plans of the skill that did not pass their check; their motions count all the same.
    """

    push: float
    pushes: Array
    motions: dict[str, Array]
    excess: dict[str, Array]
    failed: int

    def costs(self, cost: Costs) -> dict[str, Array]:
        """Mean cost (n,) of each trial, by method."""
        return {method: _by_state(cost, motions).mean(axis=1) for method, motions in self.motions.items()}


def run(task: Task, push: float, rng: np.random.Generator) -> Runs:
    """Every trial with every method, under the same pushes."""
    directions = rng.standard_normal((len(task.ends), task.ends.shape[-1]))
    pushes = push * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    trials = list(zip(task.ends[:, 0], task.ends[:, 1], pushes, strict=True))
    planned = [_on_manifold(task.skill, *trial) for trial in trials]
    motions = {
        "naive": np.array([_naive(*trial) for trial in trials]),
        "manifold": np.array([brisk for brisk, _, _ in planned]),
        "unhurried": np.array([slow for _, slow, _ in planned]),
    }
    excess = {name: _by_state(task.excess, states[:, ::EVERY]) for name, states in motions.items()}
    return Runs(push, pushes, motions, excess, sum(failed for _, _, failed in planned))


def _naive(start: Array, goal: Array, push: Array) -> Array:
    """States (STEPS, D) at even times; a quintic at rest at both ends moves all joints in proportion."""
    times, states = _even(np.stack([start, goal]))
    if push.any():
        later = times >= PUSHED_AT
        _follow(states, later, times, np.stack([states[later][0] + push, goal]), PUSHED_AT, 1.0)
    return states


def _on_manifold(skill: Any, start: Array, goal: Array, push: Array) -> tuple[Array, Array, int]:
    """The same along the manifold, back first and then on, and in one; and how many plans failed their check."""
    plan = skill.plan(start, goal)
    times, brisk = _even(np.asarray(plan.path.states))
    if not push.any():
        return brisk, brisk, int(not plan.success)
    later, returned = times >= PUSHED_AT, PUSHED_AT + RETURN
    tracked, slow = brisk[later][0], brisk.copy()
    pushed = tracked + push
    again = skill.plan(skill.project(pushed, near=tracked), goal)
    way = np.asarray(again.path.states)
    _follow(brisk, later, times, np.stack([pushed, way[0]]), PUSHED_AT, returned)
    _follow(brisk, times >= returned, times, way, returned, 1.0)
    _follow(slow, later, times, np.vstack([pushed, way]), PUSHED_AT, 1.0)
    return brisk, slow, int(not plan.success) + int(not again.success)


def _even(path: Array) -> tuple[Array, Array]:
    """Times (STEPS,) and the states of a path (n, D) then."""
    times = np.linspace(0.0, 1.0, STEPS)
    return times, timed(path, times)


def _follow(states: Array, when: np.ndarray, times: Array, path: Array, first: float, last: float) -> None:
    """Write the states of a path that is followed from one time to another, and rested at its end."""
    states[when] = timed(path, np.clip((times[when] - first) / (last - first), 0.0, 1.0))


def _by_state(value: Costs, motions: Array) -> Array:
    """Values (n, m) of the states of motions (n, m, D)."""
    return value(motions.reshape(-1, motions.shape[-1])).reshape(motions.shape[:2])
