"""Projection: anchored Newton from several starts."""

from typing import Any

import numpy as np

from skillfold.jit import njit
from skillfold.manifold.kernels.small import keep_along, norm
from skillfold.manifold.kernels.surface import (
    STARTS,
    Field,
    Scratch,
    Surface,
    displacement,
    make_scratch,
    tangent_basis,
)

Array = np.ndarray[Any, np.dtype[np.float64]]

CLOSE = 0.25  # of a neighbourhood's radius: nearer states are projected from themselves alone
STEPS = 40  # of the anchored Newton iteration
TOLERANCE = 1e-10  # of an iteration, in units of the data's rms radius
NEAR = 1e-6  # in the same units: a displacement this small is taken for the distance


@njit
def descend(
    surface: Surface,
    field: Field,
    state: Array,
    point: Array,
    support: float,
    cap: float,
    scratch: Scratch,
    work: Array,
) -> bool:
    """Anchored Newton from `point` (changed in place) to the surface's closest point to `state`.

    Each step goes along the surface toward `state` and straight back onto it; both parts are capped. The step
    along shrinks where it overshoots or leaves the support. Ends with steps back alone.
    """
    normal, along, previous = work[0], work[1], work[2]
    rate, before = 1.0, np.inf
    converged = False
    for step in range(STEPS):
        square = displacement(surface, field, point, scratch, normal)
        if square > support and step > 0:
            rate *= 0.5
            for c in range(point.size):
                point[c] = 0.5 * (point[c] + previous[c])
            displacement(surface, field, point, scratch, normal)
        for c in range(point.size):
            along[c] = state[c] - point[c]
        keep_along(scratch.basis, along, scratch.along)
        off, pull = norm(normal), norm(along)
        if off < TOLERANCE and rate * pull < TOLERANCE:
            converged = True
            break
        if pull > 0.7 * before:
            rate = max(0.6 * rate, 0.05)
        before = pull
        back = min(1.0, cap / max(off, 1e-300))
        forth = min(rate, cap / max(pull, 1e-300))
        for c in range(point.size):
            previous[c] = point[c]
            point[c] += forth * along[c] - back * normal[c]
    for _ in range(0 if converged else 3):
        displacement(surface, field, point, scratch, normal)
        for c in range(point.size):
            point[c] -= normal[c]
    return converged


@njit
def project_state(
    surface: Surface,
    field: Field,
    state: Array,
    support: float,
    cap: float,
    scratch: Scratch,
    work: Array,
    out: Array,
) -> bool:
    """The closest point of the surface, found from the state itself and from its nearest anchors, into `out`.

    Returns whether it lies within the support (near some anchor).
    """
    D = state.size
    point = work[3]
    displacement(surface, field, state, scratch, work[0])
    close = norm(work[0]) < CLOSE * surface.radii[scratch.nearest[0]]
    starts = min(STARTS, scratch.nearest.size - 1)
    for s in range(starts):
        scratch.starts[s] = scratch.nearest[s]
    best, best_inside = np.inf, False
    out[:] = state
    for s in range(-1, starts):
        for c in range(D):
            point[c] = state[c] if s < 0 else surface.points[c, scratch.starts[s]]
        settled = descend(surface, field, state, point, support, cap, scratch, work)
        square = displacement(surface, field, point, scratch, work[0])
        inside = norm(work[0]) < 1e3 * TOLERANCE and square <= support
        distance = 0.0
        for c in range(D):
            distance += (state[c] - point[c]) ** 2
        if (inside and not best_inside) or (inside == best_inside and distance < best):
            best, best_inside = distance, inside
            out[:] = point
        if s < 0 and close and settled and inside:
            break
    return best_inside


@njit
def project_states(surface: Surface, field: Field, states: Array, support: float, cap: float) -> tuple:
    """`project_state` for a batch (B, D); returns points (B, D) and whether each is supported (B,)."""
    B, D = states.shape
    scratch = make_scratch(surface, field)
    work = np.empty((4, D))
    points, inside = np.empty((B, D)), np.empty(B, np.bool_)
    for i in range(B):
        inside[i] = project_state(surface, field, states[i], support, cap, scratch, work, points[i])
    return points, inside


@njit
def project_near(surface: Surface, field: Field, states: Array, near: Array, support: float, cap: float) -> tuple:
    """Closest points to states (B, D) found by descent from near (B, D) alone; points and whether supported."""
    B, D = states.shape
    scratch = make_scratch(surface, field)
    work = np.empty((4, D))
    points, inside = near.copy(), np.empty(B, np.bool_)
    for i in range(B):
        descend(surface, field, states[i], points[i], support, cap, scratch, work)
        square = displacement(surface, field, points[i], scratch, work[0])
        inside[i] = norm(work[0]) < 1e3 * TOLERANCE and square <= support
    return points, inside


@njit
def follow_leaf(field: Field, states: Array, near: Array, rate: float, steps: int) -> Array:
    """The printed update q' ← q' + α H'H''(q − q') for a batch (B, D), from near (B, D)."""
    B, D = states.shape
    d = field.weights.shape[0]
    basis, features = np.empty((d, D)), np.empty(field.centres.shape[1])
    along, work = np.empty(D), np.empty(d)
    points = near.copy()
    for i in range(B):
        for _ in range(steps):
            tangent_basis(field, points[i], features, basis)
            for c in range(D):
                along[c] = states[i, c] - points[i, c]
            keep_along(basis, along, work)
            if norm(along) < TOLERANCE:
                break
            for c in range(D):
                points[i, c] += rate * along[c]
    return points


@njit
def tangent_bases(field: Field, states: Array) -> Array:
    """Orthonormal rows of H at states (B, D): (B, d, D)."""
    B, D = states.shape
    bases = np.empty((B, field.weights.shape[0], D))
    features = np.empty(field.centres.shape[1])
    for i in range(B):
        tangent_basis(field, states[i], features, bases[i])
    return bases


@njit
def displacements(surface: Surface, field: Field, states: Array) -> tuple:
    """Displacements from the surface to states (B, D), and distances to the nearest anchor (B,)."""
    B, D = states.shape
    scratch = make_scratch(surface, field)
    normals, nearest = np.empty((B, D)), np.empty(B)
    for i in range(B):
        nearest[i] = np.sqrt(displacement(surface, field, states[i], scratch, normals[i]))
    return normals, nearest


@njit
def distances(surface: Surface, field: Field, states: Array, support: float, cap: float) -> Array:
    """Distances of states (B, D) from the modelled surface.

    A state this near needs no projection: the displacement is the distance, up to its square.
    """
    B, D = states.shape
    scratch = make_scratch(surface, field)
    work, point = np.empty((4, D)), np.empty(D)
    result = np.empty(B)
    for i in range(B):
        displacement(surface, field, states[i], scratch, work[0])
        result[i] = norm(work[0])
        if result[i] > NEAR:
            project_state(surface, field, states[i], support, cap, scratch, work, point)
            for c in range(D):
                point[c] -= states[i, c]
            result[i] = norm(point)
    return result


@njit
def nearest_distances(surface: Surface, states: Array) -> Array:
    """Distances of states (B, D) from their nearest anchor."""
    D, M = surface.points.shape
    result = np.empty(states.shape[0])
    squares = np.empty(M)
    for i in range(states.shape[0]):
        squares[:] = 0.0
        for c in range(D):
            for j in range(M):
                squares[j] += (states[i, c] - surface.points[c, j]) ** 2
        result[i] = np.sqrt(squares.min())
    return result
