"""New plans while the robot moves: made beside the control path, and ready when they are ready."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.control.settings import Bounds
from skillfold.control.timing import Reference, time_path
from skillfold.motion import Array, Plan

Planner = Callable[[Array, Array, Any], Plan]
"""Called with start (D,), goal (D,) and obstacles or None."""

TIGHT = 0.5  # of the clearance that a plan has, or of the margin: what comes nearer blocks it


@dataclass(frozen=True)
class Renewal:
    """What came of asking for a new plan.

    Attributes:
        reference: in time; None where there is no plan.
        keep: clearance below which it counts as blocked.
        reason: of the plan, in words.
        planned: whether the reference follows a new plan, and not what was left of the old one.
        moved: how far off the manifold the plan found its start.
    """

    reference: Reference | None
    keep: float
    reason: str
    planned: bool
    moved: float = 0.0


@dataclass(frozen=True)
class Question:
    """A plan that is wanted.

    Attributes:
        start, velocity, goal: (D,) from where, how fast, to where.
        obstacles: or None.
        bounds: of the motion.
        planner: who makes it.
        rest: (n, D) of the path so far, what to go back to where there is no plan; None where it is still followed.
    """

    start: Array
    velocity: Array
    goal: Array
    obstacles: Any
    bounds: Bounds
    planner: Planner
    rest: Array | None = None


def planner_of(skill: Any, near: Array) -> Planner:
    """The skill's own geodesics; among obstacles the path so far (n, D) is bent first."""

    def plan(start: Array, goal: Array, obstacles: Any) -> Plan:
        if obstacles is None:
            return skill.plan(start, goal, route="geodesic")
        return skill.plan(start, goal, obstacles=obstacles, route="geodesic", near=near)

    return plan


def renew(question: Question) -> Renewal:
    """Plan and put it in time, or else what is left of the path so far; whatever goes wrong is a reason."""
    q, reason, moved = question, "", 0.0
    try:
        plan = q.planner(q.start, q.goal, q.obstacles)
        states, reason, moved = plan.path.states, plan.reason, float(plan.start_moved)
        left = q.bounds.left(states) if plan.success and states.shape[1] == len(q.goal) else ""
        if plan.success and states.shape[1] == len(q.goal) and not left:
            return Renewal(*timed(states, q.velocity, q.obstacles, q.bounds), reason, True, moved)
        if plan.success:
            reason = left or f"The planner's path has {states.shape[1]} coordinates."
    except Exception as error:  # a planner of the user's may fail in any way, and the robot must go on
        reason = f"{type(error).__name__}: {error}"
    with suppress(Exception):
        if q.rest is not None and (q.obstacles is None or np.min(q.obstacles.clearance(q.rest)) > 0):
            return Renewal(*timed(q.rest, np.zeros(len(q.goal)), q.obstacles, q.bounds), reason, False, moved)
    return Renewal(None, 0.0, reason, False)


def timed(
    states: Array, velocity: Array, obstacles: Any, bounds: Bounds, duration: float | None = None
) -> tuple[Reference, float]:
    """A path (n, D) in time, begun with what of a velocity (D,) goes along it; the clearance that blocks it."""
    first = states[1] - states[0] if len(states) > 1 else np.zeros_like(velocity)
    length = float(np.linalg.norm(first))
    speed = max(float(velocity @ first) / length, 0.0) if length > 0 else 0.0
    reference = time_path(states, bounds.velocity, bounds.acceleration, duration, speed)
    if obstacles is None:
        return reference, 0.0
    least = float(np.min(obstacles.clearance(reference.knots[: round(reference.duration / reference.step) + 1, 0])))
    return reference, TIGHT * min(least, obstacles.margin) if least > 0 else TIGHT * obstacles.margin


class Inline:
    """Plans made at once that count after a fixed time: a simulation with the same seed gives the same bits."""

    def __init__(self, latency: float) -> None:
        self.latency = latency
        self._made: tuple[float, Renewal] | None = None

    @property
    def pending(self) -> bool:
        """Whether an answer is still to come."""
        return self._made is not None

    def ask(self, question: Question, time: float) -> None:
        """Ask for a plan at a time [s]."""
        self._made = time + self.latency, renew(question)

    def take(self, time: float) -> Renewal | None:
        """The answer, once it is there."""
        if self._made is None or time < self._made[0]:
            return None
        renewal, self._made = self._made[1], None
        return renewal

    def close(self) -> None:
        """Nothing is left running."""
        self._made = None


class Worker:
    """Plans made in a thread of their own, one at a time."""

    def __init__(self, latency: float) -> None:
        self.latency = latency
        self._pool = ThreadPoolExecutor(1, "skillfold replanning")
        self._made: Future[Renewal] | None = None

    @property
    def pending(self) -> bool:
        """Whether an answer is still to come."""
        return self._made is not None

    def ask(self, question: Question, time: float) -> None:
        """Ask for a plan; once closed, none is made."""
        with suppress(RuntimeError):
            self._made = self._pool.submit(renew, question)

    def take(self, time: float) -> Renewal | None:
        """The answer, once it is there."""
        if self._made is None or not self._made.done():
            return None
        renewal, self._made = self._made.result(), None
        return renewal

    def close(self) -> None:
        """End the thread."""
        self._pool.shutdown(wait=False, cancel_futures=True)
