"""`skillfold simulate`: a planned motion in closed loop, with pushes and obstacles."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from skillfold.cli import console, files
from skillfold.cli.options import Flag, seed, shown
from skillfold.cli.screen import draw_off_screen
from skillfold.errors import InputError

if TYPE_CHECKING:
    from skillfold.control.pushes import Push
    from skillfold.control.rollout import Rollout

PUSH = (
    'A push, such as "t=0.25 link=5 force=60,0,0 duration=0.2": seconds, a body by its name or the number of '
    "the joint that moves it, newtons in world axes. Repeat for more."
)
STATE = "First state: numbers such as 0.1,0.2,0.3 [rad]; states.csv:3, a row of a file; demo:0:first of a recording."
FRAMES = 25.0  # pictures a second
LATENCY = 0.03  # seconds of the run that planning anew is taken to last, whatever it takes here


@dataclass(frozen=True)
class Simulate:
    """Plan the shortest motion and run it on a simulated robot, pushed, among obstacles; exit code 1 without one."""

    skill: Annotated[Path, tyro.conf.Positional, shown("SKILL.NPZ")]
    """A saved skill over a robot's joints."""
    robot: Annotated[str, shown("ROBOT")]
    """Bundled robot (jaco, lwr4, planar_arm), or an MJCF or URDF file."""
    start: Annotated[str, shown("STATE", told=STATE)]
    goal: Annotated[str, shown("STATE")]
    """Last state, in any of these forms."""
    scene: Annotated[Path | None, shown("SCENE.JSON", "(nothing around the robot)")] = None
    """Obstacles, as `Scene.save` writes them. The robot keeps clear of itself, too."""
    push: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, shown("PUSH", "(none)", PUSH)] = ()
    duration: Annotated[float | None, shown("SECONDS", "(as short as the robot's limits allow)")] = None
    """Of the motion."""
    tray: Flag = False
    """Let the tool carry a tray with three tumblers that stand free."""
    noise: float = 0.0
    """Standard deviation [rad] of the positions that the controller sees; of velocities ten times as much."""
    seed: int = 0
    """Of the noise, and of what is sampled to find a way around obstacles."""
    out: Annotated[Path | None, shown("RUN.NPZ|RUN.CSV", "(nothing is written when left out)")] = None
    """File for the run."""
    video: Annotated[Path | None, shown("RUN.GIF|RUN.MP4|FOLDER", "(no pictures)")] = None
    """File for a video (.mp4 needs ffmpeg), or a folder for pictures."""
    json: Flag = False
    """Report as JSON."""

    def run(self) -> int:
        """Plan, simulate, write, report."""
        pushes, chosen = [push(text) for text in self.push], seed(self.seed)
        out, video = self.out and files.writable(self.out, ".npz", ".csv"), self.video and _video(self.video)
        rollout = self._rollout(pushes, chosen)
        if rollout is None:
            return 1
        if out:
            rollout.save(out)
        pictures = self._film(rollout, video) if video else 0
        console.report(_facts(rollout) | {"out": out and str(out), "pictures": pictures}, self.json)
        return 0

    def _rollout(self, pushes: "list[Push]", chosen: int) -> "Rollout | None":
        from skillfold.control.reactive import ReactiveController
        from skillfold.control.simulate import simulate
        from skillfold.robots.tray import Tray

        skill, robot = files.load(self.skill), files.load_robot(self.robot)
        scene, tray = self._scene(), Tray() if self.tray else None
        obstacles = robot.obstacles(scene)
        ends = [files.state("--start", self.start, skill, None), files.state("--goal", self.goal, skill, None)]
        plan = skill.plan(*ends, route="geodesic", obstacles=obstacles, seed=chosen)
        if not plan.success:
            console.say(f"no path: {plan.reason}")
            return None
        controller = ReactiveController(
            skill,
            plan,
            robot=robot,
            obstacles=obstacles,
            duration=self.duration,
            latency=LATENCY,
            load=(0.0, (0.0, 0.0, 0.0)) if tray is None else tray.load,
        )
        return simulate(robot, controller, scene, pushes, chosen, tray=tray, noise=self.noise)

    def _scene(self) -> Any:
        from skillfold.robots.scene import Scene

        return None if self.scene is None else Scene.load(self.scene)

    def _film(self, rollout: "Rollout", path: Path) -> int:
        from skillfold.io.video_files import write_video
        from skillfold.robots.rendering import pictures
        from skillfold.robots.robot import Robot
        from skillfold.robots.tray import Tray
        from skillfold.robots.world import World

        world = World(Robot.load(self.robot), self._scene(), Tray() if self.tray else None, visual=True)
        step = rollout.times[-1] / max(len(rollout) - 1, 1)
        chosen = slice(None, None, max(round(1 / (FRAMES * step)), 1)) if step > 0 else slice(None)
        shown = pictures(world, rollout.times[chosen], rollout.states[chosen], rollout.tumblers[chosen])
        return write_video(path, shown, FRAMES)


def push(text: str) -> "Push":
    """A push from text such as "t=0.25 link=5 force=60,0,0 duration=0.2".

    Raises:
        InputError: says what was given and what was expected.
    """
    from skillfold.control.pushes import Push

    wanted = InputError(f"--push {text!r}: expected t=SECONDS link=BODY force=X,Y,Z duration=SECONDS.")
    parts = [part.partition("=") for part in text.split()]
    values = {name: value for name, _, value in parts}
    if len(parts) != 4 or set(values) != {"t", "link", "force", "duration"}:
        raise wanted
    link = values["link"]
    try:
        force = [float(part) for part in values["force"].split(",")]
        time, duration = float(values["t"]), float(values["duration"])
    except ValueError:
        raise wanted from None
    return Push(time=time, body=int(link) if link.isdecimal() else link, force=force, duration=duration)


def _video(path: Path) -> Path:
    """The path, if it can be written; before MuJoCo is loaded, which must know that there is no display."""
    from skillfold.io.video_files import check_video

    draw_off_screen()
    return files.writable(check_video(path)) if path.suffix else files.folder(path)


def _facts(rollout: "Rollout") -> dict[str, Any]:
    from numpy import isfinite, percentile

    clearance, tumblers = float(rollout.clearances.min()), rollout.tumblers.shape[1]
    return {
        "seconds": float(rollout.times[-1]),
        "steps": len(rollout),
        "last_state": [round(value, 6) for value in rollout.states[-1].tolist()],
        "replans": rollout.facts["replans"],
        "modes": [f"{mode} {rollout.count(mode)}" for mode in dict.fromkeys(rollout.modes.tolist())],
        "largest_distance": float(rollout.distances.max()),
        "last_distance": float(rollout.distances[-1]),
        "least_clearance": clearance if isfinite(clearance) else None,
        "contacts": [f"{c.first} to {c.second} at {c.start:.3f} s" for c in rollout.contacts],
        "tumblers_standing": f"{rollout.standing} of {tumblers}" if tumblers else None,
        "step_microseconds": [round(float(v), 1) for v in percentile(1e6 * rollout.step_times, [50, 99.9])],
    }
