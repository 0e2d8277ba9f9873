"""A tray with three tumblers that stand free, carried by the LWR4 and pushed: how one run goes, and many.

The skill holds the tray level (`tray.tray_poses`). Four controllers carry it from the same start to the same goal in
the same time, under the same push: the reactive one as a user gets it, and computed torque along a quintic in joint
space: with the gains that the reactive one has along the manifold, with the same stiffness damped critically, and at
the stiffest that stays calm. How long a motion takes follows from what tumblers stand: the tool's acceleration stays
below a part of what tips them.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.baselines.quintic import Quintic
from skillfold.control.pushes import Push
from skillfold.control.reactive import ReactiveController
from skillfold.control.rollout import Rollout
from skillfold.control.settings import Gains
from skillfold.control.simulate import simulate
from skillfold.control.timing import Reference, follow, time_path
from skillfold.control.tracking import JointTracker
from skillfold.experiments import tray
from skillfold.motion import Array
from skillfold.robots.tray import Tray

SAMPLES = 400
APART = 0.5  # metres between start and goal at least
CALM = 2.0  # m/s², most that the tool is accelerated by a motion; tumblers tip at 4.9, held
LATENCY = 0.03  # seconds after which a plan counts: runs can be repeated
BODIES = {"forearm": "link5", "tool": "link7"}
SHORT, SLOW = (0.1, 0.3), 1.5  # seconds of a push
FORCES = {"short": (20.0, 80.0), "slow": (20.0, 60.0)}  # newtons
BEGIN = (0.1, 0.6)  # share of the motion after which a push begins
STIFFEST = 1600.0  # 1/s²: what the reactive controller holds with off the manifold
METHODS = ("skill", "naive", "critical", "stiff")
# ω² [1/s²] and ζ of the naive arm.
NAIVE = {"naive": (Gains().along, Gains().along_damping), "critical": (Gains().along, 1.0), "stiff": (STIFFEST, 1.0)}
TRAY = Tray()


@dataclass(frozen=True)
class Trial:
    """What is asked of every controller.

    Attributes:
        start, goal: (7,) level poses.
        duration: of the motion [s].
        push: on the way, or None.
    """

    start: Array
    goal: Array
    duration: float
    push: Push | None = None


@dataclass(frozen=True)
class Outcome:
    """What became of a trial.

    Attributes:
        standing: tumblers that stand at the end.
        tilt: largest of the tray [rad].
        gives: farthest the tool is from the way it goes unpushed, while it is pushed [m].
        replans: plans taken up.
        missed: from the goal at the end [rad].
    """

    standing: int
    tilt: float
    gives: float
    replans: int
    missed: float

    @property
    def stood(self) -> bool:
        """Whether all tumblers stand."""
        return self.standing == TRAY.tumblers


def skill_of(settings: Any, rng: np.random.Generator, samples: int = SAMPLES) -> Any:
    """The skill that holds a tray level."""
    return settings.learn(tray.tray_poses(samples, rng, tray.LEVEL_WEIGHT))


def trials(skill: Any, count: int, rng: np.random.Generator, body: str = "", kind: str = "short") -> list[Trial]:
    """Trials between random ends; pushed on a body of `BODIES`, "short" or "slow", if one is named."""
    found: list[Trial] = []
    while len(found) < count:
        start, goal = tray.tray_poses(2, rng, tray.LEVEL_WEIGHT)
        plan = skill.plan(start, goal, route="geodesic")
        if not plan.success or np.linalg.norm(np.subtract(*tray.positions(np.stack([start, goal])))) < APART:
            continue
        duration = calm_duration(plan.path.states)
        found.append(Trial(start, goal, duration, push(rng, duration, body, kind) if body else None))
    return found


def push(rng: np.random.Generator, duration: float, body: str, kind: str) -> Push:
    """A push in a random direction at a random time of a motion."""
    lasting = rng.uniform(*SHORT) if kind == "short" else SLOW
    direction = rng.standard_normal(3)
    force = rng.uniform(*FORCES[kind]) * direction / np.linalg.norm(direction)
    return Push(float(rng.uniform(*BEGIN) * duration), BODIES[body], force, float(lasting))


def calm_duration(path: Array) -> float:
    """Seconds that a motion along a path (n, 7) takes so that the tool is accelerated no more than `CALM`."""
    robot = tray.arm()
    reference = time_path(path, robot.velocity_limits, robot.acceleration_limits)
    times = np.arange(0.0, reference.duration, 5e-3)
    tool = tray.positions(np.array([reference.at(time)[0] for time in times]))
    most = np.linalg.norm(np.diff(tool, 2, axis=0), axis=1).max() / 5e-3**2
    return reference.duration * max(1.0, float(np.sqrt(most / CALM)))


def controller(method: str, skill: Any, trial: Trial, obstacles: Any = None, plan: Any = None) -> Any:
    """One of `METHODS`, ready for a trial."""
    robot, load = tray.arm(), TRAY.load
    if method == "skill":
        plan = plan or skill.plan(trial.start, trial.goal, route="geodesic")
        options: dict[str, Any] = {"robot": robot, "obstacles": obstacles, "load": load, "latency": LATENCY}
        return ReactiveController(skill, plan, duration=trial.duration, **options)
    return JointTracker(quintic(trial), robot, *NAIVE[method], load=load)


def quintic(trial: Trial) -> Reference:
    """All joints in proportion, from start to goal."""
    return follow(Quintic.between(trial.start, trial.goal, trial.duration).trajectory())


def carry(method: str, skill: Any, trial: Trial) -> Rollout:
    """A run of one controller, a while beyond its end."""
    pushes = [trial.push] if trial.push else []
    return simulate(tray.arm(), controller(method, skill, trial), pushes=pushes, tray=TRAY)


def outcome(rollout: Rollout, trial: Trial, way: Array) -> Outcome:
    """What a run came to; `way` (n, 3) the tool takes unpushed."""
    pushed = trial.push
    during = (rollout.times >= pushed.time) & (rollout.times <= pushed.end) if pushed else np.zeros(1, bool)
    gives = _farthest(rollout.tool_poses[during, :3], way) if during.any() else 0.0
    missed = float(np.linalg.norm(rollout.states[-1] - trial.goal))
    tilt = float(tray.tilt(rollout.states).max())
    return Outcome(rollout.standing, tilt, gives, int(rollout.facts["replans"]), missed)


def run(method: str, skill: Any, trial: Trial) -> Outcome:
    """Carry, and say what came of it."""
    made = controller(method, skill, trial)
    times = np.linspace(0.0, trial.duration, 200)
    way = tray.positions(np.array([made.reference.at(time)[0] for time in times]))
    return outcome(carry(method, skill, trial), trial, way)


def _farthest(points: Array, way: Array) -> float:
    """Largest distance of points (n, 3) from the nearest of a way (m, 3)."""
    from scipy.spatial import KDTree

    return float(KDTree(way).query(points)[0].max())
