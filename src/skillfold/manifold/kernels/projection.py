"""Projection: anchored Newton from several starts."""

from typing import Any

import numpy as np

from skillfold.jit import njit
from skillfold.manifold.kernels.neighbours import smallest
from skillfold.manifold.kernels.small import copy, keep_along, norm
from skillfold.manifold.kernels.surface import (
    Field,
    Flags,
    Indices,
    Scratch,
    Surface,
    Trust,
    evaluate,
    find_nearest,
    make_scratch,
)
from skillfold.manifold.kernels.tangents import tangent_bases

Array = np.ndarray[Any, np.dtype[np.float64]]

CLOSE = 0.25  # of a neighbourhood's radius: nearer states are projected from themselves alone
STEPS = 30.0  # (a float: for each whole number Numba would compile anew) of the anchored Newton iteration
TOLERANCE = 1e-10  # of an iteration, in units of the data's rms radius
AROUND = 2.0  # spacings beyond the nearest anchor in which sure ones are looked for
SMALLEST_RATE = 1e-3  # of the step along the surface: below it the edge of the support is met
BACK_STEPS = 20  # straight onto the surface, at the end
ROUGH, ROUGH_STEPS = 1e-4, 12.0  # the same, while several starts are compared


@njit
def descend(
    surface: Surface,
    field: Field,
    farthest: float,
    most_doubt: float,
    cap: float,
    state: Array,
    points: Array,
    tolerance: float,
    steps: float,
    scratch: Scratch,
    work: Array,
) -> bool:
    """Anchored Newton from the one of `points` (1, D; changed in place) to the surface's closest point to `state`.

    Each step goes along the surface toward `state` and straight back onto it; both parts are capped. The step
    along shrinks where it overshoots, and where it would go `farthest` from the anchors or where these disagree by
    `most_doubt`: then the answer is the edge of that. Ends with steps straight back. Returns whether the surface
    was met.
    """
    along, previous, within = work[0], work[1], scratch.along
    point, normal, basis = points[0], scratch.normals[0], scratch.bases[0]
    squares, doubts = scratch.squares, scratch.doubts
    rate, before, off = 1.0, np.inf, np.inf
    for step in range(int(steps)):
        evaluate(surface, field, points, scratch)
        if step > 0 and (squares[0, 0] > farthest**2 or doubts[0] > most_doubt):
            rate *= 0.5
            copy(previous, point)
            evaluate(surface, field, points, scratch)
        for c in range(point.size):
            along[c] = state[c] - point[c]
        keep_along(basis, along, within)
        off, pull = norm(normal), norm(along)
        if off < tolerance and rate * pull < tolerance:
            return True
        if rate < SMALLEST_RATE:
            break
        if pull > 0.7 * before:
            rate = max(0.6 * rate, 0.05)
        before = pull
        back = min(1.0, cap / max(off, 1e-300))
        forth = min(rate, cap / max(pull, 1e-300))
        for c in range(point.size):
            previous[c] = point[c]
            point[c] += forth * along[c] - back * normal[c]
    return step_back(surface, field, points, tolerance, scratch)


@njit
def step_back(surface: Surface, field: Field, points: Array, tolerance: float, scratch: Scratch) -> bool:
    """Straight from the one of `points` (1, D; changed in place) to its foot. Returns whether the surface was met."""
    point, normal = points[0], scratch.normals[0]
    for _ in range(BACK_STEPS):
        evaluate(surface, field, points, scratch)
        if norm(normal) < tolerance:
            return True
        for c in range(point.size):
            point[c] -= normal[c]
    return False


@njit
def find_starts(
    points: Array, spacing: float, sure: Flags, state: Array, distances: Array, starts: Indices, squares: Array
) -> None:
    """The nearest sure anchors into `starts`; simply the nearest ones where sure ones are few around."""
    distances[:] = 0.0
    for c in range(state.size):
        for i in range(distances.size):
            distances[i] += (state[c] - points[c, i]) ** 2
    smallest(distances, starts, squares)
    enough = (np.sqrt(squares[0]) + AROUND * spacing) ** 2
    count = 0
    for i in range(sure.size):
        if sure[i] and distances[i] <= enough:
            count += 1
        else:
            distances[i] = np.inf
    if count >= starts.size:
        smallest(distances, starts, squares)


@njit
def project_state(
    surface: Surface, field: Field, trust: Trust, state: Array, scratch: Scratch, work: Array, out: Array
) -> bool:
    """The closest trusted point of the surface into `out` (1, D); whether one was met.

    A state near the surface is projected from itself, outside the demonstrations too. One far off could meet the
    surface anywhere, also where nothing was demonstrated: it is projected from its nearest sure anchors, within
    what is trusted, and no farther than to the foot of the nearest of them.
    """
    copy(state, out[0])
    evaluate(surface, field, out, scratch)
    off = norm(scratch.normals[0])
    if off < TOLERANCE:
        return True
    near = off < CLOSE * surface.radii[scratch.nearest[0, 0]] and scratch.doubts[0] < trust.ghost
    if near and descend(surface, field, np.inf, np.inf, trust.cap, state, out, TOLERANCE, STEPS, scratch, work):
        return True
    starts = scratch.starts
    find_starts(surface.points, trust.spacing, trust.sure, state, scratch.distances, starts, scratch.start_squares)
    copy(surface.rows[starts[0]], out[0])
    met = step_back(surface, field, out, TOLERANCE, scratch)
    if not met:
        copy(surface.rows[starts[0]], out[0])
    point, best, far, doubt = work[2:3], work[3:4], trust.spacing, trust.doubt
    shortest = np.inf
    for s in range(starts.size):
        copy(surface.rows[starts[s]], point[0])
        if descend(surface, field, far, doubt, trust.cap, state, point, ROUGH, ROUGH_STEPS, scratch, work):
            distance = gap(state, point[0])
            if distance < shortest:
                shortest = distance
                copy(point[0], best[0])
    if shortest < np.inf:
        settled = descend(surface, field, far, doubt, trust.cap, state, best, TOLERANCE, STEPS, scratch, work)
        if settled and (not met or gap(state, best[0]) < gap(state, out[0])):
            copy(best[0], out[0])
            met = True
    return met


@njit
def gap(a: Array, b: Array) -> float:
    """Squared distance."""
    s = 0.0
    for c in range(a.size):
        s += (a[c] - b[c]) ** 2
    return s


@njit
def project_states(surface: Surface, field: Field, trust: Trust, states: Array) -> tuple:
    """`project_state` for a batch (B, D); returns points (B, D) and whether each met the surface (B,)."""
    B, D = states.shape
    scratch = make_scratch(surface, field, 1)
    work = np.empty((4, D))
    points, met = np.empty((B, D)), np.empty(B, np.bool_)
    for i in range(B):
        met[i] = project_state(surface, field, trust, states[i], scratch, work, points[i : i + 1])
    return points, met


@njit
def project_near(surface: Surface, field: Field, trust: Trust, states: Array, near: Array) -> tuple:
    """Closest points to states (B, D) found by descent from near (B, D) alone; points and whether met (B,)."""
    B, D = states.shape
    scratch = make_scratch(surface, field, 1)
    work = np.empty((4, D))
    points, met = near.copy(), np.empty(B, np.bool_)
    for i in range(B):
        here = points[i : i + 1]
        met[i] = descend(surface, field, np.inf, np.inf, trust.cap, states[i], here, TOLERANCE, STEPS, scratch, work)
    return points, met


@njit
def follow_leaf(field: Field, states: Array, near: Array, rate: float, steps: int) -> Array:
    """The printed update q' ← q' + α H'H''(q − q') for a batch (B, D), from near (B, D)."""
    B, D = states.shape
    d = field.weights.shape[0]
    bases, features = np.empty((1, d, D)), np.empty(field.centres.shape[1])
    along, work = np.empty(D), np.empty(d)
    points = near.copy()
    for i in range(B):
        for _ in range(steps):
            tangent_bases(field.centres, field.precision, field.weights, points[i : i + 1], features, bases)
            for c in range(D):
                along[c] = states[i, c] - points[i, c]
            keep_along(bases[0], along, work)
            if norm(along) < TOLERANCE:
                break
            for c in range(D):
                points[i, c] += rate * along[c]
    return points


@njit
def field_bases(field: Field, states: Array) -> Array:
    """Orthonormal rows of H at states (B, D): (B, d, D)."""
    bases = np.empty((len(states), field.weights.shape[0], states.shape[1]))
    features = np.empty(field.centres.shape[1])
    tangent_bases(field.centres, field.precision, field.weights, states, features, bases)
    return bases


@njit
def displacements(surface: Surface, field: Field, states: Array) -> tuple:
    """Displacements from the surface to states (B, D), distances to the nearest anchor, and doubts; both (B,)."""
    scratch = make_scratch(surface, field, len(states))
    evaluate(surface, field, states, scratch)
    return scratch.normals, np.sqrt(scratch.squares[:, 0]), scratch.doubts


@njit
def judge(surface: Surface, field: Field, trust: Trust, states: Array, enough: float) -> tuple:
    """Distances of states (B, D) from the modelled surface, and from the nearest anchor; both (B,).

    A state nearer than `enough` is not projected: there its displacement, which bounds the distance up to a
    square, tells all that was asked, provided that the anchors agree about it. What they disagree by counts as
    distance, once it is too much to be overlooked.
    """
    normals, nearest, doubts = displacements(surface, field, states)
    scratch = make_scratch(surface, field, 1)
    work, point = np.empty((4, states.shape[1])), np.empty((1, states.shape[1]))
    off = np.empty(len(states))
    for i in range(len(states)):
        off[i] = norm(normals[i])
        if doubts[i] > trust.ghost:
            off[i] = np.hypot(off[i], doubts[i])
        if off[i] > enough:
            project_state(surface, field, trust, states[i], scratch, work, point)
            off[i] = np.sqrt(gap(point[0], states[i]))
    return off, nearest


@njit
def nearest_distances(surface: Surface, field: Field, states: Array) -> Array:
    """Distances of states (B, D) from their nearest anchor; (B,)."""
    scratch = make_scratch(surface, field, len(states))
    find_nearest(surface, states, scratch)
    return np.sqrt(scratch.squares[:, 0])
