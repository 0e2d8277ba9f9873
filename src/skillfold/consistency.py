"""Recordings brought into one form: column names, state space, quaternion signs, angles without jumps."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skillfold.errors import RecordingError
from skillfold.recordings import Recording, check_words, checked_states, shortened
from skillfold.spaces import StateSpace

Array = np.ndarray[Any, np.dtype[np.float64]]

# Farther than this from unit length a quaternion is a mistake, not rounding.
UNIT_TOLERANCE = 1e-2
# Sensors may report a joint this far beyond its stop [units of the coordinate].
LIMIT_TOLERANCE = 1e-2


def in_one_form(
    recordings: Sequence[Recording], names: Any, space: Any
) -> tuple[list[Array], tuple[str, ...], StateSpace]:
    """Checked and consistent states of each recording, their coordinate names and their space.

    Raises:
        RecordingError: names the place, row, column and value.
    """
    known = () if names is None else column_names(names)
    check_words([r.label for r in recordings], "label", "labels")
    arrays = [checked_states(r, known) for r in recordings]
    known = known or _default_names(arrays, recordings)
    space = _default_space(known) if space is None else _fitting(space, known)
    return _consistent(arrays, recordings, known, space), known, space


def column_names(names: Any) -> tuple[str, ...]:
    """Coordinate names as a tuple, checked."""
    if isinstance(names, str) or not hasattr(names, "__iter__"):
        raise RecordingError(f"names: got {shortened(names)}; expected a list of one name for each column.")
    return check_words(list(names), "name", "names")


def _default_names(arrays: Sequence[Array], recordings: Sequence[Recording]) -> tuple[str, ...]:
    """x0, x1, … for arrays that must agree in their number of columns."""
    n = arrays[0].shape[1]
    for states, recording in zip(arrays, recordings, strict=True):
        if states.shape[1] != n:
            raise RecordingError(
                f"{recording.place}: {states.shape[1]} columns, but {recordings[0].place} has {n}; "
                "expected the same coordinates in all."
            )
    return tuple(f"x{i}" for i in range(n))


def _default_space(names: tuple[str, ...]) -> StateSpace:
    """Quaternions where names tell them, scalar first; everything else linear."""
    kinds = ["linear"] * len(names)
    for quartet in quaternion_columns(names):
        if quartet != tuple(range(quartet[0], quartet[0] + 4)):
            told = ", ".join(names[i] for i in sorted(quartet))
            raise RecordingError(
                f"names: a quaternion in the order {told}; expected scalar first, side by side: "
                f"{', '.join(names[i] for i in quartet)}. Reorder the columns, or give the space."
            )
        kinds[quartet[0] : quartet[0] + 4] = ["quaternion"] * 4
    return StateSpace(tuple(kinds))


def _fitting(space: Any, names: tuple[str, ...]) -> StateSpace:
    """`space`, if it has as many coordinates as there are names."""
    if not isinstance(space, StateSpace):
        raise RecordingError(f"space: got {shortened(space)}; expected a StateSpace, such as StateSpace.pose().")
    if space.n_dims != len(names):
        raise RecordingError(
            f"space: {space!r} has {space.n_dims} coordinates, the recordings {len(names)}: {', '.join(names)}."
        )
    return space


def _consistent(
    arrays: list[Array], recordings: Sequence[Recording], names: tuple[str, ...], space: StateSpace
) -> list[Array]:
    """Quaternions of unit length and consistent signs, continuous angles without jumps: along and across.

    Each recording's first state is written as near as can be to that of the first recording.

    Raises:
        RecordingError: a quaternion far from unit length, a value beyond its limits.
    """
    for states, recording in zip(arrays, recordings, strict=True):
        _check_units(states, recording, names, space)
        _check_limits(states, recording, names, space)
    arrays = [space.normalize(states) for states in arrays]
    for states in arrays:
        states[0] = space.align(states[0], arrays[0][0])
    return [space.unwrap(states) for states in arrays]


def _check_units(states: Array, recording: Recording, names: tuple[str, ...], space: StateSpace) -> None:
    lengths = np.linalg.norm(states[:, space.quaternions], axis=-1)
    bad = np.argwhere(np.abs(lengths - 1) > UNIT_TOLERANCE)
    if len(bad):
        row, block = (int(i) for i in bad[0])
        columns = [names[i] for i in space.quaternions[block]]
        values = states[row, space.quaternions[block]].tolist()
        raise RecordingError(
            f"{recording.at(row)}, columns {', '.join(columns)}: quaternion {values} of length "
            f"{lengths[row, block]:.4g}; expected length 1 to within {UNIT_TOLERANCE:g}, scalar first."
        )


def _check_limits(states: Array, recording: Recording, names: tuple[str, ...], space: StateSpace) -> None:
    lower, upper = np.array(space.lower), np.array(space.upper)
    bad = np.argwhere((states < lower - LIMIT_TOLERANCE) | (states > upper + LIMIT_TOLERANCE))
    if len(bad):
        row, column = (int(i) for i in bad[0])
        raise RecordingError(
            f"{recording.at(row, names[column])}: value {states[row, column]:.6g} outside the limits "
            f"{lower[column]:.6g} to {upper[column]:.6g}; angles are in radians."
        )


def quaternion_columns(names: Sequence[str]) -> list[tuple[int, int, int, int]]:
    """Columns (w, x, y, z) of each quaternion that names tell: qw, qx, qy, qz with any prefix and suffix."""
    places = {name.lower(): i for i, name in enumerate(names)}
    found: list[tuple[int, int, int, int]] = []
    for name in list(places):
        head, mark, tail = name.rpartition("qw")
        quartet = [f"{head}q{letter}{tail}" for letter in "wxyz"]
        if mark and all(part in places for part in quartet):
            w, x, y, z = (places.pop(part) for part in quartet)  # no column belongs to two of them
            found.append((w, x, y, z))
    return found


def scalar_first(names: Sequence[str]) -> list[int]:
    """The order of columns in which every quaternion stands together, scalar first; else as they are."""
    quartets = {min(quartet): quartet for quartet in quaternion_columns(names)}
    inside = {i for quartet in quartets.values() for i in quartet}
    order: list[int] = []
    for i in range(len(names)):
        if i in quartets:
            order.extend(quartets[i])
        elif i not in inside:
            order.append(i)
    return order
