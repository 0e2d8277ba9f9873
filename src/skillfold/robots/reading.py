"""Joint positions, base poses and numbers as users give them."""

from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.robots.poses import read_pose
from skillfold.tables import Array

MANY = 2**32  # seeds are smaller, and so is whatever fits into memory


def read_joint_positions(q: Any, dof: int, name: str) -> tuple[Array, tuple[int, ...]]:
    """Joint positions as contiguous (n, dof), and their batch shape.

    Raises:
        InputError: another shape, not numbers, or not finite.
    """
    try:
        with np.errstate(over="ignore"):  # wider floats may become infinite, which is caught as such
            array = np.asarray(q, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name}: joint positions must be numbers (..., {dof}): {error}.") from None
    if array.ndim == 0 or array.shape[-1] != dof:
        raise InputError(f"{name}: joint positions of shape {array.shape}; expected (..., {dof}), one a joint.")
    states = np.ascontiguousarray(array.reshape(-1, dof))
    if not np.isfinite(states).all():
        row, column = (int(i) for i in np.argwhere(~np.isfinite(states))[0])
        raise InputError(f"{name}: joint {column} of state {row} is {states[row, column]}; expected a finite number.")
    return states, array.shape[:-1]


def read_bases(base: Any, shape: tuple[int, ...]) -> Array:
    """Poses (..., 7) of a base that go together with joint positions of batch shape `shape`.

    Raises:
        InputError: no poses, or of another batch shape.
    """
    poses = read_pose(base, "base")
    try:
        np.broadcast_shapes(poses.shape[:-1], shape)
    except ValueError:
        raise InputError(
            f"base: poses of batch shape {poses.shape[:-1]}, joint positions of {shape}; they do not go together."
        ) from None
    return poses


def read_whole(value: Any, name: str) -> int:
    """A whole number, 0 or more.

    Raises:
        InputError: anything else.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 0 <= value < MANY:
        raise InputError(f"{name}={value!r:.40}; expected a whole number from 0 to {MANY - 1}.")
    return int(value)


def read_amount(value: Any, what: str, unit: str) -> float:
    """A finite number, 0 or more.

    Raises:
        InputError: anything else.
    """
    real = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not real or not 0 <= value < np.inf:
        raise InputError(f"{what} {value!r:.40}; expected {unit}, zero or more.")
    return float(value)
