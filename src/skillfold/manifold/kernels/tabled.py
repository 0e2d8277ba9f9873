"""A model in a table (see `tables`): to hand over its arrays one by one takes as long as a query."""

from typing import Any

import numpy as np

from skillfold.jit import inlined
from skillfold.lanes import padded
from skillfold.manifold.kernels.surface import Field, Surface
from skillfold.tables import Array, Indices, Table, address, index_matrix, indices, matrix, reals_at, table_of, vector

# Arrays of `Surface`, the first two dimensions of three as one; of `Field`, filled up; then the way from states.
POINTS, ROWS, CHARTS, MAPS, NEIGHBOURS, REACHES, RADII, PARENTS, FACTORS, DEGREES = range(10)
CENTRES, WEIGHTS, PRECISION, CENTRE, KEPT, SCALE, EVALUATOR = range(10, 17)
SLOTS = 17

NOWHERE = 1e100  # coordinates of kernels that fill up: states are smaller


def tabled(surface: Surface, field: Field, centre: Array, kept: Array, scale: float, evaluator: Any) -> Table:
    """The table of a model; its states x have inner coordinates (x − centre) kept / scale.

    `evaluator` is what evaluates it, compiled (see `scratch`); it must be kept as long as the table.
    """
    rest = *_side_by_side(field), np.array([field.precision]), centre, kept, np.array([scale])
    arrays = enumerate((*surface, *rest, np.array([evaluator.address])))
    return table_of({slot: a.reshape(-1, a.shape[2]) if a.ndim == 3 else a for slot, a in arrays}, SLOTS)


def _side_by_side(field: Field) -> tuple[Array, Array]:
    """Centres (D, K) and weights (K, d D) of a field as lanes take them: with kernels that are nowhere felt."""
    d, D, K = field.weights.shape
    centres, weights = np.full((D, padded(K)), NOWHERE), np.zeros((padded(K), padded(d * D)))
    centres[:, :K] = field.centres
    weights[:K, : d * D] = field.weights.reshape(d * D, K).T
    return centres, weights


@inlined
def dimension(t: Indices) -> int:
    """The manifold's dimension d: the last monomial is a power of the last coordinate."""
    factors = indices(t, FACTORS)
    return factors[factors.size - 1] + 1


@inlined
def encode(t: Indices, states: Array) -> Array:
    """Inner coordinates (B, E) of states (B, D)."""
    centre, kept, scale = vector(t, CENTRE), matrix(t, KEPT), vector(t, SCALE)[0]
    inner = np.zeros((len(states), kept.shape[1]))
    for i in range(len(states)):
        for c in range(centre.size):
            offset = (states[i, c] - centre[c]) / scale
            for e in range(kept.shape[1]):
                inner[i, e] += offset * kept[c, e]
    return inner


@inlined
def moved(t: Indices, states: Array, inner: Array, points: Array) -> Array:
    """States (B, D) with inner coordinates `points` (B, E) instead of `inner`; what is free stays."""
    kept, scale = matrix(t, KEPT), vector(t, SCALE)[0]
    out = states.copy()
    for i in range(len(states)):
        for e in range(kept.shape[1]):
            step = scale * (points[i, e] - inner[i, e])
            for c in range(kept.shape[0]):
                out[i, c] += step * kept[c, e]
    return out


@inlined
def decode_path(t: Indices, start: Array, goal: Array, inner: Array, path: Array) -> None:
    """States of a path with inner coordinates (n, E), into `path` (n, D); what is free goes straight to the goal."""
    centre, kept, scale = vector(t, CENTRE), matrix(t, KEPT), vector(t, SCALE)[0]
    n, D = path.shape
    for i in range(n):
        share = i / (n - 1)
        for c in range(D):
            path[i, c] = start[c] + share * (goal[c] - start[c])
        for e in range(kept.shape[1]):
            step = scale * inner[i, e]
            for c in range(D):
                step -= kept[c, e] * (start[c] + share * (goal[c] - start[c]) - centre[c])
            for c in range(D):
                path[i, c] += step * kept[c, e]


@inlined
def surface_at(t: Indices) -> Surface:
    """The surface of a table."""
    points = matrix(t, POINTS)
    D, M = points.shape
    rows, e, E = 1 + indices(t, PARENTS).size, matrix(t, CHARTS).shape[1], matrix(t, MAPS).shape[1]
    return Surface(
        points,
        matrix(t, ROWS),
        reals_at(address(t, CHARTS), (M, 1 + D, e)),
        reals_at(address(t, MAPS), (M, rows, E)),
        index_matrix(t, NEIGHBOURS),
        vector(t, REACHES),
        vector(t, RADII),
        indices(t, PARENTS),
        indices(t, FACTORS),
        indices(t, DEGREES),
    )
