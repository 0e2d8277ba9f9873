"""Where a recording crosses its own path: there its positions alone are no manifold."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.distance import cdist

from skillfold.alignment import interpolated, progress

Array = np.ndarray[Any, np.dtype[np.float64]]

# Calibrated on 56 drawings of letters and 210 of the LASA shapes, with 0 to 2 % noise: strokes that cross
# come within 0.3 % of the path's length of themselves (one near miss 0.9 %), all others stay beyond 2 %.
_SAMPLES = 200  # along the path, evenly
_NEAR = 0.01  # of the path's length
_APART = 0.05  # of the path's length, travelled between the two passes
_LEAVES = 0.15  # of the path's rms radius, left behind between the two passes: trembling is no crossing
_SLANT = 0.5  # sine of the smallest angle: nearly parallel passes, or the same way back, still are a manifold
_WINDOW = 25  # a part of this many of the samples is averaged, against sensor noise
_ORDERED = 0.5  # samples farther than this (in rms radii) from their running mean have no order

_LATER = np.triu(np.ones((_SAMPLES, _SAMPLES), dtype=bool), int(_APART * _SAMPLES) + 1)  # second passes of each


@dataclass(frozen=True, eq=False)
class Crossing:
    """A place that a demonstration passes twice, in clearly different directions.

    Attributes:
        demonstration: its index.
        rows: of the two passes, in that demonstration's states.
        state: (D,) the place, midway between the passes.
        gap: distance between the passes.
        angle: between their directions [rad], up to π/2.
    """

    demonstration: int
    rows: tuple[int, int]
    state: Array
    gap: float
    angle: float


def crossings(states: Array, demonstration: int = 0) -> list[Crossing]:
    """Crossings of one path (n_steps, D), nearest passes first; none in unordered point clouds."""
    smooth = _running_mean(states, len(states) // _WINDOW)
    radius = _rms(states - states.mean(axis=0))
    if (smooth == smooth[0]).all() or _rms(states - smooth) > _ORDERED * radius:
        return []
    phase = progress(smooth)
    path = interpolated(smooth, phase, _SAMPLES)
    gaps = np.asarray(cdist(path, path), np.float64)
    near = (gaps <= _NEAR * np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) & _LATER
    if not near.any():
        return []
    directions = _directions(path)
    cosines = np.abs(directions @ directions.T)
    near &= cosines <= np.sqrt(1 - _SLANT**2)
    return [
        Crossing(
            demonstration,
            _rows(phase, i, j),
            (path[i] + path[j]) / 2,
            float(gaps[i, j]),
            float(np.arccos(cosines[i, j])),
        )
        for i, j in _distinct(_candidates(near, gaps, _LEAVES * radius), gaps)
    ]


def _candidates(near: Any, gaps: Array, leave: float) -> list[tuple[int, int]]:
    return [(i, j) for i, j in np.argwhere(near).tolist() if gaps[i, i:j].max() > leave]


def _distinct(pairs: list[tuple[int, int]], gaps: Array) -> list[tuple[int, int]]:
    """The nearest pair of each crowd of pairs."""
    apart = int(_APART * len(gaps))
    chosen: list[tuple[int, int]] = []
    for i, j in sorted(pairs, key=lambda pair: gaps[pair]):
        if all(abs(i - a) > apart or abs(j - b) > apart for a, b in chosen):
            chosen.append((i, j))
    return chosen


def _rows(phase: Array, i: int, j: int) -> tuple[int, int]:
    first, second = (int(np.abs(phase - k / (_SAMPLES - 1)).argmin()) for k in (i, j))
    return first, second


def _directions(path: Array) -> Array:
    """(n, D) unit vectors along the path, over three samples to each side."""
    ahead = path[np.minimum(np.arange(len(path)) + 3, len(path) - 1)]
    behind = path[np.maximum(np.arange(len(path)) - 3, 0)]
    steps = ahead - behind
    lengths = np.linalg.norm(steps, axis=1, keepdims=True)
    return np.divide(steps, lengths, out=np.zeros_like(steps), where=lengths > 0)


def _running_mean(states: Array, window: int) -> Array:
    """(n_steps, D) mean over `window` samples around each, over fewer toward the ends, which stay."""
    n, half = len(states), window // 2
    index = np.arange(n)
    reach = np.minimum(half, np.minimum(index, n - 1 - index))
    sums = np.concatenate([np.zeros((1, states.shape[1])), np.cumsum(states, axis=0)])
    return (sums[index + reach + 1] - sums[index - reach]) / (2 * reach + 1)[:, None]


def _rms(vectors: Array) -> float:
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))
