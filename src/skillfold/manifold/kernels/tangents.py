"""The tangent field H at states: its orthonormal bases, and what lies across them."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inlined, inner
from skillfold.lanes import LANES, larger, load, smaller, spread, store
from skillfold.manifold.kernels.small import orthonormalise

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

ACROSS = 0.25  # squared sines, summed over directions: the share of a displacement that is left each time


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
def stand_in(charts: Array, radii: Array, nearest: Indices, row: Array, bases: Array) -> None:
    """Orthonormal rows (n, d, D) that lie across the surface ← the tangents of the nearest anchor.

    Where samples end, sums of a few kernels' weights may turn away from the surface by a right angle. Then what is
    taken off a displacement along the ones is what leads back to the other, and no iteration gets there.

    Args:
        charts, radii: of the surface.
        nearest: (n, …) anchors of each state, the nearest first.
        row: (e,) memory.
        bases: rows in place.
    """
    n, d, D = bases.shape
    rows, e = charts.shape[1], charts.shape[2]
    for i in range(n):
        first, along = nearest[i, 0] * rows * e, 0.0
        for a in range(d):
            for b in range(0, e, LANES):
                u = spread(0.0)
                for c in range(D):
                    u = u + load(charts, first + (1 + c) * e + b) * spread(bases[i, a, c])
                store(u * u, row, 0)
                along += row[0] + row[1] + row[2] + row[3]
        if along * radii[nearest[i, 0]] ** 2 < d - ACROSS:
            for a in range(d):
                for c in range(D):
                    bases[i, a, c] = charts[nearest[i, 0], 1 + c, a]
            orthonormalise(bases[i])


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
