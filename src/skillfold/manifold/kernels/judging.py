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
def displacements(t: Indices, states: Array, ghost: float) -> tuple:
    """Of states (B, D): how far the surface seems, distances to the nearest anchor, and doubts; each (B,).

    The first is the length of the displacement, which bounds the distance up to a square, provided that the anchors
    agree about it. What they disagree by counts as distance too, once it is more than `ghost`.
    """
    scale, scratch = vector(t, SCALE)[0], make_scratch(t, len(states))
    evaluate(encode(t, states), scratch)
    off, nearest, doubts = np.empty(len(states)), np.empty(len(states)), scratch.doubts
    for i in range(len(states)):
        off[i], doubts[i] = scale * norm(scratch.normals[i]), scale * doubts[i]
        if doubts[i] > ghost:
            off[i] = math.hypot(off[i], doubts[i])
        nearest[i] = scale * math.sqrt(scratch.squares[i, 0])
    return off, nearest, doubts


@njit
def nearest_distances(t: Indices, states: Array) -> Array:
    """Distances of states (B, D) from their nearest anchor; (B,)."""
    scratch = make_scratch(t, len(states))
    find_nearest(encode(t, states), scratch)
    return vector(t, SCALE)[0] * np.sqrt(scratch.squares[:, 0])
