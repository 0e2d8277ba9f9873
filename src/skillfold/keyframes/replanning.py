"""Plans anew after obstacles moved: what is left of the path is kept where it is still clear."""

from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from skillfold.errors import InputError
from skillfold.keyframes.asking import obstacles_of, read_start, start_trouble
from skillfold.keyframes.grown import facing_path
from skillfold.keyframes.planning import plan_skill
from skillfold.motion import Path, Plan
from skillfold.robots.obstacles import Obstacles
from skillfold.robots.robot import Robot

if TYPE_CHECKING:
    from skillfold.keyframes.skill import KeyframeSkill

Array = np.ndarray[Any, np.dtype[np.float64]]

ON_PATH = 0.02  # radians from the nearest state: farther off, the path says nothing of how to go on
SECONDS = 0.045  # that a fresh plan may take, unless told otherwise: obstacles move on meanwhile
STRAIGHT = 1e-9  # radians that a state may lie off the chord of its neighbours


def replan_skill(skill: "KeyframeSkill", plan: Plan, robot: Robot, scene: Any, q: Any = None, **options: Any) -> Plan:
    """What is left of a plan from joint positions q on, where it is clear of the obstacles as they stand now.

    Its edges are followed by conservative advancement: no obstacle is too thin to be seen. Where one is blocked, or q
    lies off the path, the skill is planned afresh from q.

    Args:
        skill, robot: as the plan was made with.
        plan: to be kept, if possible.
        scene: as in `plan_skill`; `robot.obstacles(scene)` and then its `move` are the fastest.
        q: where the robot is (dof,); None is the start of the plan.
        options: of `plan_skill`; its time_limit is 45 ms here unless given.

    Returns:
        A plan whose `stats` have `kept`, whether it is the old one, and `seconds`.

    Raises:
        InputError: says what was given and what was expected.
    """
    begun = perf_counter()
    obstacles = obstacles_of(robot, scene)
    states = _read_plan(plan, robot)
    here = states[0] if q is None else read_start(robot, q, "q")
    at, off = nearest_state(states, here, robot)
    rest = facing_path(np.vstack([here[None], states[at + 1 :]]), turning_joints(robot))
    if plan.success and off < ON_PATH and not start_trouble(robot, obstacles, here) and _is_clear(obstacles, rest):
        return _kept(plan, rest, robot, begun, at)
    if "start_at" not in options and plan.stats.get("pairs"):
        options["start_at"] = pair_at(plan, at)
    options.setdefault("time_limit", SECONDS)
    fresh = plan_skill(skill, robot, here, obstacles, **options)
    fresh.stats.update(kept=False, seconds=perf_counter() - begun)
    return fresh


def nearest_state(states: Array, q: Array, robot: Robot) -> tuple[int, float]:
    """Which state of a path (n, D) is nearest to joint positions (D,), and how far off it is [rad]."""
    distances = robot.space.distance(q, states)
    at = int(distances.argmin())
    return at, float(distances[at])


def turning_joints(robot: Robot) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Which joints (dof,) are continuous."""
    return np.array([kind == "continuous" for kind in robot.space.kinds])


def pair_at(plan: Plan, state: int) -> int:
    """The pair that a state of a plan belongs to."""
    pairs = plan.stats["pairs"]
    return [row["pair"] for row in pairs if row["from"] <= state][-1]


def corners(states: Array) -> Array:
    """The states (m, D) of a path (n, D) at which it bends, and its ends."""
    if len(states) < 3:
        return states
    before, after = states[1:-1] - states[:-2], states[2:] - states[1:-1]
    lengths = np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1)
    bend = np.linalg.norm(before * lengths[1][:, None] - after * lengths[0][:, None], axis=1)
    kept = bend > STRAIGHT * (lengths[0] + lengths[1])
    return states[np.concatenate([[True], kept, [True]])]


def _is_clear(obstacles: Obstacles, states: Array) -> bool:
    few = corners(states)
    return bool(np.all(obstacles.edge_clear(few[:-1], few[1:], 0.0))) if len(few) > 1 else True


def _kept(plan: Plan, rest: Array, robot: Robot, begun: float, at: int) -> Plan:
    path = Path(rest, robot.names)
    rows = [dict(row) for row in plan.stats.get("pairs", [])]
    for row in rows:
        row["from"], row["entered"] = max(row["from"] - at, 0), max(row["entered"] - at, 0)
    pairs = [row for i, row in enumerate(rows) if i == len(rows) - 1 or rows[i + 1]["from"] > 0]
    stats = {**plan.stats, "pairs": pairs, "kept": True, "seconds": perf_counter() - begun}
    stats |= {"pair": pairs[0]["pair"], "entered": pairs[-1]["entered"]} if pairs else {}
    reason = "The rest of the path is still clear and kept."
    return Plan(True, reason, path, path.length, plan.residual, 0, True, plan.route, stats=stats)


def _read_plan(plan: Any, robot: Robot) -> Array:
    if not isinstance(plan, Plan):
        raise InputError(f"plan: {type(plan).__name__}; expected a Plan of this skill.")
    states = np.asarray(plan.path.states)
    if states.shape[1] != robot.dof:
        raise InputError(f"plan: states of {states.shape[1]} coordinates; {robot.name} has {robot.dof} joints.")
    return states
