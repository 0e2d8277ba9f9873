"""`skillfold plan` for skills of keyframes: joint positions that lead the tool through their envelopes."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from skillfold.cli import console, files
from skillfold.cli.options import seed
from skillfold.errors import InputError

if TYPE_CHECKING:
    from skillfold.cli.planning import Plan
    from skillfold.keyframes.skill import KeyframeSkill
    from skillfold.motion import Plan as Planned
    from skillfold.robots.obstacles import Obstacles

ELSEWHERE = ("goal", "via", "points", "route", "method", "recordings")  # options that only manifolds have
POSES = 50  # of the first gate that a start is looked for at, the mean first


def plan(asked: "Plan", around: "Obstacles | None") -> int:
    """Plan among obstacles, write, report.

    Raises:
        InputError: options that mean nothing here, no robot, a start that is none.
    """
    given = [f"--{name}" for name in ELSEWHERE if getattr(asked, name)]
    if given:
        raise InputError(f"{', '.join(given)}: {asked.skill} is a skill of keyframes, which has its own goal.")
    if around is None:
        raise InputError(f"{asked.skill} is a skill of keyframes: name the robot whose tool it is for, --robot jaco.")
    out = None if asked.out is None else files.writable(asked.out, ".csv")
    skill = files.load_keyframes(asked.skill)
    start = found_start(skill, around, seed(asked.seed)) if asked.start is None else _read(asked.start, around)
    planned = _planned(asked, skill, around, start)
    if out and planned.success:
        _write(out, around, planned)
    asked.draw(skill, planned, around)
    told = facts(planned, out) | {"start": [float(value) for value in start]}
    if asked.json:
        states = planned.path.states.tolist() if planned.success else None
        told |= {"start_found": asked.start is None, "names": list(around.robot.names), "states": states}
    elif asked.start is None:
        console.say("start: found by inverse kinematics, the tool in the first keyframe's gate")
    console.report(told, asked.json)
    if not planned.success:
        console.say(f"no path: {planned.reason}")
    return 0 if planned.success else 1


def found_start(skill: "KeyframeSkill", around: "Obstacles", seed: int) -> Any:
    """Joint positions (dof,) with the tool in the first keyframe's gate, clear of everything.

    Raises:
        InputError: none were found.
    """
    from numpy import vstack

    from skillfold.robots.reaching import reach

    first = skill.gaussians[0]
    for i, pose in enumerate(vstack([first.mean, first.sample(POSES - 1, seed)])):
        postures = reach(around.robot, pose, around, seed + i)
        if len(postures):
            return postures[0]
    raise InputError(
        f"--start: left out, and no joint positions of {around.robot.name} were found with the tool in the first "
        f"keyframe's gate and clear: {POSES} poses tried. Give joint positions."
    )


def facts(planned: "Planned", out: Path | None) -> dict[str, Any]:
    """What is told of a plan, in JSON's types."""
    from numpy import isfinite

    stats = planned.stats
    check = stats.get("check")
    numbers = {
        "clearance": check.clearance if check is not None else float("nan"),
        "first_solution": stats["first_solution"],
        "seconds": stats.get("seconds", float("nan")),
    }
    return {
        "success": planned.success,
        "reason": planned.reason,
        "points": len(planned.path),
        "length": planned.length,
        "gate_factor": float(stats["gate_factor"]),
        "nodes": int(stats["nodes"]),
        "pair": int(stats.get("pair", 0)),
        **{name: float(value) if isfinite(value) else None for name, value in numbers.items()},
        "out": str(out) if out and planned.success else None,
    }


def _planned(asked: "Plan", skill: "KeyframeSkill", around: "Obstacles", start: Any) -> "Planned":
    given = {"alpha": asked.alpha, "time_limit": asked.time, "stop": asked.stop}
    options: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    return skill.plan(around.robot, start, around, seed=asked.seed, **options)


def _read(text: str, around: "Obstacles") -> list[float]:
    names = around.robot.names
    try:
        values = [float(part) for part in text.replace(",", " ").split()]
    except ValueError:
        values = []
    if len(values) != len(names):
        raise InputError(f"--start {text!r}: expected {len(names)} joint positions [rad], {', '.join(names)}.")
    return values


def _write(out: Path, around: "Obstacles", planned: "Planned") -> None:
    from skillfold.io.state_files import state_columns, write_table

    write_table(out, state_columns(around.robot.names, planned.path.states))
