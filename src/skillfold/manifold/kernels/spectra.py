"""Eigenvectors of many small symmetric matrices, for which LAPACK takes twice as long.

Householder's reduction to three diagonals, then Wilkinson's implicit shifts (Golub and Van Loan, section 8.3).
"""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner, njit

Array = np.ndarray[Any, np.dtype[np.float64]]

MOST = 60  # shifts for one eigenvalue: two are usual
SMALL = 1e-16  # relative: off-diagonal entries that count as none


@njit
def principal_rows(matrices: Array) -> Array:
    """Eigenvectors of symmetric matrices (M, D, D) as rows, that of the largest eigenvalue first; (M, D, D)."""
    M, D = matrices.shape[:2]
    rows, work = np.empty((M, D, D)), np.empty((D, D))
    diagonal, beside, v, p = np.empty(D), np.empty(D), np.empty(D), np.empty(D)
    for m in range(M):
        work[:] = matrices[m]
        reduce(work, rows[m], diagonal, beside, v, p)
        diagonalise(rows[m], diagonal, beside)
        sort_rows(rows[m], diagonal)
    return rows


@inner
def reduce(A: Array, rows: Array, diagonal: Array, beside: Array, v: Array, p: Array) -> None:
    """A (D, D), overwritten, = rows' T rows with T of three diagonals: `diagonal` and, before each, `beside`."""
    D = len(A)
    rows[:] = 0.0
    for a in range(D):
        rows[a, a] = 1.0
    for k in range(D - 2):
        length = 0.0
        for c in range(D):
            v[c] = A[k, c] if c > k else 0.0
            length += v[c] * v[c]
        length = math.copysign(math.sqrt(length), v[k + 1])
        twice = 2.0 * length * (length + v[k + 1])
        if not twice > 1e-300:
            continue
        v[k + 1] += length
        # The reflection I − 2 v v' / v'v, from both sides of A and from one of the rows.
        apply(A, v, p)
        dot = 0.0
        for c in range(D):
            dot += p[c] * v[c]
        for c in range(D):
            p[c] = (2.0 * p[c] - 2.0 * dot / twice * v[c]) / twice
        for a in range(k, D):
            x, y = v[a], p[a]
            for c in range(D):
                A[a, c] -= x * p[c] + y * v[c]
        apply(rows, v, p)
        for a in range(k + 1, D):
            x = 2.0 * v[a] / twice
            for c in range(D):
                rows[a, c] -= x * p[c]
    for a in range(D):
        diagonal[a] = A[a, a]
        beside[a] = A[a - 1, a] if a else 0.0


@inner
def apply(matrix: Array, v: Array, out: Array) -> None:
    """Out ← matrix' v."""
    out[:] = 0.0
    for a in range(v.size):
        x = v[a]
        if x != 0.0:
            for c in range(v.size):
                out[c] += x * matrix[a, c]


@inner
def diagonalise(rows: Array, diagonal: Array, beside: Array) -> None:
    """Turn the rows so that rows' T rows keeps its value while T becomes diagonal."""
    D = diagonal.size
    for low in range(D - 1):
        for _ in range(MOST):
            end = low
            while end < D - 1:
                size = abs(diagonal[end]) + abs(diagonal[end + 1])
                if abs(beside[end + 1]) <= SMALL * size:
                    break
                end += 1
            if end == low:
                break
            sweep(rows, diagonal, beside, low, end)


@inner
def sweep(rows: Array, diagonal: Array, beside: Array, low: int, end: int) -> None:
    """One implicit shift toward the eigenvalue at `low`, chased up from `end`."""
    gap = (diagonal[low + 1] - diagonal[low]) / (2.0 * beside[low + 1])
    root = math.sqrt(gap * gap + 1.0)
    g = diagonal[end] - diagonal[low] + beside[low + 1] / (gap + math.copysign(root, gap))
    s, c, taken = 1.0, 1.0, 0.0
    for i in range(end - 1, low - 1, -1):
        f, b = s * beside[i + 1], c * beside[i + 1]
        r = math.sqrt(f * f + g * g)
        if i + 2 <= end:
            beside[i + 2] = r
        if r == 0.0:
            diagonal[i + 1] -= taken
            break
        s, c = f / r, g / r
        g = diagonal[i + 1] - taken
        r = (diagonal[i] - g) * s + 2.0 * c * b
        taken = s * r
        diagonal[i + 1] = g + taken
        g = c * r - b
        for j in range(rows.shape[1]):
            upper, lower = rows[i, j], rows[i + 1, j]
            rows[i + 1, j] = s * upper + c * lower
            rows[i, j] = c * upper - s * lower
    else:
        diagonal[low] -= taken
        beside[low + 1] = g
    if end + 1 < diagonal.size:
        beside[end + 1] = 0.0


@inner
def sort_rows(rows: Array, values: Array) -> None:
    """Rows and their values in descending order of these."""
    D = values.size
    for a in range(D - 1):
        best = a
        for b in range(a + 1, D):
            if values[b] > values[best]:
                best = b
        if best != a:
            values[a], values[best] = values[best], values[a]
            for c in range(rows.shape[1]):
                rows[a, c], rows[best, c] = rows[best, c], rows[a, c]
