"""How far states are from the surface and from what was demonstrated."""

from typing import Any

import numpy as np

from skillfold.jit import njit
from skillfold.manifold.kernels.projection import GHOST, gap, project_states
from skillfold.manifold.kernels.small import norm
from skillfold.manifold.kernels.surface import Field, Surface, Trust, evaluate, find_nearest, make_scratch

Array = np.ndarray[Any, np.dtype[np.float64]]


@njit
def displacements(surface: Surface, field: Field, states: Array) -> tuple:
    """Displacements from the surface to states (B, D), distances to the nearest anchor, and doubts; both (B,)."""
    scratch = make_scratch(surface, field, len(states))
    evaluate(surface, field, states, scratch)
    return scratch.normals, np.sqrt(scratch.squares[:, 0]), scratch.doubts


@njit
def judge(surface: Surface, field: Field, trust: Trust, states: Array, enough: float) -> tuple:
    """Distances of states (B, D) from the modelled surface, and from the nearest anchor; both (B,).

    A state nearer than `enough` is not projected: there its displacement, which bounds the distance up to a
    square, tells all that was asked, provided that the anchors agree about it. What they disagree by counts as
    distance, once it is too much to be overlooked.
    """
    normals, nearest, doubts = displacements(surface, field, states)
    off = np.empty(len(states))
    for i in range(len(states)):
        off[i] = norm(normals[i])
        if doubts[i] > GHOST * trust.doubt:
            off[i] = np.hypot(off[i], doubts[i])
    asked = np.flatnonzero(off > enough)
    if len(asked):
        away = states[asked]
        points, _ = project_states(surface, field, trust, away)
        for k in range(len(asked)):
            off[asked[k]] = np.sqrt(gap(points[k], away[k]))
    return off, nearest


@njit
def nearest_distances(surface: Surface, field: Field, states: Array) -> Array:
    """Distances of states (B, D) from their nearest anchor; (B,)."""
    scratch = make_scratch(surface, field, len(states))
    find_nearest(surface, states, scratch)
    return np.sqrt(scratch.squares[:, 0])
