"""Surface and tangent field in a table (see `tables`): to hand over their arrays takes as long as a query."""

from typing import Any

import numpy as np

from skillfold.jit import inlined
from skillfold.manifold.kernels.surface import Field, Surface
from skillfold.tables import Indices, Table, address, index_matrix, indices, matrix, reals_at, table_of, vector

# Arrays of `Surface` and `Field`, those of three dimensions with the first two as one.
POINTS, ROWS, TANGENTS, BENDS, NEIGHBOURS, REACHES, RADII, PARENTS, FACTORS, DEGREES = range(10)
CENTRES, WEIGHTS, PRECISION = 10, 11, 12
SLOTS = 13


def tabled(surface: Surface, field: Field) -> Table:
    """Their table."""
    return table_of(by_slot(surface, field), SLOTS)


def by_slot(surface: Surface, field: Field) -> dict[int, Any]:
    """Their arrays."""
    arrays = (*surface, field.centres, field.weights, np.array([field.precision]))
    return {slot: a.reshape(-1, a.shape[2]) if a.ndim == 3 else a for slot, a in enumerate(arrays)}


@inlined
def surface_at(t: Indices) -> Surface:
    """The surface of a table."""
    points = matrix(t, POINTS)
    (D, M), P = points.shape, matrix(t, BENDS).shape[1]
    return Surface(
        points,
        matrix(t, ROWS),
        reals_at(address(t, TANGENTS), (M, matrix(t, TANGENTS).shape[0] // M, D)),
        reals_at(address(t, BENDS), (M, D, P)),
        index_matrix(t, NEIGHBOURS),
        vector(t, REACHES),
        vector(t, RADII),
        indices(t, PARENTS),
        indices(t, FACTORS),
        indices(t, DEGREES),
    )


@inlined
def field_at(t: Indices) -> Field:
    """The field of a table."""
    centres, weights = matrix(t, CENTRES), matrix(t, WEIGHTS)
    D, K = centres.shape
    shape = (weights.shape[0] // D, D, K)
    return Field(centres, vector(t, PRECISION)[0], reals_at(address(t, WEIGHTS), shape))
