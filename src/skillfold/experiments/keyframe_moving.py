"""A box moves into the way while a planned path is driven; the path is looked at at every tick, and planned anew.

The arm drives along its path at a steady joint speed. The box comes from the side or from above to a place on the
path that lies ahead. At every tick the planner is told where the box is, a little larger than it is, because it goes
on moving until the next tick. Where no way is found the arm stays; a box that then runs into it counts apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.errors import SkillfoldError
from skillfold.experiments.keyframe_runs import Learnt, ask
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array, Plan
from skillfold.robots.obstacles import Obstacles
from skillfold.robots.shapes import Box, Motion
from skillfold.robots.world import World

NAME = "moving box"
SIZE = (0.06, 0.06, 0.08)  # metres
GUARD = 0.01  # metres that it is taken to be larger, to each side
DISTANCE, SPEED = 0.35, 0.25  # metres that it comes from, metres a second
WHERE = (0.45, 0.65)  # share of the path at which it comes to rest
ARRIVES = 0.3  # share of the path that the arm has driven by then
JOINT_SPEED = 0.5  # rad a second
TICK, FINE = 0.02, 0.005  # seconds between looks, and between the states that are judged
LONGEST = 20.0  # seconds of an episode
AWAY = np.array([5.0, 5.0, 5.0])
TRIES, BOXES = 20, 20  # of plans, and on each of boxes that come into the way but not into the arm


@dataclass
class Episode:
    """What happened.

    Attributes:
        replans: seconds that each new plan took.
        looks: seconds of every look that left the plan as it was.
        touched: states in which a robot that was free touched the box or anything.
        caught: those in which it had no way left.
        arrived: whether it got to the end of its last path.
    """

    replans: list[float] = field(default_factory=list)
    looks: list[float] = field(default_factory=list)
    touched: int = 0
    caught: int = 0
    arrived: bool = False


def rows(skills: Sequence[Learnt], episodes: int, settings: Settings) -> list[Row]:
    """Time to plan anew, and contacts."""
    told = []
    for number in range(episodes):
        settings.progress("keyframes: moving box", 0.7 + 0.15 * number / episodes)
        told.append(episode(skills[number % len(skills)], np.random.default_rng([settings.seed, 8, number])))
    times = 1e3 * np.array([t for e in told for t in e.replans] or [np.nan])
    looks = 1e3 * np.array([t for e in told for t in e.looks] or [np.nan])
    note = (
        f"{len(told)} episodes, {np.isfinite(times).sum()} new plans, median {np.median(times):.3g} ms; "
        f"a look that keeps the plan {np.median(looks):.2g} ms; {sum(e.arrived for e in told)} arrived"
    )
    touched, caught = (float(sum(bool(getattr(e, name)) for e in told)) for name in ("touched", "caught"))
    seen = f"every {FINE:g} s by MuJoCo's contacts; {caught:g} episodes in which the box ran into one without a way"
    return [
        Row("moving box: replan, p95", float(np.quantile(times, 0.95)), "ms", 50.0, "<=", "", note),
        Row("moving box: episodes in which a free robot touches", touched, "", 0, "==", "", seen),
    ]


def episode(learnt: Learnt, rng: np.random.Generator) -> Episode:
    """Plan, drive, look, plan anew."""
    for _ in range(TRIES):
        start, seed = learnt.start(int(rng.integers(2**31))), int(rng.integers(2**31))
        plan = ask(learnt, start, 100.0, seed).plan
        box = coming(learnt, plan, rng) if plan.success else None
        if box is not None:
            return drive(learnt, plan, box, seed)
    raise RuntimeError(f"{learnt.task.name}: no box gets in the way of {TRIES} plans.")


def drive(learnt: Learnt, plan: Plan, box: Box, seed: int) -> Episode:
    """Along a plan, and along others as the box moves."""
    world = World(learnt.task.robot, [*learnt.task.scene, box])
    guarded = Box(box.pose, np.array(SIZE) + 2 * GUARD, name=NAME)
    obstacles = learnt.task.robot.obstacles([*learnt.task.scene, guarded], movable=[NAME])
    return _Drive(learnt, plan, box, world, obstacles, seed).run()


def coming(learnt: Learnt, plan: Plan, rng: np.random.Generator) -> Box | None:
    """A box that comes to rest on a path, from the side or from above, when the arm has driven some of it."""
    robot, states = learnt.task.robot, np.asarray(plan.path.states)
    arrives = ARRIVES * plan.path.length / JOINT_SPEED
    times = arrives + np.array([-DISTANCE / SPEED, 0.0])
    for _ in range(BOXES):
        place = robot.forward(at(states, rng.uniform(*WHERE) * plan.path.length))[:3]
        angle, rise = rng.uniform(0.0, 2 * np.pi), rng.uniform(0.0, 0.5)
        away = np.array([np.cos(angle), np.sin(angle), rise]) / np.hypot(1.0, rise)
        box = Box(place, SIZE, name=NAME, motion=Motion(times, [place + DISTANCE * away, place]))
        if _fair(robot.obstacles([box], self_collision=False), states, arrives):
            return box
    return None


def at(states: Array, length: float) -> Array:
    """State (D,) of a path (n, D) after some length of it; the last beyond its end."""
    places = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(states, axis=0), axis=1))])
    return np.array([np.interp(length, places, column) for column in states.T])


def _fair(obstacles: Obstacles, states: Array, arrives: float) -> bool:
    """Whether the box blocks the path, but neither an arm that drives on until the box rests, nor the path's ends."""
    times = np.linspace(0.0, arrives, 30)
    way = [obstacles.at(float(t)).clearance(at(states, JOINT_SPEED * t)) for t in times]
    rest = obstacles.at(arrives).clearance(states)
    return bool(min(*way, rest[0], rest[-1]) > 3 * GUARD and rest.min() < 0.0)


class _Drive:
    """An arm under way."""

    def __init__(self, learnt: Learnt, plan: Plan, box: Box, world: World, obstacles: Obstacles, seed: int) -> None:
        self.learnt, self.plan, self.box, self.world = learnt, plan, box, world
        self.obstacles, self.seed = obstacles, seed
        self.driven, self.free = 0.0, True
        self.told = Episode()

    def run(self) -> Episode:
        """Until it arrives."""
        motion: Any = self.box.motion
        for tick in range(int(LONGEST / TICK)):
            time = tick * TICK
            self._look(motion.at(time))
            self._step(time)
            if self.free and self.driven >= self.plan.path.length and time > motion.times[-1]:
                self.told.arrived = True
                break
        return self.told

    def _look(self, pose: Array) -> None:
        """Tell the planner where the box is."""
        learnt, seen = self.learnt, self.obstacles.move(NAME, pose)
        here = at(np.asarray(self.plan.path.states), self.driven)
        begun = perf_counter()
        try:
            plan = learnt.skill.replan(self.plan, learnt.task.robot, seen, here, seed=self.seed)
        except SkillfoldError:
            self.free = False
            return
        seconds = perf_counter() - begun
        kept = bool(plan.stats.get("kept"))
        (self.told.looks if kept else self.told.replans).append(seconds)
        self.free = plan.success
        if plan.success and not kept:
            self.plan, self.driven = plan, 0.0

    def _step(self, time: float) -> None:
        """Drive on, and see what touches."""
        states = np.asarray(self.plan.path.states)
        for share in np.arange(FINE, TICK + FINE / 2, FINE):
            self.world.move_obstacles(time + share)
            if self.free:
                self.driven = min(self.driven + JOINT_SPEED * FINE, self.plan.path.length)
            touches = self.world.touching(at(states, self.driven)[None])
            if self.free:
                self.told.touched += touches
            else:
                self.told.caught += touches
