"""The tangent field at edges against the edges' steps: the corrected equation 6, many edges at once.

Arrays end in the edges, so that the same step of many small systems is one loop over values side by side.
"""

from typing import Any

import numpy as np

from skillfold.jit import inner, njit

Array = np.ndarray[Any, np.dtype[np.float64]]

BLOCK = 64  # edges at once: what they work in stays in the fastest memory


@njit
def align_steps(field: Array, steps: Array, ridge: float, eps: Array, misfit: Array) -> None:
    """ε = (H'H + λI)⁻¹ H'Δ into `eps` (d, E) and Hε − Δ into `misfit` (D, E).

    Args:
        field: (d, D, E), H at each edge, a column of it a row here.
        steps: (D, E).
        ridge: λ.
        eps, misfit: written.
    """
    d, D, E = field.shape
    factor = np.empty((d, d, BLOCK))
    eps[:] = 0.0
    for first in range(0, E, BLOCK):
        end = min(first + BLOCK, E)
        factorise(field, first, end, ridge, factor)
        for a in range(d):
            along = eps[a, first:end]
            for c in range(D):
                add(1.0, field[a, c, first:end], steps[c, first:end], along)
            for b in range(a):
                add(-1.0, factor[a, b], eps[b, first:end], along)
            scale(factor[a, a], along)
        for a in range(d - 1, -1, -1):
            along = eps[a, first:end]
            for b in range(a + 1, d):
                add(-1.0, factor[b, a], eps[b, first:end], along)
            scale(factor[a, a], along)
        for c in range(D):
            step, left = steps[c, first:end], misfit[c, first:end]
            for i in range(end - first):
                left[i] = -step[i]
            for a in range(d):
                add(1.0, field[a, c, first:end], eps[a, first:end], left)


@njit
def across(field: Array, ridge: float, added: float, weights: Array, out: Array) -> None:
    """Weighted (1 + added) I − H (H'H + λI)⁻¹ H' at each edge; the field (d, D, E) becomes scratch.

    Args:
        field: H at each edge.
        ridge: λ.
        added: to the projector's eigenvalues.
        weights: (E,).
        out: (D (D + 1) / 2, E), written: the upper half, row by row.
    """
    d, D, E = field.shape
    factor = np.empty((d, d, BLOCK))
    for first in range(0, E, BLOCK):
        end = min(first + BLOCK, E)
        factorise(field, first, end, ridge, factor)
        for a in range(d):
            for c in range(D):
                for b in range(a):
                    add(-1.0, factor[a, b], field[b, c, first:end], field[a, c, first:end])
                scale(factor[a, a], field[a, c, first:end])
        row = 0
        for c in range(D):
            for e in range(c, D):
                found = out[row, first:end]
                found[:] = 1.0 + added if c == e else 0.0
                for a in range(d):
                    add(-1.0, field[a, c, first:end], field[a, e, first:end], found)
                scale(weights[first:end], found)
                row += 1


@inner
def factorise(field: Array, first: int, end: int, ridge: float, factor: Array) -> None:
    """Cholesky factors (d, d, n) of H'H + λI at edges from the first to the end; of the diagonals the inverses."""
    d, D = field.shape[:2]
    for a in range(d):
        for b in range(a + 1):
            entry = factor[a, b, : end - first]
            entry[:] = ridge if a == b else 0.0
            for c in range(D):
                add(1.0, field[a, c, first:end], field[b, c, first:end], entry)
            for j in range(b):
                add(-1.0, factor[a, j], factor[b, j], entry)
            if a == b:
                for i in range(entry.size):
                    entry[i] = 1.0 / np.sqrt(max(entry[i], 1e-300))
            else:
                scale(factor[b, b], entry)


@inner
def add(sign: float, left: Array, right: Array, out: Array) -> None:
    """Out ← out + sign × left × right, value by value."""
    for i in range(out.size):
        out[i] += sign * left[i] * right[i]


@inner
def scale(factors: Array, out: Array) -> None:
    """Out ← out × factors, value by value."""
    for i in range(out.size):
        out[i] *= factors[i]
