"""The surface and the field evaluated at states: what every loop of this family is made of, and its memory.

`evaluate` takes a batch, in stages that loop over it. It is compiled once and called at its address, its arrays in
tables: compiled into each loop that needs it, it took half the time that those took to compile, and to hand over a
model's many arrays takes longer than the work at one state. Scratch memory is made once by whoever loops; nothing is
allocated here.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import function_at, inner, pointer
from skillfold.lanes import LANES
from skillfold.manifold.kernels.neighbours import nearest_anchors
from skillfold.manifold.kernels.surface import BLENDED, blend, displace
from skillfold.manifold.kernels.tabled import (
    CENTRES,
    CHARTS,
    EVALUATOR,
    MAPS,
    NEIGHBOURS,
    PARENTS,
    POINTS,
    PRECISION,
    REACHES,
    ROWS,
    WEIGHTS,
    dimension,
    surface_at,
)
from skillfold.manifold.kernels.tangents import remove_tangential, stand_in, tangent_bases
from skillfold.tables import (
    ENTRY,
    Array,
    Indices,
    address,
    enter,
    index_matrix,
    indices,
    matrix,
    reals_at,
    scalar,
    vector,
)

AROUND = 16  # anchors that are known around a state: while it hardly moves, the nearest are among them
STARTS = 4  # anchors from which a far state is projected, besides the state itself

# Of a table of scratch memory, what `evaluate` uses.
NEAREST, SQUARES, NORMALS, BASES, DOUBTS, BLEND = range(6)
NEARBY, NEARBY_SQUARES, ORIGINS, KNOWN, DISTANCES = range(6, 11)
ALONG, MIXED, PLACE, ROW, COORDINATES, MONOMIALS, FEATURES = range(11, 18)
SLOTS = 18


class Scratch(NamedTuple):
    """What `evaluate` finds at n states, and memory that it works in.

    Attributes:
        model, table, evaluator: tables of the model and of the arrays below; address of what is called with them.
        nearest, squares: (n, m + 1) nearest anchors of each state, sorted, and their squared distances; m blended.
        normals: (n, D) displacements from the surface.
        bases: (n, d, D) orthonormal rows, H's tangents.
        doubts: (n,) how far the blended anchors disagree.
        weights: (n, m) of the blended anchors.
        around, around_squares, origins, known: (n, K), (1, K), (n, D) and (n,), see `nearest_anchors`.
        distances: (M,), squared, from the last state whose anchors were looked for among all.
        starts, start_squares: (s,) anchors from which a far state is projected.
    """

    model: Indices
    table: Indices
    evaluator: int
    nearest: Indices
    squares: Array
    normals: Array
    bases: Array
    doubts: Array
    weights: Array
    around: Indices
    around_squares: Array
    origins: Array
    known: Array
    distances: Array
    starts: Indices
    start_squares: Array
    along: Array
    mixed: Array
    place: Array
    row: Array
    coordinates: Array
    monomials: Array
    features: Array


@inner
def make_scratch(t: Indices, n: int) -> Scratch:
    """Room for evaluations at n states of the model of a table (see `tabled`)."""
    D, M = matrix(t, POINTS).shape
    d, (K, w) = dimension(t), matrix(t, WEIGHTS).shape
    m, near = min(BLENDED, M - 1), min(AROUND, M)
    around = np.empty((n, near), np.int64)
    for i in range(n):
        for j in range(near):
            around[i, j] = j
    s = Scratch(
        t,
        np.empty(ENTRY * SLOTS, np.int64),
        scalar(t, EVALUATOR),
        np.empty((n, m + 1), np.int64),
        np.empty((n, m + 1)),
        np.zeros((n, D)),
        np.zeros((n, d, D)),
        np.zeros(n),
        np.empty((n, m)),
        around,
        np.empty((1, near)),
        np.zeros((n, D)),
        np.zeros(n),
        np.empty(M),
        np.zeros(min(STARTS, M), np.int64),
        np.empty(min(STARTS, M)),
        np.empty(d),
        np.empty((d, D)),
        np.zeros(matrix(t, MAPS).shape[1]),
        np.zeros(max(matrix(t, CHARTS).shape[1], w, 2 * LANES)),
        np.ones((d + 1, BLENDED)),
        np.empty((indices(t, PARENTS).size, BLENDED)),
        np.empty(K),
    )
    enter(s.table, NEAREST, s.nearest, n, m + 1)
    enter(s.table, SQUARES, s.squares, n, m + 1)
    enter(s.table, NORMALS, s.normals, n, D)
    enter(s.table, BASES, s.bases, n * d, D)
    enter(s.table, DOUBTS, s.doubts, 1, n)
    enter(s.table, BLEND, s.weights, n, m)
    enter(s.table, NEARBY, s.around, n, near)
    enter(s.table, NEARBY_SQUARES, s.around_squares, 1, near)
    enter(s.table, ORIGINS, s.origins, n, D)
    enter(s.table, KNOWN, s.known, 1, n)
    enter(s.table, DISTANCES, s.distances, 1, M)
    enter(s.table, ALONG, s.along, 1, d)
    enter(s.table, MIXED, s.mixed, d, D)
    enter(s.table, PLACE, s.place, 1, s.place.size)
    enter(s.table, ROW, s.row, 1, s.row.size)
    enter(s.table, COORDINATES, s.coordinates, d + 1, BLENDED)
    enter(s.table, MONOMIALS, s.monomials, len(s.monomials), BLENDED)
    enter(s.table, FEATURES, s.features, 1, K)
    return s


@inner
def evaluate(states: Array, scratch: Scratch) -> None:
    """Displacements from the modelled surface to states (n, D), and H's tangents there, into scratch.

    The nearest anchors' surfaces are blended. Their normals differ a little: what of the blend lies along H's
    tangents is taken off, else an iteration on it would creep along the surface. Scratch may have room for more.
    """
    evaluate_at(scratch.evaluator)(scratch.model, states, scratch.table, 1)


@inner
def find_nearest(states: Array, scratch: Scratch) -> None:
    """The nearest anchors of states (n, D), sorted, into scratch.nearest and their squares into scratch.squares."""
    evaluate_at(scratch.evaluator)(scratch.model, states, scratch.table, 0)


def evaluate_in(t: Indices, states: Array, s: Indices, whole: int) -> int:
    """`evaluate`, or where that is not wanted `find_nearest`, of a model's table and one of scratch memory."""
    n, nearest, squares = len(states), index_matrix(s, NEAREST), matrix(s, SQUARES)
    nearest_anchors(
        matrix(t, POINTS),
        matrix(t, ROWS),
        index_matrix(t, NEIGHBOURS),
        vector(t, REACHES),
        states,
        vector(s, DISTANCES),
        nearest,
        squares,
        index_matrix(s, NEARBY),
        matrix(s, NEARBY_SQUARES),
        matrix(s, ORIGINS),
        vector(s, KNOWN),
    )
    if whole:
        surface, weights = surface_at(t), matrix(s, BLEND)
        normals, along, row = matrix(s, NORMALS), vector(s, ALONG), vector(s, ROW)
        blend(squares[:n], weights)
        displace(
            surface.charts,
            surface.maps,
            surface.parents,
            surface.factors,
            surface.degrees,
            states,
            nearest,
            weights,
            vector(s, PLACE),
            row,
            matrix(s, COORDINATES),
            matrix(s, MONOMIALS),
            normals,
            vector(s, DOUBTS),
        )
        bases = reals_at(address(s, BASES), (n, along.size, normals.shape[1]))
        kernels = matrix(t, CENTRES), vector(t, PRECISION)[0], matrix(t, WEIGHTS)
        tangent_bases(*kernels, states, vector(s, FEATURES), row, bases)
        stand_in(surface.charts, surface.radii, nearest, weights, row, matrix(s, MIXED), bases)
        remove_tangential(bases, normals, along)
    return 0


_GIVEN = np.empty(0, np.int64), np.empty((0, 0)), np.empty(0, np.int64), 0
evaluate_at = function_at(0, *_GIVEN)


@cache
def evaluator() -> Any:
    """`evaluate_in`, compiled; the table of a model holds its address."""
    return pointer(evaluate_in, 0, *_GIVEN)
