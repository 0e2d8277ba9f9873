"""The tangent field H at states: its orthonormal bases, and what lies across them."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inlined, inner
from skillfold.lanes import LANES, larger, load, smaller, spread, store
from skillfold.manifold.kernels.small import copy, orthonormalise

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

# Squared sines between the field's directions and the nearest anchor's, summed: the share of a displacement that is
# left each time. From which on, and up to which more and more, the anchors' tangents are lent; and how much of them.
ACROSS, WHOLLY, LENT = 0.6, 0.9, 0.5


@inner
def falling(x: Any) -> Any:
    """exp(x) of lanes x ≤ 0, off by 1e-13 at most: the series at x / 1024, squared ten times.

    What is smaller than e⁻⁴⁰ is taken for that.
    """
    y = larger(x, spread(-40.0)) * spread(1.0 / 1024.0)
    value = spread(1.0 / 120.0) + y * spread(1.0 / 720.0)
    value = spread(1.0 / 6.0) + y * (spread(1.0 / 24.0) + y * value)
    value = spread(1.0) + y * (spread(1.0) + y * (spread(1.0 / 2.0) + y * value))
    for _ in range(10):
        value = value * value
    return value


@inlined
def features_at(centres: Array, precision: float, states: Array, i: int, row: Array, features: Array) -> None:
    """Radial basis functions (K,) of state i, the largest of them 1, so that they do not all vanish far out.

    For centres (D, K), where K is a multiple of four (see `lanes`).
    """
    D, K = centres.shape
    least = spread(math.inf)
    for k in range(0, K, LANES):
        square = spread(0.0)
        for c in range(D):
            away = load(centres, c * K + k) - spread(states[i, c])
            square = square + away * away
        store(square, features, k)
        least = smaller(least, square)
    store(least, row, 0)
    low = spread(min(min(row[0], row[1]), min(row[2], row[3])))
    for k in range(0, K, LANES):
        store(falling((low - load(features, k)) * spread(precision)), features, k)


@inner
def tangent_bases(
    centres: Array, precision: float, weights: Array, states: Array, features: Array, row: Array, bases: Array
) -> bool:
    """Orthonormal rows (n, d, D) of H at states (n, D) into `bases`.

    Of centres (D, K) and weights (K, w) filled up for lanes (see `tabled`), in memory `features` (K,) and `row` (w,).
    Returns False where H lost rank at one of them and an axis was put in.
    """
    K, w = weights.shape
    _, d, D = bases.shape
    full_rank = True
    for i in range(len(states)):
        features_at(centres, precision, states, i, row, features)
        for b in range(0, w, LANES):
            total = spread(0.0)  # its length does not matter
            for k in range(K):
                total = total + load(weights, k * w + b) * spread(features[k])
            store(total, row, b)
        for a in range(d):
            for c in range(D):
                bases[i, a, c] = row[a * D + c]
        full_rank &= orthonormalise(bases[i])
    return full_rank


@inlined
def stand_in(
    charts: Array, radii: Array, nearest: Indices, weights: Array, row: Array, mixed: Array, bases: Array
) -> None:
    """Orthonormal rows (n, d, D) that lie across the surface ← what the tangents of the blended anchors add to them.

    Where samples end, sums of a few kernels' weights may turn away from the surface by a right angle. Then what is
    taken off a displacement along the ones is what leads back to the other, and no iteration gets there.

    Args:
        charts, radii: of the surface.
        nearest, weights: anchors of each state, the nearest first, and weights (n, m) of those that are blended.
        row, mixed: (e,) and (d, D) memory.
        bases: rows in place.
    """
    d = bases.shape[1]
    for i in range(len(bases)):
        across = d - along_chart(charts, radii, nearest[i, 0], bases[i], row)
        if across > ACROSS:
            share = LENT * min((across - ACROSS) / (WHOLLY - ACROSS), 1.0)
            lend(charts, radii, nearest[i], weights[i], share, mixed, bases[i])


@inlined
def along_chart(charts: Array, radii: Array, anchor: int, basis: Array, row: Array) -> float:
    """Squared cosines, summed over directions, between orthonormal rows (d, D) and an anchor's tangents."""
    _, rows, e = charts.shape
    first, along = anchor * rows * e, 0.0
    for a in range(basis.shape[0]):
        for b in range(0, e, LANES):
            u = spread(0.0)
            for c in range(basis.shape[1]):
                u = u + load(charts, first + (1 + c) * e + b) * spread(basis[a, c])
            store(u * u, row, 0)
            along += row[0] + row[1] + row[2] + row[3]
    return along * radii[anchor] ** 2


@inner
def lend(
    charts: Array, radii: Array, nearest: Indices, weights: Array, share: float, mixed: Array, basis: Array
) -> None:
    """Orthonormal rows ← the nearest anchor's tangents T, as T (B + share Σ w P): B along the rows, P along anchors'.

    A direction at the angle φ to the rows is cos φ of B and a share of P: one that they hold stays, one that lies
    across comes from the anchors, and neither jumps where the nearest anchor changes.
    """
    d, D = basis.shape
    mixed[:] = 0.0
    for a in range(d):
        for b in range(d):
            s = 0.0
            for c in range(D):
                s += charts[nearest[0], 1 + c, a] * basis[b, c]
            for c in range(D):
                mixed[a, c] += s * basis[b, c]
            for j in range(weights.size):
                k, s = nearest[j], 0.0
                for c in range(D):
                    s += charts[nearest[0], 1 + c, a] * charts[k, 1 + c, b]
                s *= share * weights[j] * radii[k] ** 2
                for c in range(D):
                    mixed[a, c] += s * charts[k, 1 + c, b]
    for a in range(d):
        copy(mixed[a], basis[a])
    orthonormalise(basis)


@inlined
def keep_tangential(bases: Array, vectors: Array, along: Array) -> None:
    """Vectors (n, D) ← what of them lies along the orthonormal rows of the first n bases (…, d, D)."""
    n, D = vectors.shape
    for i in range(n):
        for a in range(along.size):
            s = 0.0
            for c in range(D):
                s += bases[i, a, c] * vectors[i, c]
            along[a] = s
        for c in range(D):
            vectors[i, c] = 0.0
        for a in range(along.size):
            for c in range(D):
                vectors[i, c] += along[a] * bases[i, a, c]


@inlined
def remove_tangential(bases: Array, vectors: Array, along: Array) -> None:
    """Vectors (n, D) ← what of them lies across the orthonormal rows of bases (n, d, D)."""
    n, d, D = bases.shape
    for i in range(n):
        for a in range(d):
            s = 0.0
            for c in range(D):
                s += bases[i, a, c] * vectors[i, c]
            along[a] = s
        for a in range(d):
            for c in range(D):
                vectors[i, c] -= along[a] * bases[i, a, c]
