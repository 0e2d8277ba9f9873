"""The tangent field alone: its bases at many states, the printed projection and the printed geodesics.

`t` is the table of a model (see `tabled`), whose inner coordinates all states are in.
"""

from typing import Any

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.manifold.kernels.small import copy, keep_along, norm, solve_in_place
from skillfold.manifold.kernels.tabled import CENTRES, PRECISION, WEIGHTS, dimension
from skillfold.manifold.kernels.tangents import tangent_bases
from skillfold.tables import Indices, matrix, vector

Array = np.ndarray[Any, np.dtype[np.float64]]

TOLERANCE = 1e-10  # of a step, in units of the data's rms radius


@inlined
def bases_at(t: Indices, states: Array, features: Array, row: Array, bases: Array) -> None:
    """`tangent_bases` of the model of a table, in memory of its K features and of a row of its weights."""
    tangent_bases(matrix(t, CENTRES), vector(t, PRECISION)[0], matrix(t, WEIGHTS), states, features, row, bases)


@njit
def follow_leaf(t: Indices, states: Array, near: Array, rate: float, steps: int) -> Array:
    """The printed update q' ← q' + α H'H''(q − q') for a batch (B, D), from near (B, D)."""
    B, D = states.shape
    d, (K, w) = dimension(t), matrix(t, WEIGHTS).shape
    bases, features, row = np.empty((1, d, D)), np.empty(K), np.empty(w)
    along, work = np.empty(D), np.empty(d)
    points = near.copy()
    for i in range(B):
        for _ in range(steps):
            bases_at(t, points[i : i + 1], features, row, bases)
            for c in range(D):
                along[c] = states[i, c] - points[i, c]
            keep_along(bases[0], along, work)
            if norm(along) < TOLERANCE:
                break
            for c in range(D):
                points[i, c] += rate * along[c]
    return points


@njit
def field_bases(t: Indices, states: Array) -> Array:
    """Orthonormal rows of H at states (B, D): (B, d, D)."""
    (K, w), bases = matrix(t, WEIGHTS).shape, np.empty((len(states), dimension(t), states.shape[1]))
    bases_at(t, states, np.empty(K), np.empty(w), bases)
    return bases


@njit
def relax_on_field(t: Indices, path: Array, tolerance: float, limit: int) -> tuple:
    """The printed conditions of section IV-A4 solved together, in place; (iterations, largest last step).

    At each inner point, with N the normal projector there and P⊥ that at the midpoints to its neighbours,

        N [P⊥₋(q_i − q_{i−1}) − P⊥₊(q_{i+1} − q_i)] = 0,    T'(q_{i−1} − 2q_i + q_{i+1}) = 0.

    The projectors are frozen in each iteration, which leaves a block tridiagonal system in D-vectors.
    """
    n, D = path.shape
    d, (K, w) = dimension(t), matrix(t, WEIGHTS).shape
    features, row, bases, midways = np.empty(K), np.empty(w), np.empty((n, d, D)), np.empty((n - 1, d, D))
    across = np.empty((n - 1, D, D))
    here = np.empty((D, D))
    right = np.empty((n, D, D + 1))
    moved, iteration = np.inf, 0
    while iteration < limit and moved >= tolerance:
        iteration += 1
        middle = 0.5 * (path[1:] + path[:-1])
        bases_at(t, path, features, row, bases)
        bases_at(t, middle, features, row, midways)
        for i in range(n - 1):
            normal_projector(midways[i], across[i])
        right[:] = 0.0
        copy(path[0], right[0, :, D])
        copy(path[n - 1], right[n - 1, :, D])
        for i in range(1, n - 1):
            normal_projector(bases[i], here)
            # (I − N) turns the second difference into its part along the surface.
            before = here @ across[i - 1] + np.eye(D) - here
            after = here @ across[i] + np.eye(D) - here
            block = before + after
            for a in range(D):
                for c in range(D):
                    for b in range(D):
                        block[a, b] -= before[a, c] * right[i - 1, c, b]
                    right[i, a, D] += before[a, c] * right[i - 1, c, D]
                    if i == n - 2:
                        right[i, a, D] += after[a, c] * path[n - 1, c]
                    else:
                        right[i, a, c] = after[a, c]
            solve_in_place(block, right[i])
        moved = 0.0
        for i in range(n - 2, 0, -1):
            size = 0.0
            for a in range(D):
                value = right[i, a, D]
                if i < n - 2:
                    for c in range(D):
                        value += right[i, a, c] * path[i + 1, c]
                size += (value - path[i, a]) ** 2
                path[i, a] = value
            moved = max(moved, np.sqrt(size))
    return iteration, moved


@inner
def normal_projector(basis: Array, out: Array) -> None:
    """I − T'T for orthonormal rows T (d, D), into `out` (D, D)."""
    d, D = basis.shape
    for a in range(D):
        for b in range(D):
            s = 1.0 if a == b else 0.0
            for e in range(d):
                s -= basis[e, a] * basis[e, b]
            out[a, b] = s
