"""Resampling, warping and derivatives of recordings: pure functions on arrays.

States here are consistent along the recording (see `StateSpace.unwrap`), so they subtract plainly.
"""

from typing import Any

import numpy as np

from skillfold.errors import MissingExtraError

Array = np.ndarray[Any, np.dtype[np.float64]]


def progress(states: Array) -> Array:
    """(n_steps,) length of the path up to each state, as a part of the whole: 0 to 1, never falling."""
    lengths = np.linalg.norm(np.diff(states, axis=0), axis=1)
    travelled = np.concatenate([[0.0], np.cumsum(lengths)])
    return travelled / travelled[-1]


def interpolated(values: Array, at: Array, n_steps: int) -> Array:
    """`values` (n, D), known at the never falling `at` (n,), at `n_steps` even places; ends exactly kept."""
    first = np.concatenate([[True], np.diff(at) > 0])  # where `at` pauses, the first value counts
    places = np.linspace(at[0], at[-1], n_steps)
    out = np.column_stack([np.interp(places, at[first], column[first]) for column in values.T])
    out[[0, -1]] = values[[0, -1]]
    return out


def resampled(states: Array, times: Array | None, along: Array, n_steps: int) -> tuple[Array, Array | None]:
    """States and times at `n_steps` even places of `along` (length or time)."""
    if times is None:
        return interpolated(states, along, n_steps), None
    both = interpolated(np.column_stack([states, times]), along, n_steps)
    return both[:, :-1], both[:, -1]


def warped(states: Array, reference: Array) -> Array:
    """`states` (n, D) brought to the pace of `reference` (m, D) by dynamic time warping: (m, D).

    Each step of the reference gets the mean of the states matched with it; the ends are exactly kept.

    Raises:
        MissingExtraError: `dtaidistance` is not installed.
    """
    pairs = _warping_path(states, reference)
    sums = np.zeros_like(reference)
    np.add.at(sums, pairs[:, 1], states[pairs[:, 0]])
    out = sums / np.bincount(pairs[:, 1], minlength=len(reference))[:, None]
    out[[0, -1]] = states[[0, -1]]
    return out


def _warping_path(a: Array, b: Array) -> np.ndarray[Any, np.dtype[np.intp]]:
    try:
        from dtaidistance import dtw, dtw_ndim
    except ImportError:
        raise MissingExtraError(
            "Dynamic time warping needs the package dtaidistance: pip install 'skillfold[dtw]'; "
            "resample(n_steps) aligns by arc length or time without it."
        ) from None
    # The compiled version tells one coordinate from a plain series by its shape: a second, still one helps.
    a, b = (np.pad(states, ((0, 0), (0, 1))) for states in (a, b))
    path = dtw.warping_path_fast(a, b, use_lowmem=True) if dtw.dtw_cc else dtw_ndim.warping_path(a, b)
    return np.array(path, dtype=np.intp)


def velocities(states: Array, times: Array) -> Array:
    """(n_steps, D) derivative of states by times, of second order within; infinite where it overflows."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return np.gradient(states, times, axis=0)
