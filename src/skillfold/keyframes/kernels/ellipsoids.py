"""Points nearest to a point in an ellipsoid {m + w: w'Σ⁻¹w ≤ 1}, in three dimensions.

Symmetric matrices are six numbers: xx, xy, xz, yy, yz, zz. All is in scalars and tuples, which stay in registers.
"""

import math
from typing import Any

from skillfold.jit import inner

Numbers = tuple[Any, ...]

CLOSE = 1e-13  # of √d² to 1, where the search along the multiplier stops
STEPS = 60  # at most; five are usual


@inner
def solved(matrix: Numbers, shift: float, v: Numbers) -> Numbers:
    """(matrix + shift · 1)⁻¹ v, by L D L' of a positive definite matrix."""
    d0 = 1.0 / (matrix[0] + shift)
    l1, l2 = matrix[1] * d0, matrix[2] * d0
    d1 = 1.0 / (matrix[3] + shift - l1 * matrix[1])
    e = matrix[4] - l1 * matrix[2]
    l3 = e * d1
    d2 = 1.0 / (matrix[5] + shift - l2 * matrix[2] - l3 * e)
    y1 = v[1] - l1 * v[0]
    x2 = (v[2] - l2 * v[0] - l3 * y1) * d2
    x1 = y1 * d1 - l3 * x2
    return v[0] * d0 - l1 * x1 - l2 * x2, x1, x2


@inner
def times(matrix: Numbers, v: Numbers) -> Numbers:
    """Product of a symmetric matrix and a vector."""
    return (
        matrix[0] * v[0] + matrix[1] * v[1] + matrix[2] * v[2],
        matrix[1] * v[0] + matrix[3] * v[1] + matrix[4] * v[2],
        matrix[2] * v[0] + matrix[4] * v[1] + matrix[5] * v[2],
    )


@inner
def dot(a: Numbers, b: Numbers) -> float:
    """Product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inner
def multiplier(matrix: Numbers, v: Numbers) -> Numbers:
    """μ ≥ 0 and x = (Σ + μ 1)⁻¹ v: the nearest point lies at m + Σx, and μx away from the point m + v.

    μ is zero for a point inside. Outside x'Σx = 1; 1/√(x'Σx) rises with μ and is concave, so that Newton's steps from
    zero never go too far.
    """
    mu, x = 0.0, v
    for _ in range(STEPS):
        x = solved(matrix, mu, v)
        along = times(matrix, x)
        square = dot(x, along)
        root = math.sqrt(square)
        if not root > 1.0 + CLOSE:
            break
        mu += square * (root - 1.0) / dot(along, solved(matrix, mu, x))
    return mu, x[0], x[1], x[2]
