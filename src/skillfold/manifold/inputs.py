"""What users hand to a skill, read and checked: the only door by which their values come in."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skillfold.consistency import UNIT_TOLERANCE
from skillfold.errors import InputError
from skillfold.motion import is_real
from skillfold.recordings import LARGEST, shortened
from skillfold.spaces import StateSpace

Array = np.ndarray[Any, np.dtype[np.float64]]

REAL = "iuf"  # kinds of NumPy types that are real numbers; complex ones, flags, dates and text are none
MANY = 10_000_000  # states or steps in one answer: more are a slip, and would not fit into memory
SEEDS = 2**32 - 1


def read_states(x: Any, names: Sequence[str]) -> Array:
    """States (..., D) as finite numbers, one for each name.

    Raises:
        InputError: says what was given and what was expected.
    """
    array = x if is_real(x) else read_numbers(x, "States", f"(..., {len(names)})")
    if array.ndim == 0 or array.shape[-1] != len(names):
        raise InputError(f"Expected states (..., {len(names)}) of {', '.join(names)}; got shape {array.shape}.")
    # Nothing but numbers passes the comparison, and where the sum of squares is small each of them is.
    if np.vdot(array, array) < LARGEST**2:
        return array
    usable = np.abs(array) < LARGEST
    if not usable.all():
        where = tuple(int(i) for i in np.argwhere(~usable)[0])
        raise InputError(
            f"State value at {where} is {array[where]:g}; expected a finite number below {LARGEST:g} in size."
        )
    return array


def read_query(start: Any, goal: Any, via: Any, names: Sequence[str], space: StateSpace) -> Array:
    """Start, via points and goal in their order; (2 + m, D). Quaternions must be of unit length."""
    states = _in_order(start, goal, via, names)
    for columns in space.quaternions:
        lengths = np.linalg.norm(states[:, columns], axis=1)
        bad = np.flatnonzero(~(np.abs(lengths - 1.0) <= UNIT_TOLERANCE))
        if len(bad):
            row = int(bad[0])
            which = "start" if row == 0 else "goal" if row == len(states) - 1 else f"via {row - 1}"
            raise InputError(
                f"{which}: quaternion {states[row, columns].tolist()} of length {lengths[row]:.4g}; expected length "
                f"1 to within {UNIT_TOLERANCE:g}, scalar first."
            )
    return states


def _in_order(start: Any, goal: Any, via: Any, names: Sequence[str]) -> Array:
    first, last = read_states(start, names), read_states(goal, names)
    for name, state in ("start", first), ("goal", last):
        if state.ndim != 1:
            raise InputError(f"{name}: expected one state ({len(names)},), got shape {state.shape}.")
    # An empty list has no columns, and is no mistake.
    if via is None or read_numbers(via, "via", f"(m, {len(names)})").size == 0:
        return np.array((first, last))
    middle = read_states(via, names)
    if middle.ndim > 2:
        raise InputError(f"via: expected states (m, {len(names)}), got shape {middle.shape}.")
    return np.vstack([first, middle, last])


def read_path(near: Any, names: Sequence[str]) -> Array:
    """States (n, D) of a path, two or more."""
    states = read_states(near, names)
    if states.ndim != 2 or len(states) < 2:
        raise InputError(f"near: expected the states of a path (n, {len(names)}), two or more; got {states.shape}.")
    return states


def read_numbers(values: Any, what: str, shape: str) -> Array:
    """`values` as float64, if they are real numbers in a rectangular array; `shape` is what to expect, in words."""
    if is_real(values):
        return values
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        raise InputError(f"{what} must be numbers {shape}; got ragged rows: {shortened(values)}.") from None
    if array.size and array.dtype.kind not in REAL:
        raise InputError(f"{what} must be numbers {shape}; got {shortened(values)}.")
    if np.ma.is_masked(values):
        raise InputError(f"{what} must be numbers {shape}; some are masked.")
    with np.errstate(over="ignore"):  # wider floats may become infinite, which is caught as such
        return np.asarray(array, dtype=np.float64)


def check_obstacles(obstacles: Any, n_dims: int) -> None:
    """Raise unless they answer as obstacles do, for states of that many coordinates."""
    possible = "PointObstacles(points, reach) or robot.obstacles(scene)"
    asked = ("clearance", "compiled", "bounds", "margin", "resolution", "nearest")
    if isinstance(obstacles, type) or not all(hasattr(obstacles, name) for name in asked):
        raise InputError(f"obstacles={shortened(obstacles)}; expected {possible}.")
    if len(obstacles.bounds[0]) != n_dims:
        raise InputError(
            f"The obstacles are for states of {len(obstacles.bounds[0])} coordinates, the skill has {n_dims}."
        )


def together(a: Array, b: Array) -> tuple[Array, Array]:
    """Both broadcast to one shape."""
    try:
        shape = np.broadcast_shapes(a.shape, b.shape)
    except ValueError:
        raise InputError(f"States of shapes {a.shape} and {b.shape} do not go together.") from None
    return np.broadcast_to(a, shape), np.broadcast_to(b, shape)


def whole(name: str, value: Any, low: int, high: int, or_none: bool = False) -> int:
    """`value`, if it is a whole number from `low` to `high`; flags are none."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not low <= value <= high:
        last = ", or None" if or_none else ""
        raise InputError(f"{name}={shortened(value)}; expected a whole number from {low} to {high}{last}.")
    return int(value)


def seed_of(value: Any) -> int:
    """`value`, if it is a seed: without one, nothing could be done twice."""
    return whole("seed", value, 0, SEEDS)


def amount(name: str, value: Any, high: float = LARGEST, zero: bool = False) -> float:
    """`value`, if it is a number above 0, or 0 itself where `zero` allows it, and at most `high`."""
    real = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    # Compared as narrow floats, LARGEST would overflow.
    size = float(value) if isinstance(value, np.floating) else value
    if not real or not 0 <= size <= high or (value == 0 and not zero):
        kind = "number of 0 or more" if zero else "positive number"
        raise InputError(f"{name}={shortened(value)}; expected a {kind}, {high:g} at most.")
    return float(value)


def choice(name: str, value: Any, possible: Sequence[str]) -> str:
    """`value`, if it is one of the words that are possible."""
    if not isinstance(value, str) or value not in possible:
        raise InputError(f"{name}={shortened(value)}; possible: {', '.join(possible)}.")
    return value
