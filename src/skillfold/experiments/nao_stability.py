"""Whether a Nao on one foot stands: by its centre of mass over the sole, and in dynamics; self-collision apart.

Both judges know the whole robot with its free base and nothing of what was learnt. In dynamics position servos with
the motors' published torques hold the pose for two seconds; it stands if it leans no farther than servos give way.
Where parts of the robot overlap they pass through each other there: such poses are judged like all others, and
counted besides, as in the paper.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from skillfold.experiments.nao_poses import Optimiser
from skillfold.experiments.oracle import finely
from skillfold.motion import Array
from skillfold.robots.falling import Falling
from skillfold.robots.robot import Robot
from skillfold.robots.standing import base_of

SECONDS = 2.0  # that every pose is held
LEANING = 0.15  # rad: more than this from the upright that it was put in counts as fallen
SPEED = 0.5  # rad/s of the fastest joint of a motion, on average
FINE = 0.02  # rad between the states of a motion that are judged


@dataclass(frozen=True)
class Verdict:
    """What the judges say of a pose or a motion.

    Attributes:
        margin: of the centre of mass inside the support polygon, the smallest [m]; negative outside.
        leaning: at the end of the dynamics [rad].
        clearance: between the robot's own shapes, the smallest [m].
    """

    margin: float
    leaning: float
    clearance: float

    @property
    def balanced(self) -> bool:
        """By the centre of mass."""
        return self.margin > 0.0

    @property
    def upright(self) -> bool:
        """In dynamics."""
        return self.leaning < LEANING

    @property
    def collides(self) -> bool:
        """Whether parts of the robot overlap."""
        return self.clearance < 0.0

    @property
    def stable(self) -> bool:
        """By both."""
        return self.balanced and self.upright


@dataclass(frozen=True)
class Count:
    """How many are stable, by whom, and how many collide with themselves, of all and of those that are stable."""

    total: int
    stable: int
    balanced: int
    upright: int
    colliding: int
    both: int

    @property
    def note(self) -> str:
        """In words."""
        return (
            f"of {self.total}: {self.balanced} by the centre of mass, {self.upright} in dynamics; "
            f"{self.colliding} collide with themselves ({self.both} of these among the stable)"
        )


def count(verdicts: list[Verdict]) -> Count:
    """Counts over poses or motions."""
    stable, balanced, upright, collides = (
        sum(getattr(verdict, name) for verdict in verdicts) for name in ("stable", "balanced", "upright", "collides")
    )
    both = sum(verdict.stable and verdict.collides for verdict in verdicts)
    return Count(len(verdicts), stable, balanced, upright, collides, both)


def judge_pose(optimiser: Optimiser, q: Array, pedestal: bool = False) -> Verdict:
    """Both judges of a pose (12,) held for two seconds."""
    return judge_motion(optimiser, q[None], pedestal=pedestal)


def judge_motion(
    optimiser: Optimiser, states: Array, corners: Array | None = None, scene: Any = None, pedestal: bool = False
) -> Verdict:
    """Both judges of a motion: the centre of mass all along it; played slowly, and its last pose held.

    Args:
        optimiser: of the stance.
        states: (n, 12).
        corners: (m, 2) of the support polygon; the stance sole's where left out.
        scene: obstacles that stand around.
        pedestal: whether the stance foot stands so high that the swing leg neither stumbles nor props.
    """
    nao = _nao()
    floor = _floor(optimiser.side if pedestal else "") if scene is None else Falling(nao, scene, own=False)
    fine = finely(states, FINE) if len(states) > 1 else states
    whole = optimiser.robot.whole(fine)
    bases = base_of(nao, whole, optimiser.robot.stance)
    centres = nao.center_of_mass(whole, base=bases)[:, :2]
    floor.reset(whole[0], bases[0])
    if len(states) > 1:
        floor.follow(whole, lasting(states))
    floor.hold(SECONDS)
    margin = float(support_margin(centres, optimiser.polygon if corners is None else corners).min())
    return Verdict(margin, floor.leaning(bases[-1]), float(nao.self_clearance(whole).min()))


def lasting(states: Array) -> float:
    """Seconds of a slow motion (n, 12): its fastest joint at a given speed on average."""
    return max(float(np.abs(np.diff(states, axis=0)).sum(0).max()) / SPEED, 0.1)


def support_margin(points: Array, corners: Array) -> Array:
    """Signed distances (n,) of points (n, 2) from the edges of a convex polygon (m, 2), positive inside."""
    edges = np.roll(corners, -1, axis=0) - corners
    inward = np.stack([-edges[:, 1], edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, None]
    middle = corners.mean(0)
    inward *= np.sign(((middle - corners) * inward).sum(1))[:, None]
    return ((points[:, None] - corners) * inward).sum(2).min(1)


@cache
def _nao() -> Robot:
    return Robot.load("nao")


@cache
def _floor(side: str) -> Falling:
    """Flat ground; a pedestal for a stance foot."""
    swinging = {"left": "R", "right": "L"}.get(side)
    passing = [f"{swinging}{part}Link" for part in ("HipPitch", "KneePitch", "AnkleRoll") if swinging]
    return Falling(_nao(), own=False, passing=passing)
