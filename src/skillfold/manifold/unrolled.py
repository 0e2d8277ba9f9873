"""Quaternions in three coordinates instead of four.

That they are of unit length is known before anything is learnt. Recordings that spread less than a sphere bends show
it as the clearest constraint of all, and one that says nothing of the skill.
"""

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
Columns = np.ndarray[Any, np.dtype[np.intp]]


def unrolled(states: Array, quaternions: Columns) -> Array:
    """States (N, D) with n quaternions as half their rotation vectors from the mean, last; (N, D - n).

    Half, so that small turns are as long as between quaternions.

    Args:
        states: each quaternion scalar first, of the sign of the one before it.
        quaternions: (n, 4) columns of each.
    """
    others = np.delete(states, quaternions.ravel(), axis=1)
    return np.concatenate([others, *(_half_turns(states[:, columns]) for columns in quaternions)], axis=1)


def _half_turns(quaternions: Array) -> Array:
    """(N, 4) unit quaternions to (N, 3)."""
    mean = np.linalg.eigh(quaternions.T @ quaternions)[1][:, -1]
    mean *= 1.0 if (quaternions @ mean).sum() >= 0.0 else -1.0  # where most are near it, none is half a turn off
    (w, v), (r, u) = _parts(mean), _parts(quaternions)
    along = w * u - r * v - np.cross(v, u)
    length = np.linalg.norm(along, axis=1, keepdims=True)
    half = np.arctan2(length, w * r + u @ v[:, None])
    return along * np.where(length > 0.0, half / np.maximum(length, 1e-300), 1.0)


def _parts(quaternions: Array) -> tuple[Array, Array]:
    return quaternions[..., :1], quaternions[..., 1:]
