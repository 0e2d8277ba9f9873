"""Whether a planned path holds what it promises, found without the planner: SciPy's rotations, MuJoCo's contacts.

A pose is inside an envelope if at some s both blocks' squared distances are at most 1: s is looked for on a grid and,
where no place of the grid will do, by SciPy between its neighbours.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from skillfold.experiments.oracle import finely
from skillfold.motion import Array
from skillfold.robots.robot import Robot
from skillfold.robots.world import World

FINE = 0.005  # rad between the states that are judged
GRID = 41  # places s that are looked at first
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
    """Least d² (n,) of poses (n, 7) over all s, 1 at the edge; no less than 1 only where that has been searched."""
    y = in_chart(envelope.chart.middle, poses)
    grid = np.linspace(0.0, 1.0, GRID)
    squares = np.array([squared(envelope, s, y) for s in grid])
    least, at = squares.min(axis=0), squares.argmin(axis=0)
    for i in np.flatnonzero(least > 1.0):
        bounds = grid[max(at[i] - 1, 0)], grid[min(at[i] + 1, GRID - 1)]
        found: Any = minimize_scalar(
            lambda s, i=i: squared(envelope, s, y[i : i + 1])[0],
            bounds=bounds,
            method="bounded",
            options={"xatol": 1e-7},
        )
        least[i] = min(least[i], found.fun)
    return least


def squared(envelope: Any, s: float, y: Array) -> Array:
    """Larger d² (n,) of both blocks of chart coordinates (n, 6), at one place s."""
    stations = len(envelope.covariances) - 1
    k = min(int(s * stations), stations - 1)
    share = s * stations - k
    covariances = (1.0 - share) * envelope.covariances[k] + share * envelope.covariances[k + 1]
    away = (y - (1.0 - s) * envelope.ends[0] - s * envelope.ends[1]).reshape(-1, 2, 3)
    blocks = [
        np.einsum("ni,in->n", v, np.linalg.solve(c, v.T))
        for v, c in zip(away.swapaxes(0, 1), covariances, strict=True)
    ]
    return np.maximum(*blocks)


def in_chart(middle: Array, poses: Array) -> Array:
    """Positions and rotation vectors (n, 6) about a middle rotation."""
    turned = Rotation.from_quat(middle, scalar_first=True).inv() * Rotation.from_quat(poses[:, 3:], scalar_first=True)
    return np.concatenate([poses[:, :3], turned.as_rotvec()], axis=1)
