"""Anderson's acceleration of an iteration on paths (n, D), and steps along them."""

from typing import Any

import numpy as np

from skillfold.jit import inlined, inner
from skillfold.manifold.kernels.small import copy, norm, solve_in_place

Array = np.ndarray[Any, np.dtype[np.float64]]

ALIKE = 1e-10  # relative, on the diagonal of the equations: two steps may point the same way


@inlined
def mix(path_changes: Array, step_changes: Array, steps: Array) -> None:
    """Anderson's acceleration: steps ← steps − (ΔQ + ΔF) γ, where γ minimises ‖steps − ΔF γ‖.

    ΔQ, ΔF (m, n, D) tell how the path and its steps changed in the last m iterations: where each iteration
    leaves a share of the error, a few of them tell where all would end.
    """
    m, size = len(step_changes), steps.size
    flat, moved, changed = steps.reshape(size), path_changes.reshape(m, size), step_changes.reshape(m, size)
    gram, right = np.empty((m, m)), np.empty((m, 1))
    for a in range(m):
        for b in range(a + 1):
            gram[a, b] = gram[b, a] = dot(changed[a], changed[b])
        gram[a, a] *= 1.0 + ALIKE
        right[a, 0] = dot(changed[a], flat)
    solve_in_place(gram, right)
    for a in range(m):
        for i in range(size):
            flat[i] -= right[a, 0] * (moved[a, i] + changed[a, i])


@inner
def dot(a: Array, b: Array) -> float:
    """Sum of the products of two vectors."""
    s = 0.0
    for i in range(a.size):
        s += a[i] * b[i]
    return s


@inlined
def copy_rows(source: Array, out: Array) -> None:
    """Copy an array (n, D)."""
    for i in range(len(source)):
        copy(source[i], out[i])


@inlined
def take(path: Array, steps: Array, rate: float, cap: float) -> None:
    """Take a share `rate` of the steps (n, D), none longer than `cap`; they are left as taken."""
    for i in range(len(path)):
        shrink = min(rate, cap / max(norm(steps[i]), 1e-300))
        for c in range(path.shape[1]):
            steps[i, c] *= shrink
            path[i, c] += steps[i, c]


@inlined
def longest(steps: Array) -> float:
    """The largest length of a row."""
    size = 0.0
    for i in range(len(steps)):
        size = max(size, norm(steps[i]))
    return size
