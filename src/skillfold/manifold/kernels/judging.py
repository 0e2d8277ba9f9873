"""How far states are from the surface and from what was demonstrated.

`t` is the table of a model (see `tabled`); all lengths are as in its states.
"""

import math
from typing import Any

import numpy as np

from skillfold.jit import njit
from skillfold.manifold.kernels.scratch import evaluate, find_nearest, make_scratch
from skillfold.manifold.kernels.small import norm
from skillfold.manifold.kernels.tabled import SCALE, encode
from skillfold.tables import Indices, vector

Array = np.ndarray[Any, np.dtype[np.float64]]


@njit
def displacements(t: Indices, states: Array, ghost: float) -> Array:
    """Of states (B, D): how far the surface seems, distances to the nearest anchor, and doubts; rows of (3, B).

    The first is the length of the displacement, which bounds the distance up to a square, provided that the anchors
    agree about it. What they disagree by counts as distance too, once it is more than `ghost`.
    """
    scale, scratch = vector(t, SCALE)[0], make_scratch(t, len(states))
    evaluate(encode(t, states), scratch)
    told = np.empty((3, len(states)))  # one array, as each takes Python a microsecond
    for i in range(len(states)):
        off, doubt = scale * norm(scratch.normals[i]), scale * scratch.doubts[i]
        told[0, i] = math.hypot(off, doubt) if doubt > ghost else off
        told[1, i] = scale * math.sqrt(scratch.squares[i, 0])
        told[2, i] = doubt
    return told


@njit
def nearest_distances(t: Indices, states: Array) -> Array:
    """Distances of states (B, D) from their nearest anchor; (B,)."""
    scratch = make_scratch(t, len(states))
    find_nearest(encode(t, states), scratch)
    return vector(t, SCALE)[0] * np.sqrt(scratch.squares[:, 0])
