"""The last chapter of `skillfold demo`: a tray with tumblers carried past a box that rises, and pushed on the way."""

import warnings
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.control.pushes import Push
from skillfold.control.rollout import Rollout
from skillfold.control.simulate import simulate
from skillfold.experiments import tray
from skillfold.experiments.rows import Settings
from skillfold.experiments.tumbler_boxes import carrier
from skillfold.experiments.tumbler_runs import TRAY, Trial, calm_duration, carry, controller
from skillfold.motion import Array, Plan
from skillfold.robots.scene import Scene
from skillfold.robots.shapes import Box, Motion

POSES = 200
ENDS = np.array([[0.32, -0.48, 0.62], [0.32, 0.48, 0.62]])  # metres, of the tool
BOX, SIZE = np.array([0.52, 0.0, 0.34]), (0.22, 0.14, 0.60)
UP = np.array([0.0, 0.0, 1.0])
RISE, WHEN = 0.07, (0.15, 0.35)  # metres that the box rises; from and to which share of the motion
SHOVE, AT, LASTING = (10.0, 50.0, -20.0), 0.55, 0.3  # newtons, share of the motion, seconds
NAIVE = "critical"


@dataclass(frozen=True)
class Carrying:
    """What was asked, and two runs of it.

    Attributes:
        skill: that holds the tray level.
        trial: start, goal, duration, push.
        scene: the box and its motion.
        plan: past the box as it stands at first.
        skilled: run of the reactive controller.
        naive: run of the naive arm, pushed the same; no box is in its way.
        seconds: of the fit, of the plan and of the simulated controller's step (median).
    """

    skill: Any
    trial: Trial
    scene: Scene
    plan: Plan
    skilled: Rollout
    naive: Rollout
    seconds: dict[str, float]

    def facts(self) -> dict[str, Any]:
        """What a table shows, in JSON's types."""
        runs = {"skill": self.skilled, "naive": self.naive}
        return {
            "name": "tray with tumblers",
            "dim": self.skill.dim,
            "n_dims": self.skill.n_dims,
            "poses": POSES,
            "fit_seconds": self.seconds["fit"],
            "plan_seconds": self.seconds["plan"],
            "step_seconds": self.seconds["step"],
            "plan_success": self.plan.success,
            "replans": int(self.skilled.facts["replans"]),
            "contacts": len(self.skilled.contacts),
            "clearance": float(self.skilled.clearances.min()),
            "tumblers": TRAY.tumblers,
            "standing": {name: run.standing for name, run in runs.items()},
            "peak_tilt": {name: float(tray.tilt(run.states).max()) for name, run in runs.items()},
        }


def skill_of(rng: np.random.Generator, poses: int = POSES, **options: Any) -> Any:
    """A skill from level poses."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the skill keeps its notes
        return Settings(0).learn(tray.tray_poses(poses, rng, tray.LEVEL_WEIGHT), **options)


def run(rng: np.random.Generator) -> Carrying:
    """Learn, plan, carry, push."""
    begun = perf_counter()
    skill = skill_of(rng)
    return carried(skill, perf_counter() - begun)


def carried(skill: Any, fit: float = 0.0) -> Carrying:
    """Everything after the fit, which took that many seconds."""
    plan, taken = planned(skill)
    duration = calm_duration(np.asarray(plan.path.states))
    push = Push(AT * duration, "link7", SHOVE, LASTING)
    trial = Trial(plan.path.states[0], plan.path.states[-1], duration, push)
    motion = Motion(np.multiply(WHEN, duration), [BOX, BOX + RISE * UP])
    scene = Scene([Box(pose=BOX, size=SIZE, name="box", motion=motion)])
    made = controller("skill", skill, trial, carrier().obstacles(scene), plan)
    skilled = simulate(tray.arm(), made, scene, [push], tray=TRAY)
    naive = carry(NAIVE, skill, trial)
    seconds = {"fit": fit, "plan": taken, "step": float(np.median(skilled.step_times))}
    return Carrying(skill, trial, scene, plan, skilled, naive, seconds)


def planned(skill: Any) -> tuple[Plan, float]:
    """A plan past the box as it stands at first, and the seconds that it took."""
    start, goal = tray.optimum(ENDS, tray.LEVEL_WEIGHT)
    obstacles = carrier().obstacles([Box(pose=BOX, size=SIZE, name="box")])
    begun = perf_counter()
    plan = skill.plan(start, goal, obstacles=obstacles, route="geodesic")
    return plan, perf_counter() - begun


def distance(rollout: Rollout, skill: Any, every: int = 5) -> tuple[Array, Array]:
    """Times and distances from the manifold of every few states of a run."""
    return rollout.times[::every], skill.distance(rollout.states[::every])
