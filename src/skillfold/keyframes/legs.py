"""One leg of a plan: from joint positions to a goal, inside one constraint."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.check import Check, check_path
from skillfold.keyframes.charts import LENGTH, PoseChart
from skillfold.keyframes.compiled import call_until, compiled_constraint
from skillfold.keyframes.constraint import PoseConstraint
from skillfold.keyframes.grown import REACH, Found, Question, Targets, dense
from skillfold.keyframes.kernels import problem as slots
from skillfold.keyframes.kernels.reaching import reach
from skillfold.robots.obstacles import Obstacles
from skillfold.robots.robot import Robot
from skillfold.tables import table_of

Array = np.ndarray[Any, np.dtype[np.float64]]

KEPT = 0.25  # of the margin that edges must keep; where an end has less, half of what it has
SPACING = 0.01  # radians between the states of a path
DESCENTS = (4, 28, 96, 192)  # tried to reach the goal, the first ones from the start


Search = Callable[[Question, Array, Targets, float, float, bool, int], Found]


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
        kept: share of the margin that edges keep.
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
    kept: float = KEPT

    def question(self, start: Array) -> Question:
        """The same for compiled loops.

        Where the start has less than the margin, edges keep half of what it has.
        """
        hold = compiled_constraint(self.hold)
        goal = hold if self.goal is None else compiled_constraint(self.goal)
        clear, tool = self.obstacles.compiled(), self.robot.compiled_tool()
        margin = min(self.kept * self.obstacles.margin, 0.5 * float(self.obstacles.clearance(start)))
        turning = np.array([kind == "continuous" for kind in self.robot.space.kinds])
        limits = np.stack(self.robot.limits)
        functions = hold.excess, hold.project, goal.excess, clear.clearance, clear.edge
        goal_level = -np.inf if self.goal is None else self.goal_level
        arrays = {
            slots.MACHINE: tool.machine,
            slots.FRAME: np.array([tool.body]),
            slots.PLACE: np.concatenate([tool.offset, tool.turn]),
            slots.FUNCTIONS: np.array([function.address for function in functions]),
            slots.HOLD: hold.arguments,
            slots.GOAL: goal.arguments,
            slots.OBSTACLES: clear.arguments,
            slots.NUMBERS: np.array([self.level, goal_level, margin, REACH]),
            slots.LIMITS: limits,
            slots.TURNING: turning,
            slots.MIDDLE: self.chart.middle,
            slots.AXIS: self.axis,
            slots.METRIC: self.metric,
        }
        table = table_of(arrays, slots.SLOTS, self.robot, hold, goal, clear)
        return Question(table, margin, turning, limits, (hold, goal))

    def search(
        self, search: Search, start: Array, begun: float, deadline: float, first: bool, seed: int
    ) -> tuple[Found, str]:
        """A way from joint positions (D,), or why there can be none, in words; arguments as of `rrtstar.search`."""
        question = self.question(start)
        for constraint in question.constraints:
            call_until(constraint, deadline)
        why = "" if self.goal is None else self.unreachable(question, start, deadline, seed)
        found = Found(np.empty((0, len(start))))
        if not why:
            found = search(question, start, self.targets, begun, deadline, first, seed)
        question.raise_errors()
        return found, why

    def unreachable(self, question: Question, start: Array, deadline: float, seed: int) -> str:
        """Why the goal cannot be reached from anywhere, as far as many descents tell; empty where it seems it can."""
        rng, hits = np.random.default_rng(seed), Counter[str]()
        for turn, count in enumerate(DESCENTS):
            seeds = rng.integers(2**31, size=2).tolist()
            states = self.targets.states(count, seeds[0])
            if turn == 0:
                states[:] = start
            targets, used = self.targets.goal(count, seeds[1]), 0
            while used < count:
                at = reach(question.table.entries, states[used:], targets[used:])
                if at < 0:
                    break
                state = states[used + at]
                if self.obstacles.clearance(state) > question.margin:
                    return ""
                hits[self.obstacles.nearest(state)] += 1
                used += at + 1
            question.raise_errors()
            if perf_counter() > deadline:
                return ""
        if hits:
            return f"The goal is blocked: {hits.most_common(1)[0][0]}, in all {hits.total()} postures found there."
        return f"The goal is out of reach: none of {sum(DESCENTS)} descents, from the start and elsewhere, got there."

    def checked(self, path: Array) -> tuple[Array, Check]:
        """The path (n, D) with states `SPACING` apart, and the independent check of them."""
        states = self.robot.couple(dense(path, SPACING))
        judge = Judge(self.robot, self.hold)
        space, still = self.robot.space, 2.0 * SPACING
        check = check_path(states, judge, self.tolerance, space, still, self.obstacles)
        return states, check._replace(reason=check.reason.replace(" off the manifold", " m outside the constraint"))


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
