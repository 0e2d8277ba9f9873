"""Joint positions as users give them."""

from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.tables import Array


def read_joint_positions(q: Any, dof: int, name: str) -> tuple[Array, tuple[int, ...]]:
    """Joint positions as contiguous (n, dof), and their batch shape.

    Raises:
        InputError: another shape, not numbers, or not finite.
    """
    try:
        array = np.asarray(q, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: joint positions must be numbers (..., {dof}): {error}.") from None
    if array.ndim == 0 or array.shape[-1] != dof:
        raise InputError(f"{name}: joint positions of shape {array.shape}; expected (..., {dof}), one a joint.")
    states = np.ascontiguousarray(array.reshape(-1, dof))
    if not np.isfinite(states).all():
        row, column = (int(i) for i in np.argwhere(~np.isfinite(states))[0])
        raise InputError(f"{name}: joint {column} of state {row} is {states[row, column]}; expected a finite number.")
    return states, array.shape[:-1]
