"""Whether a planned path holds what it promises, found without the planner: SciPy's rotations, MuJoCo's contacts.

A pose is inside an envelope if at some s both blocks' squared distances are at most 1: s is looked for on a grid and,
where no place of the grid will do, by golden section between every two stations.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from skillfold.experiments.oracle import finely
from skillfold.motion import Array
from skillfold.robots.robot import Robot
from skillfold.robots.world import World

FINE = 0.005  # rad between the states that are judged
GRID = 40  # places s that are looked at first, at least
CUTS, GOLDEN = 40, 0.5 * (5.0**0.5 - 1.0)
ROUNDING = 1e-9  # of a squared distance


@dataclass(frozen=True)
class Verdict:
    """What was seen along a path.

    Attributes:
        states: how many were judged.
        outside: how many have poses outside.
        excess: largest √d² - 1 of a pose, in gates; negative where all are inside.
        touching: how many touch something.
        beyond: how many break joint limits.
    """

    states: int
    outside: int
    excess: float
    touching: int
    beyond: int


def judge(robot: Robot, world: World, envelope: Any, states: Array) -> Verdict:
    """Of a path (n, D), at every `FINE` rad."""
    states = finely(states, FINE)
    squares = least_squares(envelope, robot.forward(states))
    lower, upper = robot.limits
    beyond = ((states < lower - ROUNDING) | (states > upper + ROUNDING)).any(axis=1)
    excess = float(np.sqrt(squares.max()) - 1.0)
    return Verdict(
        len(states), int((squares > 1 + ROUNDING).sum()), excess, world.touching(states), int(beyond.sum())
    )


def least_squares(envelope: Any, poses: Array) -> Array:
    """Least d² (n,) of poses (n, 7) over all s, 1 at the edge; searched to the end where a grid says 1 or more."""
    y = in_chart(envelope.chart.middle, poses)
    segments = len(envelope.covariances) - 1
    grid = np.linspace(0.0, 1.0, segments * -(-GRID // segments) + 1)
    least = np.array([squared(envelope, np.full(len(y), s), y) for s in grid]).min(axis=0)
    rest = np.flatnonzero(least > 1.0)
    for k in range(segments if len(rest) else 0):
        low, high = np.full(len(rest), k / segments), np.full(len(rest), (k + 1) / segments)
        least[rest] = np.minimum(least[rest], _golden(envelope, y[rest], low, high))
    return least


def squared(envelope: Any, s: Array, y: Array) -> Array:
    """Larger d² (n,) of both blocks of chart coordinates (n, 6), each at its own place s (n,)."""
    segments = len(envelope.covariances) - 1
    k = np.minimum((s * segments).astype(int), segments - 1)
    share = (s * segments - k)[:, None, None, None]
    covariances = (1.0 - share) * envelope.covariances[k] + share * envelope.covariances[k + 1]
    away = (y - (1.0 - s[:, None]) * envelope.ends[0] - s[:, None] * envelope.ends[1]).reshape(-1, 2, 3, 1)
    return (away * np.linalg.solve(covariances, away)).sum(axis=(2, 3)).max(axis=1)


def _golden(envelope: Any, y: Array, low: Array, high: Array) -> Array:
    """Least d² (n,) between places low and high (n,), by golden section: it is convex there."""
    for _ in range(CUTS):
        left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        lower = squared(envelope, left, y) < squared(envelope, right, y)
        low, high = np.where(lower, low, left), np.where(lower, right, high)
    return squared(envelope, 0.5 * (low + high), y)


def in_chart(middle: Array, poses: Array) -> Array:
    """Positions and rotation vectors (n, 6) about a middle rotation."""
    turned = Rotation.from_quat(middle, scalar_first=True).inv() * Rotation.from_quat(poses[:, 3:], scalar_first=True)
    return np.concatenate([poses[:, :3], turned.as_rotvec()], axis=1)
