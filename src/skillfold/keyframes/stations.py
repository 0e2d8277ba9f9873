"""Covariances along an envelope: how they go from the parent's to the child's, and which directions are kept.

All are blocks of position and rotation, (..., 2, 3, 3). Directions of both blocks rank together: a radian counts as
`charts.LENGTH` metres.
"""

from typing import Any

import numpy as np

from skillfold.keyframes.charts import LENGTH

Array = np.ndarray[Any, np.dtype[np.float64]]

UNITS = np.array([1.0, LENGTH**2])[:, None, None]  # of covariances, to square metres
BURES_SEGMENTS = 32  # chords are at most 1 % wider than the curve, where standard deviations change tenfold
MOST_SEGMENTS = 64  # of a reduced envelope
OVERLAP = 0.25  # d² between means of neighbouring stations of a reduced envelope, in gates of either


def bures(first: Array, last: Array) -> Array:
    """Covariances (BURES_SEGMENTS + 1, 2, 3, 3) on the shortest way of optimal transport between two Gaussians.

    With T = A^-½ (A^½ B A^½)^½ A^-½ the covariance at s is M A M, M = (1 - s) 1 + s T.
    """
    root, inverse = _power(first, 0.5), _power(first, -0.5)
    transport = inverse @ _power(root @ last @ root, 0.5) @ inverse
    s = np.linspace(0.0, 1.0, BURES_SEGMENTS + 1)[:, None, None, None]
    moved = (1.0 - s) * np.eye(3) + s * transport
    stations = moved @ first @ moved
    stations[-1] = last
    return 0.5 * (stations + np.swapaxes(stations, -1, -2))


def count_kept(covariances: Array, alpha: float) -> int:
    """How many directions of (2, 3, 3) hold `alpha` percent of the variance (algorithm 2, lines 2 and 3)."""
    ranked = np.sort(np.linalg.eigvalsh(covariances * UNITS).ravel())[::-1]
    shares = np.cumsum(ranked) / ranked.sum()
    return min(int(np.searchsorted(shares, alpha / 100.0 - 1e-12)) + 1, 6)


def reduce(covariances: Array, kept: int, kappa: float) -> Array:
    """Covariances (..., 2, 3, 3) whose directions beyond the `kept` widest have `kappa` times their variance.

    Algorithm 2, lines 8 to 17, which there leaves them no variance but rounding errors.
    """
    values, vectors = np.linalg.eigh(covariances * UNITS)
    ranks = np.argsort(np.argsort(-values.reshape(*values.shape[:-2], 6), axis=-1), axis=-1).reshape(values.shape)
    values = np.where(ranks < kept, values, kappa * values)
    return (vectors * values[..., None, :]) @ np.swapaxes(vectors, -1, -2) / UNITS


def count_segments(axis: Array, covariances: Array) -> int:
    """How many equal segments bring means of neighbours on an axis (6,) within `OVERLAP` of every covariance."""
    blocks = axis.reshape(2, 3, 1)
    squares = (blocks * np.linalg.solve(covariances, np.broadcast_to(blocks, (len(covariances), 2, 3, 1)))).sum(
        (2, 3)
    )
    return int(np.clip(np.ceil(np.sqrt(squares.max() / OVERLAP) + 1e-9), 1, MOST_SEGMENTS))


def _power(matrices: Array, exponent: float) -> Array:
    values, vectors = np.linalg.eigh(matrices)
    return (vectors * np.maximum(values, 0.0)[..., None, :] ** exponent) @ np.swapaxes(vectors, -1, -2)
