"""`skillfold plan` and `skillfold project`: new motions from a saved skill, and states brought back to it."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from skillfold.cli import console, files
from skillfold.cli.options import Flag, seed, shown
from skillfold.cli.screen import draw_off_screen
from skillfold.errors import InputError

if TYPE_CHECKING:
    from skillfold.demonstrations import Demonstrations
    from skillfold.keyframes.skill import KeyframeSkill
    from skillfold.manifold.skill import SkillManifold
    from skillfold.motion import Plan as Planned
    from skillfold.robots.obstacles import Obstacles

STATE = (
    "First state: numbers such as 0.1,0.2,0.3 (units of the recordings, radians); states.csv:3, a row of a file with "
    "a header, counted from 0; or demo:0:first, demo:0:last, demo:0:57 of a recording. With keyframes, numbers "
    "alone: joint positions."
)
PROJECTED = (
    "File for the projected states. Its columns distance (from the manifold, in units of the recordings) and inside "
    "(1 at the 95 % quantile of held-out samples, more outside) tell of the states as they were given."
)
METHODS = (
    "Of a geodesic. Without a robot: anchored (tied to the data; the default) or leaf (the paper's own error alone). "
    "Around obstacles: sampled (the default where the shortest path is blocked), hinge, springs (the paper's) or "
    "geodesic (the shortest as it is)."
)
POINTS = "(101 along demonstrations; else 50, or around obstacles as many as are checked)"
DEMONSTRATED = "(demonstrated, where the skill knows whole recordings)"


@dataclass(frozen=True)
class Plan:
    """Plan a motion between two states, or through the keyframes of a skill; exit code 1 without success."""

    skill: Annotated[Path, tyro.conf.Positional, shown("SKILL.NPZ")]
    """A saved skill, of either kind."""
    start: Annotated[str | None, shown("STATE", "(keyframes: by inverse kinematics)", STATE)] = None
    goal: Annotated[str | None, shown("STATE", "(keyframes: the last of them)")] = None
    """Last state, in any of these forms."""
    out: Annotated[Path | None, shown("PATH.CSV", "(nothing is written when left out)")] = None
    """File for the path: a header and one row per state."""
    via: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, shown("STATE", "(repeat for more)")] = ()
    """State to pass through, in order."""
    points: Annotated[int | None, shown("N", POINTS)] = None
    """States of the path."""
    route: Annotated[Literal["geodesic", "demonstrated"] | None, shown("{geodesic,demonstrated}", DEMONSTRATED)] = (
        None
    )
    """Shortest path on the manifold, or the way the demonstrations take."""
    method: Annotated[
        Literal["anchored", "leaf", "geodesic", "springs", "hinge", "sampled"] | None, shown("METHOD", "", METHODS)
    ] = None
    robot: Annotated[str | None, shown("ROBOT", "(none: nothing is in the way)")] = None
    """Keep this robot clear of itself and of the scene: jaco, lwr4, nao, planar_arm, or an MJCF or URDF file."""
    scene: Annotated[Path | None, shown("SCENE.JSON", "(nothing around the robot)")] = None
    """Obstacles in the world of the robot's model, as `Scene.save` writes them; metres."""
    margin: Annotated[float | None, shown("METRES", "(0.02)")] = None
    """Clearance to keep where there is room for it."""
    alpha: Annotated[float | None, shown("PERCENT", "(100)")] = None
    """Of keyframes: how much of the variance the envelope keeps; less keeps to its main directions."""
    time: Annotated[float | None, shown("SECONDS", "(1.0)")] = None
    """Of keyframes: how long to plan at most."""
    stop: Annotated[Literal["first", "time"] | None, shown("{first,time}", "(first)")] = None
    """Of keyframes: with the first path, or a better one for as long as there is time."""
    seed: int = 0
    """Of what is sampled to find a way, or a start."""
    recordings: Annotated[tuple[Path, ...], shown("FILE", "(the skill keeps their first and last states)")] = ()
    """The recordings that demo:... refers to."""
    picture: Annotated[Path | None, shown("PICTURE.PNG|.SVG|.PDF", "(none)")] = None
    """Draw the plan: where it leads, each coordinate along it beside the demonstrations, and how well it holds."""
    json: Flag = False
    """Report as JSON, with the states of the path."""

    def run(self) -> int:
        """Plan, write, report."""
        if self.picture:
            draw_off_screen()
            files.writable(self.picture, ".png", ".svg", ".pdf")
        if files.kind(self.skill) == "keyframes":
            from skillfold.cli.keyframe_planning import plan

            return plan(self, obstacles(self.robot, self.scene, self.margin))
        out = None if self.out is None else files.writable(self.out, ".csv")
        skill, around = files.load(self.skill), obstacles(self.robot, self.scene, self.margin)
        plan = self._plan(skill, around)
        if out and plan.success:
            _write_path(out, skill, plan)
        self.draw(skill, plan, around)
        told = _facts(plan, out)
        console.report(
            {**told, "names": list(skill.names), "states": _states(plan)} if self.json else told, self.json
        )
        if not plan.success:
            console.say(f"no path: {plan.reason}")
        return 0 if plan.success else 1

    def draw(self, skill: "SkillManifold | KeyframeSkill", plan: "Planned", around: "Obstacles | None") -> None:
        """The picture, if one is asked for; of a plan that failed, too."""
        if self.picture:
            from skillfold.viewing.plan_pictures import draw_plan

            draw_plan(skill, plan, self.picture, around)

    def _plan(self, skill: "SkillManifold", around: "Obstacles | None") -> "Planned":
        demos = self._demonstrations(skill)
        start, goal = self._ends(skill, demos)
        via = [files.state("--via", text, skill, demos) for text in self.via] or None
        return skill.plan(
            start,
            goal,
            self.points,
            via=via,
            route=self.route,
            method=self.method,
            obstacles=around,
            seed=seed(self.seed),
        )

    def _ends(self, skill: "SkillManifold", demos: "Demonstrations | None") -> tuple[Any, Any]:
        given = [f"--{name}" for name in ("alpha", "time", "stop") if getattr(self, name) is not None]
        if given:
            raise InputError(
                f"{', '.join(given)}: {self.skill} is a skill manifold; these are for skills of keyframes."
            )
        if self.start is None or self.goal is None:
            missing = "--start" if self.start is None else "--goal"
            raise InputError(
                f"{missing}: left out; expected a state, such as demo:0:first. {self.skill} has no keyframes."
            )
        return files.state("--start", self.start, skill, demos), files.state("--goal", self.goal, skill, demos)

    def _demonstrations(self, skill: "SkillManifold") -> "Demonstrations | None":
        from skillfold.demonstrations import Demonstrations

        if not self.recordings:
            return None
        demos = Demonstrations.load(list(self.recordings))
        if demos.names != skill.names:
            raise InputError(
                f"--recordings: coordinates {', '.join(demos.names)}; the skill has {', '.join(skill.names)}. "
                "demo:0:first and demo:0:last need no recordings."
            )
        return demos


def obstacles(robot: str | None, scene: Path | None, margin: float | None) -> "Obstacles | None":
    """What a robot must keep clear of, in a scene or alone; None without a robot."""
    if robot is None:
        if scene is not None:
            raise InputError(f"--scene {scene}: whose obstacles are these? Name the robot, such as --robot lwr4.")
        if margin is not None:
            raise InputError(f"--margin {margin}: whose clearance is this? Name the robot, such as --robot lwr4.")
        return None
    from skillfold.robots.obstacles import MARGIN
    from skillfold.robots.scene import Scene

    kept = MARGIN if margin is None else margin
    return files.load_robot(robot).obstacles(None if scene is None else Scene.load(scene), margin=kept)


@dataclass(frozen=True)
class Project:
    """Bring states onto a skill and write them as CSV, with how far off they were."""

    skill: Annotated[Path, tyro.conf.Positional, shown("SKILL.NPZ")]
    """A saved skill."""
    states: Annotated[Path, tyro.conf.Positional, shown("STATES.CSV")]
    """A header with the skill's coordinates and one row per state; columns demo and t are kept."""
    out: Annotated[Path, shown("OUT.CSV", told=PROJECTED)]
    method: Literal["anchored", "leaf"] = "anchored"
    """Onto the modelled surface, or the paper's iteration."""
    json: Flag = False
    """Report as JSON."""

    def run(self) -> int:
        """Read, project, write, report."""
        from skillfold.io.state_files import read_states, state_columns, write_table

        out = files.writable(self.out, ".csv")
        skill = files.load(self.skill)
        table = read_states(self.states, skill.names)
        distance, inside = skill.distance(table.states), skill.inside(table.states)
        onto = skill.project(table.states, method=self.method)
        measured = {"distance": distance.tolist(), "inside": inside.tolist()}
        write_table(out, {**table.beside, **state_columns(skill.names, onto), **measured})
        console.report(_summary(out, skill, distance), self.json)
        return 0


def _write_path(out: Path, skill: "SkillManifold", plan: "Planned") -> None:
    from skillfold.io.state_files import state_columns, write_table

    write_table(out, state_columns(skill.names, plan.path.states))


def _facts(plan: "Planned", out: Path | None) -> dict[str, Any]:
    from numpy import isfinite

    clearance = plan.stats["check"].clearance if "check" in plan.stats else float("inf")
    return {
        "success": plan.success,
        "reason": plan.reason,
        "route": plan.route,
        "points": len(plan.path),
        "length": plan.length,
        "residual": plan.residual,
        "iterations": plan.iterations,
        "converged": plan.converged,
        "clearance": float(clearance) if isfinite(clearance) else None,
        "start_moved": plan.start_moved,
        "goal_moved": plan.goal_moved,
        "out": str(out) if out and plan.success else None,
    }


def _states(plan: "Planned") -> list[list[float]] | None:
    """A path that failed its check is not handed out."""
    return plan.path.states.tolist() if plan.success else None


def _summary(out: Path, skill: "SkillManifold", distance: Any) -> dict[str, Any]:
    from numpy import median

    return {
        "states": len(distance),
        "median_distance": float(median(distance)),
        "largest_distance": float(distance.max()),
        "within_tolerance": int((distance <= skill.tolerance).sum()),
        "tolerance": skill.tolerance,
        "out": str(out),
    }
