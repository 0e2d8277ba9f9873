"""The tray carried past boxes that were never shown, while the box in the way moves farther into it.

Arm, tray and the room of standing tumblers must stay clear. Every case can be solved: the box comes no nearer to the
arm than it can stop, the goal stays clear, and from where the arm is then a way of level poses is known that is clear
of the box where it comes to stand. The controller sees where boxes are, not where they will be.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from skillfold.control.rollout import Rollout
from skillfold.control.simulate import simulate
from skillfold.control.timing import time_path
from skillfold.experiments import tray
from skillfold.experiments.tray_cases import CLEAR, SceneCase, past_boxes, way_round
from skillfold.experiments.tumbler_runs import TRAY, Trial, calm_duration, controller
from skillfold.motion import Array, Plan
from skillfold.robots.scene import Scene
from skillfold.robots.shapes import Motion

if TYPE_CHECKING:
    from skillfold.robots.obstacles import Obstacles
    from skillfold.robots.robot import Robot

MOVES = (0.05, 0.10)  # metres that the box moves
WHEN, LASTING = (0.1, 0.3), 0.4  # share of the motion after which it begins; seconds
AHEAD = 0.8  # seconds from its end for which the arm's way stays clear of it
ROOM = 0.03  # metres that are clear so long
STEP = 0.02  # seconds between states of the planned way that are looked at
ATTEMPTS = 10  # moves that are tried in a scene
PATIENCE = 4.0  # times its duration after which a run is given up
JUMP = 1.5  # times the acceleration limit that the velocity of a reference may change by


@dataclass(frozen=True)
class BoxTrial:
    """What is asked: a trial, and the scene with the motion of its box.

    Attributes:
        trial: start, goal, duration.
        scene: boxes; the first moves.
        plan: among them as they stand at first.
    """

    trial: Trial
    scene: Scene
    plan: Plan


@dataclass(frozen=True)
class Passing:
    """What became of it.

    Attributes:
        standing: tumblers at the end.
        contacts: of arm or tray with a box or with the arm.
        clearance: smallest [m], of the arm and of the tray with the room of the tumblers.
        jump: largest change of the reference's velocity between samples, in shares of what the limits allow.
        replans: plans taken up.
        missed: from the goal at the end [rad].
        tilt: largest of the tray [rad].
        why: what the controller said last.
    """

    standing: int = 0
    contacts: int = 0
    clearance: float = np.nan
    jump: float = np.nan
    replans: int = 0
    missed: float = np.inf
    tilt: float = np.nan
    why: str = ""

    @property
    def safe(self) -> bool:
        """No contact, a smooth reference, every tumbler standing."""
        return not self.contacts and self.jump <= JUMP and self.standing == TRAY.tumblers

    @property
    def arrived(self) -> bool:
        """Whether it also came to its goal."""
        return self.safe and self.missed < 0.05


class Watched:
    """A controller whose references are kept, and which is done after some time whether it has arrived or not."""

    def __init__(self, inner: Any, patience: float) -> None:
        self._inner, self._patience, self._time = inner, patience, 0.0
        self.velocities: list[Array] = []

    @property
    def done(self) -> bool:
        """Whether it has arrived, or had its time."""
        return self._inner.done or self._time > self._patience

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)

    def command(self, t: float, q: Any, qd: Any) -> Any:
        """As the controller's own."""
        self._time, answer = t, self._inner.command(t, q, qd)
        self.velocities.append(answer.reference[1])
        return answer


@cache
def carrier() -> "Robot":
    """The arm with the tray, and room for standing tumblers."""
    return tray.arm().with_tray(TRAY)


def box_trial(skill: Any, rng: np.random.Generator) -> BoxTrial:
    """A case in which the box can move into the planned way so that there is still another."""
    while True:
        found = _moving(skill, past_boxes(1, rng, robot=carrier())[0], rng)
        if found:
            return found


def carry_past(skill: Any, asked: BoxTrial) -> tuple[Rollout, Passing]:
    """A run of the reactive controller, and what came of it."""
    robot, obstacles = tray.arm(), carrier().obstacles(asked.scene)
    made = Watched(controller("skill", skill, asked.trial, obstacles, asked.plan), PATIENCE * asked.trial.duration)
    rollout = simulate(robot, made, asked.scene, tray=TRAY)
    steps = np.abs(np.diff(made.velocities, axis=0)).max(axis=0) / (rollout.facts["step"] * robot.acceleration_limits)
    missed = float(np.linalg.norm(rollout.states[-1] - asked.trial.goal))
    return rollout, Passing(
        rollout.standing,
        len(rollout.contacts),
        float(rollout.clearances.min()),
        float(steps.max()),
        int(rollout.facts["replans"]),
        missed,
        float(tray.tilt(rollout.states).max()),
        made.reason,
    )


def passing(skill: Any, seed: int) -> Passing:
    """What came of a fresh case."""
    asked = box_trial(skill, np.random.default_rng(seed))
    return carry_past(skill, asked)[1] if asked.plan.success else Passing(why=asked.plan.reason)


def _moving(skill: Any, case: SceneCase, rng: np.random.Generator) -> BoxTrial | None:
    """The case with its first box in motion; None where no move is found that leaves a way."""
    box: Any = case.scene.shapes[0]
    obstacles = carrier().obstacles(case.scene, movable=[box.name])
    plan = skill.plan(case.start, case.goal, obstacles=obstacles, route="geodesic")
    # Where no plan is found, the oracle's path still tells where the box would be in the way.
    way = np.asarray(plan.path.states) if plan.success else case.oracle
    trial = Trial(case.start, case.goal, calm_duration(way))
    robot = tray.arm()
    reference = time_path(way, robot.velocity_limits, robot.acceleration_limits, trial.duration)
    for _ in range(ATTEMPTS):
        begin, after = float(rng.uniform(*WHEN) * trial.duration), _aside(box.pose, way, rng)
        motion = Motion([begin, begin + LASTING], [box.pose, after])
        if _is_fair(obstacles, box.name, motion, reference, case.goal):
            return BoxTrial(trial, Scene([replace(box, motion=motion), *case.scene.shapes[1:]]), plan)
    return None


def _aside(pose: Array, way: Array, rng: np.random.Generator) -> Array:
    """A pose (7,) nearer to the tray's way (n, 7), within half a right angle or so."""
    tools = tray.positions(way) + np.array([0.0, 0.0, TRAY.height + TRAY.length / 2])
    toward = tools[np.argmin(np.linalg.norm(tools - pose[:3], axis=1))] - pose[:3]
    direction = toward / max(float(np.linalg.norm(toward)), 1e-9) + 0.5 * rng.standard_normal(3)
    after = np.array(pose)
    after[:3] += rng.uniform(*MOVES) * direction / np.linalg.norm(direction)
    return after


def _is_fair(obstacles: "Obstacles", box: str, motion: Motion, reference: Any, goal: Array) -> bool:
    """Whether the box comes into the way, not onto the arm or the goal, and leaves a way from where the arm is."""
    begin, end = motion.times
    after = obstacles.move(box, motion.poses[-1])
    states = np.array([reference.at(time)[0] for time in np.arange(0.0, reference.duration, STEP)])
    first, soon = round(begin / STEP), round((end + AHEAD) / STEP)
    if soon + 1 >= len(states) or after.clearance(goal) < 2 * CLEAR:
        return False
    clear = after.clearance(states[first:])
    if clear[: soon - first].min() < ROOM or clear[soon - first :].min() > 0:
        return False
    halfway = obstacles.move(box, motion.at((begin + end) / 2))
    return halfway.clearance(states[first:soon]).min() > 0 and way_round(states[soon], goal, after) is not None
