"""Plans under any constraint on the tool's pose, learnt or written by hand."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.keyframes.answers import not_begun, told
from skillfold.keyframes.asking import obstacles_of, read_limits, read_start, start_trouble
from skillfold.keyframes.charts import LENGTH, PoseChart
from skillfold.keyframes.constraint import PoseConstraint
from skillfold.keyframes.foreign import known
from skillfold.keyframes.gaussians import PoseGaussian
from skillfold.keyframes.grown import Targets
from skillfold.keyframes.legs import Leg, lengths
from skillfold.keyframes.pairs import Asked, Outcome, checked_path
from skillfold.keyframes.region import PoseRegion
from skillfold.keyframes.rrtstar import prepare, search
from skillfold.motion import Plan
from skillfold.robots.poses import read_pose
from skillfold.robots.robot import Robot

Array = np.ndarray[Any, np.dtype[np.float64]]

NEAR = 0.005  # metres: how near a pose that is the goal must be reached, a radian as `LENGTH` metres
FOREIGN = 0.005  # metres: how far from a constraint that is no set of its own poses may be
ROUNDING = 1e-6  # metres: the same for those that have a tolerance, or room, of their own
SLACK = 0.01  # of a gate, or of a tolerance: kept all along
KINDS = ("auto", "pose", "joints")
TURNS = 4  # that poses of a goal are led into constraint and goal in turn
DEEPER = 0.25  # of the way there that they are put inside the border
POSES = 64  # of a goal, of which the nearest to the constraint tells whether any may hold it


@dataclass(frozen=True)
class Goal:
    """Where a path shall end.

    Attributes:
        region: poses that are the goal; None where joint positions are.
        state: those.
        pose: (7,) one of the poses.
        sample: (count, seed) → poses (count, 7).
        level: the excess up to which poses are in the goal.
    """

    region: PoseConstraint | None
    state: Array | None
    pose: Array
    sample: Callable[[int, int], Array]
    level: float = 0.0


def plan_constrained(
    robot: Robot,
    constraint: PoseConstraint,
    q_start: Any,
    goal: Any,
    scene: Any = None,
    *,
    time_limit: float = 1.0,
    stop: str = "first",
    seed: int = 0,
    tolerance: float | None = None,
    goal_is: str = "auto",
) -> Plan:
    """A path of a robot's joints, all along which the tool's pose holds a constraint, clear of obstacles.

    Args:
        robot: whose tool moves; what it holds counts.
        constraint: anything with `distance` and `project` of poses. Where it has no `sample`, poses are those of
            random joint positions, projected.
        q_start: joint positions (dof,) whose pose holds it.
        goal: a pose (7,), which the path reaches within 5 mm, a radian as .15 m; joint positions (dof,); or a
            constraint with `sample`.
        scene, time_limit, stop, seed: as in `plan_skill`.
        tolerance: how far [m] poses may be from the constraint; None is nothing (1e-6) for this library's own, which
            have tolerances or room, and 5 mm for others.
        goal_is: "pose" or "joints" where the robot has seven joints and seven numbers could be either.

    Returns:
        A plan by route "constrained"; `stats` as in `plan_skill`.

    Raises:
        InputError: says what was given and what was expected. What a constraint of yours raises comes through.
    """
    prepare()
    begun = perf_counter()
    limit = read_limits(time_limit, stop, seed)
    obstacles = obstacles_of(robot, scene)
    start = read_start(robot, q_start)
    if isinstance(constraint, type):
        raise InputError(f"constraint: the class {constraint.__name__}; expected an object of it.")
    constraint = constraint.region if isinstance(constraint, PoseGaussian) else known(constraint)
    allowed, level = _levels(constraint, tolerance)
    end = _read_goal(robot, goal, goal_is, constraint)
    pose = robot.forward(start)
    why = start_trouble(robot, obstacles, start)
    if not why and end.state is not None:
        why = start_trouble(robot, obstacles, end.state, "goal")
    why = why or _off(constraint, pose, allowed, "start") or _off(constraint, end.pose, allowed + NEAR, "goal")
    if why:
        return not_begun(robot, start[None], why, begun, "constrained")
    # A start that has less than the slack may have as little.
    excess = constraint.membership(pose)[0] ** 0.5 - 1.0 if isinstance(constraint, PoseRegion) else level
    level = float(max(level, min(excess, 0.0)))
    leg = _leg(robot, obstacles, constraint, end, pose, level, allowed)
    asked, outcome = Asked(robot, obstacles, 100.0, stop == "first", begun, search), Outcome(np.empty((0, robot.dof)))
    outcome.states = checked_path(asked, leg, start, begun + limit, asked.first, int(seed), outcome)
    return told(robot, start, [outcome], begun, 0, "constrained")


def _leg(robot: Robot, obstacles: Any, constraint: Any, end: Goal, pose: Array, level: float, allowed: float) -> Leg:
    chart = PoseChart.between(pose, end.pose)

    def inside(count: int, seed: int) -> Array:
        if hasattr(constraint, "sample"):
            return chart.to_chart(constraint.sample(count, seed))
        return chart.to_chart(constraint.project(robot.forward(robot.sample(count, seed))))

    targets = Targets(inside, lambda n, seed: chart.to_chart(end.sample(n, seed)), robot.sample, None, end.state)
    axis = chart.to_chart(np.stack([pose, end.pose]))
    held = robot, obstacles, constraint, end.region
    return Leg(*held, level, end.level, allowed, chart, axis, lengths(), targets)


def _levels(constraint: Any, tolerance: Any) -> tuple[float, float]:
    """How far [m] the check lets poses be outside, and the excess up to which the search takes them as inside."""
    number = isinstance(tolerance, int | float | np.integer | np.floating) and not isinstance(tolerance, bool)
    if tolerance is not None and not (number and 0.0 < tolerance < np.inf):
        raise InputError(f"tolerance={tolerance!r:.80}; expected metres, above zero, or None.")
    if isinstance(constraint, PoseRegion) and tolerance is None:
        return ROUNDING, -SLACK
    if hasattr(constraint, "compiled") and tolerance is None:
        return ROUNDING, -SLACK * LENGTH * min(float(np.min(getattr(constraint, "tolerance", 0.0))), NEAR)
    allowed = FOREIGN if tolerance is None else float(tolerance)
    return allowed, 0.8 * allowed


def _read_goal(robot: Robot, goal: Any, goal_is: Any, constraint: Any) -> Goal:
    if not isinstance(goal_is, str) or goal_is not in KINDS:
        raise InputError(f"goal_is={goal_is!r:.80}; possible: {', '.join(KINDS)}.")
    if hasattr(goal, "distance") and hasattr(goal, "project"):
        if not hasattr(goal, "sample"):
            raise InputError(
                f"goal: {type(goal).__name__} has no sample(count, seed); expected a constraint that has."
            )
        region = known(goal)
        poses = _led(region, constraint, region.sample(POSES, 0))
        nearest = poses[np.argmin(constraint.distance(poses))]
        return Goal(region, None, nearest, lambda n, seed: _led(region, constraint, region.sample(n, seed)))
    size = np.size(goal) if isinstance(goal, np.ndarray | list | tuple) else 0
    if size == robot.dof == 7 and goal_is == "auto":
        raise InputError("goal: seven numbers may be a pose or joint positions; say goal_is='pose' or 'joints'.")
    if goal_is == "joints" or (goal_is == "auto" and size == robot.dof):
        state = read_start(robot, goal, "goal")
        pose = robot.forward(state)
        return Goal(None, state, pose, lambda count, seed: np.tile(pose, (count, 1)))
    pose = read_pose(goal, "goal")
    if pose.shape != (7,):
        raise InputError(
            f"goal: shape {pose.shape}; expected a pose (7,), joint positions ({robot.dof},), a constraint."
        )
    spread = np.diag(np.repeat([NEAR**2, (NEAR / LENGTH) ** 2], 3))
    near = PoseGaussian(pose, spread, np.ones(2))
    return Goal(near, None, pose, lambda n, seed: np.tile(_led(near, constraint, pose[None]), (n, 1)))


def _led(goal: Any, constraint: Any, poses: Array) -> Array:
    """Poses (n, 7) of a goal, led to where they hold the constraint too, if there are such."""
    if not len(poses):
        return poses
    chart = PoseChart(poses[0, 3:])
    y = chart.to_chart(poses)
    for region in (constraint, goal) * TURNS:
        nearest = chart.to_chart(region.project(chart.to_pose(y)))
        y = nearest + DEEPER * (nearest - y)
    return chart.to_pose(y)


def _distance(constraint: Any, pose: Array) -> float:
    return float(np.ravel(constraint.distance(pose[None]))[0])


def _off(constraint: Any, pose: Array, allowed: float, what: str) -> str:
    distance = _distance(constraint, pose)
    return "" if distance <= allowed else f"The {what} lies {distance:.2g} m off the constraint."
