"""One leg of a plan: from joint positions to a goal, inside one constraint."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.check import Check, check_path
from skillfold.keyframes.charts import LENGTH, PoseChart
from skillfold.keyframes.compiled import compiled_constraint, raise_error
from skillfold.keyframes.constraint import PoseConstraint
from skillfold.keyframes.kernels.descent import Held, Problem
from skillfold.keyframes.kernels.reaching import reach
from skillfold.keyframes.rrtstar import Found, Targets, dense, search
from skillfold.robots.obstacles import Obstacles
from skillfold.robots.robot import Robot

Array = np.ndarray[Any, np.dtype[np.float64]]

REACH = 0.3  # η, radians: longest edge of the tree
KEPT = 0.25  # of the margin that edges must keep; where an end has less, half of what it has
SPACING = 0.01  # radians between the states of a path
DESCENTS = (4, 28, 96, 192)  # tried to reach the goal, the first ones from the start


@dataclass(frozen=True)
class Leg:
    """What one search is asked.

    Attributes:
        robot, obstacles: that moves, and that it keeps clear of.
        hold, goal: constraints on the tool's pose, all along and at the end; no goal where `targets` has an end.
        level, goal_level: the excess up to which poses count as inside.
        tolerance: distance [m] that the check allows.
        chart: of all coordinates.
        axis: (2, 6) that poses are pulled to.
        metric: (6, 6) whitens chart coordinates.
        targets: where targets come from.
    """

    robot: Robot
    obstacles: Obstacles
    hold: PoseConstraint
    goal: PoseConstraint | None
    level: float
    goal_level: float
    tolerance: float
    chart: PoseChart
    axis: Array
    metric: Array
    targets: Targets

    def problem(self, start: Array) -> tuple[Problem, Callable[[], None]]:
        """The same for compiled loops; and what raises, after them, the errors of a user's constraint.

        Where the start has less than the margin, edges keep half of what it has.
        """
        hold = compiled_constraint(self.hold)
        goal = hold if self.goal is None else compiled_constraint(self.goal)
        goal_level = -np.inf if self.goal is None else self.goal_level
        clear = self.obstacles.compiled()
        margin = min(KEPT * self.obstacles.margin, 0.5 * float(self.obstacles.clearance(start)))
        lower, upper = self.robot.limits
        turning = np.array([kind == "continuous" for kind in self.robot.space.kinds])
        problem = Problem(
            self.robot.compiled_tool(),
            Held(hold.excess, hold.project, hold.arguments, self.level),
            Held(goal.excess, goal.project, goal.arguments, goal_level),
            clear.clearance,
            clear.edge,
            clear.arguments,
            margin,
            lower,
            upper,
            turning,
            self.chart.middle,
            self.axis,
            self.metric,
            REACH,
        )
        owners = hold, goal, clear

        def check() -> None:
            for owner in owners[:2]:
                raise_error(owner)

        return problem, check

    def search(self, start: Array, begun: float, deadline: float, first: bool, seed: int) -> tuple[Found, str]:
        """A way from joint positions (D,), or why there can be none, in words."""
        problem, check = self.problem(start)
        why = "" if self.goal is None else self.unreachable(problem, start, seed)
        check()
        if why:
            return Found(np.empty((0, len(start)))), why
        found = search(problem, start, self.targets, begun, deadline, first, seed)
        check()
        return found, ""

    def unreachable(self, problem: Problem, start: Array, seed: int) -> str:
        """Why the goal cannot be reached from anywhere, as far as many descents tell; empty where it seems it can."""
        rng, hits = np.random.default_rng(seed), Counter[str]()
        for turn, count in enumerate(DESCENTS):
            seeds = rng.integers(2**31, size=2).tolist()
            states = self.targets.states(count, seeds[0])
            if turn == 0:
                states[:] = start
            targets, used = self.targets.goal(count, seeds[1]), 0
            while used < count:
                at = reach(problem, states[used:], targets[used:])
                if at < 0:
                    break
                state = states[used + at]
                if self.obstacles.clearance(state) > problem.margin:
                    return ""
                hits[self.obstacles.nearest(state)] += 1
                used += at + 1
        if hits:
            return f"The goal is blocked: {hits.most_common(1)[0][0]}, in all {hits.total()} poses found there."
        return f"The goal is out of reach: none of {sum(DESCENTS)} descents, from the start and from anywhere, got there."

    def checked(self, path: Array) -> tuple[Array, Check]:
        """The path (n, D) with states `SPACING` apart, and the independent check of them."""
        states = self.robot.couple(dense(path, SPACING))
        judge = Judge(self.robot, self.hold)
        space, still = self.robot.space, 2.0 * SPACING
        return states, check_path(states, judge, self.tolerance, space, still, self.obstacles)


@dataclass(frozen=True)
class Judge:
    """A constraint on poses as the independent check knows constraints: by states."""

    robot: Robot
    constraint: PoseConstraint

    def judge(self, states: Array) -> tuple[Array, Array]:
        """Distances (n,) [m] of the poses from the constraint, and zeros: nothing was demonstrated in joint space."""
        distance = np.asarray(self.constraint.distance(self.robot.forward(states)), np.float64)
        return distance, np.zeros(len(states))


def whitening(covariances: Array) -> Array:
    """(6, 6) that whitens chart differences by covariances (2, 3, 3) of position and rotation."""
    metric = np.zeros((6, 6))
    metric[:3, :3], metric[3:, 3:] = np.linalg.inv(np.linalg.cholesky(covariances))
    return metric


def lengths() -> Array:
    """(6, 6) that makes chart differences metres."""
    return np.diag(np.repeat([1.0, LENGTH], 3))


def seconds_left(deadline: float) -> float:
    """Until a time of `perf_counter`."""
    return deadline - perf_counter()
