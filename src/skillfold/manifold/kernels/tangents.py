"""The tangent field H at states: its orthonormal bases, and what lies across them."""

from typing import Any

import numpy as np

from skillfold.jit import inlined, inner
from skillfold.manifold.kernels.small import orthonormalise

Array = np.ndarray[Any, np.dtype[np.float64]]


@inner
def falling(x: float) -> float:
    """exp(x) for x ≤ 0 to 13 digits, in steps that a loop over an array does several of at once.

    By the series at x / 1024, squared ten times; what is smaller than e⁻⁴⁰ is taken for that.
    """
    y = max(x, -40.0) / 1024.0
    value = 1.0 + y * (1.0 + y * (1.0 / 2.0 + y * (1.0 / 6.0 + y * (1.0 / 24.0 + y * (1.0 / 120.0 + y / 720.0)))))
    for _ in range(10):
        value *= value
    return value


@inner
def tangent_bases(
    centres: Array, precision: float, weights: Array, states: Array, features: Array, bases: Array
) -> bool:
    """Orthonormal rows (n, d, D) of H at states (n, D) into `bases`.

    Returns False where H lost rank at one of them and an axis was put in.
    """
    D, K = centres.shape
    d = weights.shape[0]
    full_rank = True
    for i in range(len(states)):
        features[:] = 0.0
        for c in range(D):
            here = states[i, c]
            for k in range(K):
                features[k] += (here - centres[c, k]) ** 2
        low = features[0]
        for k in range(1, K):
            low = min(low, features[k])
        for k in range(K):
            features[k] = falling((low - features[k]) * precision)
        total = 0.0
        for k in range(K):
            total += features[k]
        for a in range(d):
            for c in range(D):
                s = 0.0
                for k in range(K):
                    s += features[k] * weights[a, c, k]
                bases[i, a, c] = s / total
        full_rank &= orthonormalise(bases[i])
    return full_rank


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
