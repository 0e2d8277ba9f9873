"""The tangent field alone: its bases at many states, and the printed projection along its leaves."""

from typing import Any

import numpy as np

from skillfold.jit import njit
from skillfold.manifold.kernels.small import keep_along, norm
from skillfold.manifold.kernels.surface import Field
from skillfold.manifold.kernels.tangents import tangent_bases

Array = np.ndarray[Any, np.dtype[np.float64]]

TOLERANCE = 1e-10  # of a step, in units of the data's rms radius


@njit
def follow_leaf(field: Field, states: Array, near: Array, rate: float, steps: int) -> Array:
    """The printed update q' ← q' + α H'H''(q − q') for a batch (B, D), from near (B, D)."""
    B, D = states.shape
    d = field.weights.shape[0]
    bases, features = np.empty((1, d, D)), np.empty(field.centres.shape[1])
    along, work = np.empty(D), np.empty(d)
    points = near.copy()
    for i in range(B):
        for _ in range(steps):
            tangent_bases(field.centres, field.precision, field.weights, points[i : i + 1], features, bases)
            for c in range(D):
                along[c] = states[i, c] - points[i, c]
            keep_along(bases[0], along, work)
            if norm(along) < TOLERANCE:
                break
            for c in range(D):
                points[i, c] += rate * along[c]
    return points


@njit
def field_bases(field: Field, states: Array) -> Array:
    """Orthonormal rows of H at states (B, D): (B, d, D)."""
    bases = np.empty((len(states), field.weights.shape[0], states.shape[1]))
    features = np.empty(field.centres.shape[1])
    tangent_bases(field.centres, field.precision, field.weights, states, features, bases)
    return bases
