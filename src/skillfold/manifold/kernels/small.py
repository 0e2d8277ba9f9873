"""Small dense linear algebra on rows, for the inside of loops."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inlined, inner

Array = np.ndarray[Any, np.dtype[np.float64]]


NOTHING = 1e-300  # squared length


@inner
def copy(source: Array, out: Array) -> None:
    """Copy a vector; for an assignment of arrays Numba compiles a second's worth of error messages."""
    for c in range(source.size):
        out[c] = source[c]


@inner
def norm(vector: Array) -> float:
    """Euclidean length."""
    return math.sqrt(square(vector))


@inner
def components(basis: Array, vector: Array, out: Array) -> None:
    """Components of `vector` along the orthonormal rows of `basis`."""
    for a in range(basis.shape[0]):
        s = 0.0
        for c in range(vector.size):
            s += basis[a, c] * vector[c]
        out[a] = s


@inner
def keep_along(basis: Array, vector: Array, work: Array) -> None:
    """Vector ← its part in the span of the orthonormal rows of `basis`."""
    components(basis, vector, work)
    vector[:] = 0.0
    for a in range(basis.shape[0]):
        for c in range(vector.size):
            vector[c] += work[a] * basis[a, c]


@inner
def orthonormalise(basis: Array) -> bool:
    """Gram-Schmidt on the rows; one that vanishes becomes the next free axis, and the answer False."""
    full_rank = True
    for a in range(basis.shape[0]):
        before = 0.0
        for c in range(basis.shape[1]):
            before += basis[a, c] ** 2
        after = before - take_off(basis, a)
        # Where little is left, rounding has spoilt it.
        if not (after > 0.25 * before and after > NOTHING):
            after, kept = mend(basis, a, before)
            full_rank = full_rank and kept
        scale = 1.0 / math.sqrt(after)
        for c in range(basis.shape[1]):
            basis[a, c] *= scale
    return full_rank


@inner
def mend(basis: Array, a: int, before: float) -> tuple:
    """Clear row a once more, of squared length `before` at first, or make it an axis where it vanishes.

    Returns the squared length it is left with, and whether it was kept.
    """
    after, axis, kept = clear(basis, a), 0, True
    while axis < basis.shape[1] and not (after > 1e-20 * before and after > NOTHING):
        for c in range(basis.shape[1]):
            basis[a, c] = 1.0 if c == axis else 0.0
        clear(basis, a)
        after, axis, before, kept = clear(basis, a), axis + 1, 1.0, False  # twice is enough
    return after, kept


@inner
def clear(basis: Array, a: int) -> float:
    """Take off row a what lies along the rows before it; the squared length it is left with."""
    take_off(basis, a)
    return square(basis[a])


@inlined
def take_off(basis: Array, a: int) -> float:
    """The same; the squared length that was taken off, by Pythagoras."""
    off = 0.0
    for b in range(a):
        s = 0.0
        for c in range(basis.shape[1]):
            s += basis[a, c] * basis[b, c]
        for c in range(basis.shape[1]):
            basis[a, c] -= s * basis[b, c]
        off += s * s
    return off


@inner
def square(vector: Array) -> float:
    """Squared Euclidean length."""
    s = 0.0
    for c in range(vector.size):
        s += vector[c] ** 2
    return s


@inner
def solve_in_place(matrix: Array, right: Array) -> None:
    """Solve matrix X = right (d, d), (d, m) by Gaussian elimination with row pivots; X replaces `right`."""
    d, m = right.shape
    for a in range(d):
        pivot = a
        for b in range(a + 1, d):
            if abs(matrix[b, a]) > abs(matrix[pivot, a]):
                pivot = b
        if pivot != a:
            for c in range(d):
                matrix[a, c], matrix[pivot, c] = matrix[pivot, c], matrix[a, c]
            for c in range(m):
                right[a, c], right[pivot, c] = right[pivot, c], right[a, c]
        head = matrix[a, a]
        inverse = 1.0 / (head if abs(head) > 1e-300 else 1e-300)
        for b in range(a + 1, d):
            factor = matrix[b, a] * inverse
            for c in range(a + 1, d):
                matrix[b, c] -= factor * matrix[a, c]
            for c in range(m):
                right[b, c] -= factor * right[a, c]
    for a in range(d - 1, -1, -1):
        inverse = 1.0 / (matrix[a, a] if abs(matrix[a, a]) > 1e-300 else 1e-300)
        for c in range(m):
            s = right[a, c]
            for b in range(a + 1, d):
                s -= matrix[a, b] * right[b, c]
            right[a, c] = s * inverse
