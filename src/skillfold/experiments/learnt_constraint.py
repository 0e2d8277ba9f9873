"""A learnt manifold as an outside planner wants it: a function that is zero on it, and the function's Jacobian.

The function is the displacement from the surface in an orthonormal basis of the normals, which is the Jacobian.
Both come from one evaluation, so that the planner is not charged for Python: a call costs some microseconds. D
coordinates, c of them normal.
"""

from typing import Any

import numpy as np

from skillfold.check import OUTSIDE
from skillfold.jit import njit
from skillfold.manifold.kernels.small import norm
from skillfold.manifold.kernels.surface import Field, Scratch, Surface, evaluate, make_scratch
from skillfold.tables import (
    Array,
    Indices,
    address,
    index_matrix,
    indices,
    integers_at,
    matrix,
    reals_at,
    table_of,
    vector,
)

POINTS, ROWS, TANGENTS, BENDS, NEIGHBOURS, REACHES, RADII, PARENTS, FACTORS, DEGREES = range(10)
CENTRES, WEIGHTS, PRECISION = 10, 11, 12
CENTRE, KEPT, SCALE = 13, 14, 15  # of the way from states to inner coordinates
NEAREST, SQUARES, NORMALS, BASES, DOUBTS, NEARBY, NEARBY_SQUARES, ORIGINS, KNOWN = range(16, 25)
DISTANCES, STARTS, START_SQUARES, BLEND, OFFSET, ALONG, VALUES, MONOMIALS, FEATURES = range(25, 34)
SHAPE = 34  # d, of the field
LAST, INNER, ACROSS = 35, 36, 37  # (D,) state last evaluated, (1, D - f) its inner coordinates, (c, D - f) basis
VALUE, JACOBIAN = 38, 39  # (c,) and (c, D) there
SLOTS = 40


class LearntConstraint:
    """f(x) = 0 on the manifold of a skill; for one thread.

    Attributes:
        n_dims: D.
        codim: c.
    """

    def __init__(self, skill: Any) -> None:
        model = skill.model
        self.n_dims: int = model.n_dims
        self.codim: int = model.n_dims - model.dim
        self._table = table_of(_arrays(model, self.codim), SLOTS, model)
        self._value, self._jacobian = self._table.arrays[VALUE], self._table.arrays[JACOBIAN]
        self._squares, self._doubts = (self._table.arrays[slot].reshape(1, -1) for slot in (SQUARES, DOUBTS))
        self._farthest, self._most_doubt = (OUTSIDE * model.trust.spacing) ** 2, model.trust.ghost

    def value(self, x: Array) -> Array:
        """Of the function, (c,), at a state (D,); overwritten by the next call."""
        settle(x, self._table.entries)
        return self._value.reshape(-1)

    def jacobian(self, x: Array) -> Array:
        """Its derivative (c, D), to first order in f; overwritten by the next call."""
        settle(x, self._table.entries)
        return self._jacobian

    def supported(self, x: Array) -> bool:
        """Whether a state lies as near to the demonstrations as that of a plan must, where anchors agree about it.

        Elsewhere f has zeros that mean nothing.
        """
        settle(x, self._table.entries)
        return bool(self._squares[0, 0] <= self._farthest and self._doubts[0, 0] <= self._most_doubt)


def _arrays(model: Any, codim: int) -> dict[int, Any]:
    """By slot."""
    surface, field = model.surface, model.field
    scratch = _room(surface, field)
    inner = model.kept.shape[1]
    flat = [part.reshape(len(part), -1) if part.ndim == 3 else part for part in surface]
    working = [part.reshape(len(part), -1) if part.ndim == 3 else part for part in scratch]
    return {
        **dict(enumerate(flat)),
        CENTRES: field.centres,
        WEIGHTS: field.weights.reshape(len(field.weights), -1),
        PRECISION: np.array([field.precision]),
        CENTRE: model.centre,
        KEPT: model.kept,
        SCALE: np.array([model.scale]),
        **dict(enumerate(working, NEAREST)),
        SHAPE: np.array([len(field.weights)]),
        LAST: np.full(model.n_dims, np.nan),
        INNER: np.zeros((1, inner)),
        ACROSS: np.zeros((codim, inner)),
        VALUE: np.zeros(codim),
        JACOBIAN: np.zeros((codim, model.n_dims)),
    }


@njit
def _room(surface: Surface, field: Field) -> Scratch:
    """For one state."""
    return make_scratch(surface, field, 1)


@njit
def settle(x: Array, m: Indices) -> None:
    """Function and Jacobian at a state (D,), unless they are those of the last one."""
    last = vector(m, LAST)
    same = True
    for c in range(x.size):
        same &= last[c] == x[c]
        last[c] = x[c]
    if same:
        return
    inner, scratch = matrix(m, INNER), _scratch(m)
    _encode(x, m, inner[0])
    evaluate(_surface(m), _field(m), inner, scratch)
    across, kept = matrix(m, ACROSS), matrix(m, KEPT)
    _complement(scratch.bases[0], across)
    value, jacobian, scale = vector(m, VALUE), matrix(m, JACOBIAN), vector(m, SCALE)[0]
    for r in range(across.shape[0]):
        s = 0.0
        for k in range(across.shape[1]):
            s += across[r, k] * scratch.normals[0, k]
        value[r] = scale * s
        for c in range(x.size):
            s = 0.0
            for k in range(across.shape[1]):
                s += across[r, k] * kept[c, k]
            jacobian[r, c] = s


@njit
def _encode(x: Array, m: Indices, inner: Array) -> None:
    centre, kept, scale = vector(m, CENTRE), matrix(m, KEPT), vector(m, SCALE)[0]
    for k in range(inner.size):
        s = 0.0
        for c in range(x.size):
            s += (x[c] - centre[c]) * kept[c, k]
        inner[k] = s / scale


@njit
def _complement(basis: Array, across: Array) -> None:
    """Orthonormal rows (c, n) of what the orthonormal rows (n - c, n) leave, from the axes that stand out most."""
    d, n = basis.shape
    for r in range(across.shape[0]):
        best, most = 0, -1.0
        for k in range(n):
            left = 1.0
            for a in range(d):
                left -= basis[a, k] ** 2
            for a in range(r):
                left -= across[a, k] ** 2
            if left > most:
                best, most = k, left
        row = across[r]
        row[:] = 0.0
        row[best] = 1.0
        for _ in range(2):  # twice is enough
            _remove(basis, d, row)
            _remove(across, r, row)
        length = norm(row)
        for k in range(n):
            row[k] /= length


@njit
def _remove(rows: Array, count: int, row: Array) -> None:
    for a in range(count):
        s = 0.0
        for k in range(row.size):
            s += rows[a, k] * row[k]
        for k in range(row.size):
            row[k] -= s * rows[a, k]


@njit
def _surface(m: Indices) -> Surface:
    points, d = matrix(m, POINTS), indices(m, SHAPE)[0]
    D, M = points.shape
    bends = matrix(m, BENDS)
    return Surface(
        points,
        matrix(m, ROWS),
        reals_at(address(m, TANGENTS), (M, d, D)),
        reals_at(address(m, BENDS), (M, D, bends.shape[1] // D)),
        index_matrix(m, NEIGHBOURS),
        vector(m, REACHES),
        vector(m, RADII),
        indices(m, PARENTS),
        indices(m, FACTORS),
        indices(m, DEGREES),
    )


@njit
def _field(m: Indices) -> Field:
    centres = matrix(m, CENTRES)
    shape = (indices(m, SHAPE)[0], centres.shape[0], centres.shape[1])
    return Field(centres, vector(m, PRECISION)[0], reals_at(address(m, WEIGHTS), shape))


@njit
def _scratch(m: Indices) -> Scratch:
    D, d = matrix(m, POINTS).shape[0], indices(m, SHAPE)[0]
    nearest = index_matrix(m, NEAREST)
    return Scratch(
        integers_at(address(m, NEAREST), nearest.shape),
        matrix(m, SQUARES),
        matrix(m, NORMALS),
        reals_at(address(m, BASES), (1, d, D)),
        vector(m, DOUBTS),
        index_matrix(m, NEARBY),
        matrix(m, NEARBY_SQUARES),
        matrix(m, ORIGINS),
        vector(m, KNOWN),
        vector(m, DISTANCES),
        indices(m, STARTS),
        vector(m, START_SQUARES),
        matrix(m, BLEND),
        vector(m, OFFSET),
        vector(m, ALONG),
        vector(m, VALUES),
        vector(m, MONOMIALS),
        vector(m, FEATURES),
    )
