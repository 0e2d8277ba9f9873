"""Sections IV-A and IV-C of paper 000 as they are printed, in plain NumPy: short, slow, and faults included.

What the solvers of this library are held against. Each function asks only for a tangent field, `tangent(states)`:
states (..., D) to orthonormal bases (..., D, d), such as the `tangent` of a fitted skill. In print and in need of
a word:

- Algorithm 1 starts with distPrev = ∞, so it bisects at once and returns the straight line; were its geodesic step
  ever reached, it would go away from the other end, and the state it makes is never stored.
- err_M alone keeps neighbouring tangents aligned: no term ties a path to the data.
- The projection slides along one leaf of the field, so its answer depends on where it starts.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
Tangent = Callable[[Array], Array]

STEP = 0.24  # of the descent: both errors have second derivatives up to 8, and 2 / 8 diverges
RATE = 0.1  # α of the projection; 1 drifts off the leaf
TOLERANCE = 1e-12  # of the longest move in one iteration, in units of the states
LIMIT = 100_000  # iterations
LEAST = 0.01  # of a growing step that must bring the ends closer


def first_path_as_printed(tangent: Tangent, start: Array, goal: Array, spacing: float) -> Array:
    """Algorithm 1 to the letter, with the midpoints of its recursion as the path; (n, D).

    Args:
        tangent: never asked.
        start, goal: (D,).
        spacing: ℓ, the distance at which the recursion ends.
    """

    def between(left: Array, right: Array) -> list[Array]:
        before = np.inf
        while True:
            difference = left - right
            distance = float(np.linalg.norm(difference))
            if distance < spacing:
                return []
            if distance < before:  # always, the first time round
                middle = (left + right) / 2
                return [*between(left, middle), middle, *between(middle, right)]
            before = distance
            left = left + spacing * _along(tangent(left), difference / distance)

    return np.array([start, *between(start, goal), goal])


def first_path(tangent: Tangent, start: Array, goal: Array, spacing: float) -> Array:
    """Algorithm 1 mended: grown from both ends in turn, along the field toward the other end; (n, D).

    It ends where they are `spacing` apart, or get hardly closer: leaves of the field need not meet.
    """
    sides = [start], [goal]
    before, gap = np.inf, float(np.linalg.norm(goal - start))
    while spacing < gap < before - LEAST * spacing:
        here, there = sides if len(sides[0]) <= len(sides[1]) else sides[::-1]
        direction = _along(tangent(here[-1]), there[-1] - here[-1])
        here.append(here[-1] + direction * spacing / max(spacing, float(np.linalg.norm(direction))))
        before, gap = gap, float(np.linalg.norm(there[-1] - here[-1]))
    return np.array([*sides[0], *sides[1][::-1]])


def manifold_gradient(tangent: Tangent, path: Array) -> Array:
    """∂err_M/∂q at the inner states of a path (n, D), the tangents held fixed; (n - 2, D).

    With the best ε, err_M = Σ ‖P⊥(q_i − q_{i−1})‖², P⊥ normal to the field at the midpoint.
    """
    steps = np.diff(path, axis=0)
    across = steps - _along(tangent((path[1:] + path[:-1]) / 2), steps)
    return 2.0 * (across[:-1] - across[1:])


def length_gradient(path: Array) -> Array:
    """∂err_length/∂q at the inner states of a path (n, D), err_length = Σ ‖q_i − q_{i−1}‖²; (n - 2, D)."""
    steps = np.diff(path, axis=0)
    return 2.0 * (steps[:-1] - steps[1:])


def descend(
    tangent: Tangent, path: Array, step: float = STEP, tolerance: float = TOLERANCE, limit: int = LIMIT
) -> tuple[Array, int]:
    """The two-step gradient descent of section IV-A4: a path (n, D) with its ends fixed, and the iterations.

    One step along the part of err_M's gradient that is normal to the field, one along the part of err_length's
    that is parallel to it. Converges for steps below 0.25, in a number of iterations that grows with n².

    Args:
        tangent: the field.
        path: first path (n, D).
        step: of both descents.
        tolerance: of the longest move of a state in one iteration.
        limit: of iterations.
    """
    path = path.copy()
    for iteration in range(1, limit + 1):
        before = path[1:-1].copy()
        gradient = manifold_gradient(tangent, path)
        path[1:-1] -= step * (gradient - _along(tangent(path[1:-1]), gradient))
        path[1:-1] -= step * _along(tangent(path[1:-1]), length_gradient(path))
        if np.linalg.norm(path[1:-1] - before, axis=1).max() < tolerance:
            return path, iteration
    return path, limit


def project(
    tangent: Tangent,
    states: Array,
    near: Array,
    rate: float = RATE,
    tolerance: float = TOLERANCE,
    limit: int = LIMIT,
) -> Array:
    """Section IV-C1: q' ← q' + α H'H'ᵀ(q − q') for states q (..., D), from on-manifold states `near` (..., D)."""
    found = near.copy()
    for _ in range(limit):
        move = _along(tangent(found), states - found)
        found += rate * move
        if np.linalg.norm(move, axis=-1).max() < tolerance:
            break
    return found


def _along(basis: Array, vectors: Array) -> Array:
    """H Hᵀ v for orthonormal bases (..., D, d) and vectors (..., D)."""
    return (basis @ (np.swapaxes(basis, -1, -2) @ vectors[..., None]))[..., 0]
