"""A learnt manifold as an outside planner wants it: a function that is zero on it, and the function's Jacobian.

The function is the displacement from the surface in an orthonormal basis of the normals, which is the Jacobian.
Both come from one evaluation, so that the planner is not charged for Python: a call costs some microseconds. D
coordinates, c of them normal.
"""

from typing import Any

import numpy as np

from skillfold.check import OUTSIDE
from skillfold.jit import njit
from skillfold.manifold.kernels import scratch
from skillfold.manifold.kernels.scratch import Scratch, evaluate_at, make_scratch
from skillfold.manifold.kernels.small import norm
from skillfold.manifold.kernels.tabled import EVALUATOR, KEPT, SCALE, encode
from skillfold.manifold.kernels.tabled import SLOTS as MODEL
from skillfold.tables import ENTRY, Array, Indices, matrix, scalar, table_of, vector

# After the slots of a model come those of scratch memory.
LAST, ACROSS = MODEL + scratch.SLOTS, MODEL + scratch.SLOTS + 1  # (D,) state last evaluated, (c, D - f) basis
VALUE, JACOBIAN = LAST + 2, LAST + 3  # (c,) and (c, D) there
SLOTS = LAST + 4
NORMALS, BASES = MODEL + scratch.NORMALS, MODEL + scratch.BASES
SQUARES, DOUBTS = MODEL + scratch.SQUARES, MODEL + scratch.DOUBTS


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
        self._squares, self._doubts = (
            self._table.arrays[MODEL + slot].reshape(1, -1) for slot in (scratch.SQUARES, scratch.DOUBTS)
        )
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
    room = _room(model.table)
    working = {
        scratch.NEAREST: room.nearest,
        scratch.SQUARES: room.squares,
        scratch.NORMALS: room.normals,
        scratch.BASES: room.bases[0],
        scratch.DOUBTS: room.doubts,
        scratch.BLEND: room.weights,
        scratch.NEARBY: room.around,
        scratch.NEARBY_SQUARES: room.around_squares,
        scratch.ORIGINS: room.origins,
        scratch.KNOWN: room.known,
        scratch.DISTANCES: room.distances,
        scratch.ALONG: room.along,
        scratch.MIXED: room.mixed,
        scratch.PLACE: room.place,
        scratch.ROW: room.row,
        scratch.COORDINATES: room.coordinates,
        scratch.MONOMIALS: room.monomials,
        scratch.FEATURES: room.features,
    }
    return {
        **model.arrays,
        **{MODEL + slot: array for slot, array in working.items()},
        LAST: np.full(model.n_dims, np.nan),
        ACROSS: np.zeros((codim, model.kept.shape[1])),
        VALUE: np.zeros(codim),
        JACOBIAN: np.zeros((codim, model.n_dims)),
    }


@njit
def _room(t: Indices) -> Scratch:
    """For one state."""
    return make_scratch(t, 1)


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
    evaluate_at(scalar(m, EVALUATOR))(m, encode(m, x.reshape(1, x.size)), m[ENTRY * MODEL :], 1)
    across, kept, normal = matrix(m, ACROSS), matrix(m, KEPT), vector(m, NORMALS)
    _complement(matrix(m, BASES), across)
    value, jacobian, scale = vector(m, VALUE), matrix(m, JACOBIAN), vector(m, SCALE)[0]
    for r in range(across.shape[0]):
        s = 0.0
        for k in range(across.shape[1]):
            s += across[r, k] * normal[k]
        value[r] = scale * s
        for c in range(x.size):
            s = 0.0
            for k in range(across.shape[1]):
                s += across[r, k] * kept[c, k]
            jacobian[r, c] = s


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
