"""Projection: anchored Newton from several starts."""

from typing import Any

import numpy as np

from skillfold.jit import njit
from skillfold.manifold.kernels.small import keep_along, norm
from skillfold.manifold.kernels.surface import (
    Field,
    Scratch,
    Surface,
    Trust,
    displacement,
    find_nearest,
    make_scratch,
    smallest,
    tangent_basis,
)

Array = np.ndarray[Any, np.dtype[np.float64]]

CLOSE = 0.25  # of a neighbourhood's radius: nearer states are projected from themselves alone
STEPS = 30  # of the anchored Newton iteration
TOLERANCE = 1e-10  # of an iteration, in units of the data's rms radius
GHOST = 10.0  # times the usual doubt: where anchors disagree more, a small displacement means nothing
AROUND = 2.0  # spacings beyond the nearest anchor in which sure ones are looked for
SMALLEST_RATE = 1e-3  # of the step along the surface: below it the edge of the support is met
BACK_STEPS = 20  # straight onto the surface, at the end
ROUGH, ROUGH_STEPS = 1e-4, 12  # the same, while several starts are compared


@njit
def trusted(square: float, trust: Trust, scratch: Scratch) -> bool:
    """Whether the last evaluated point lies near an anchor and its anchors agree about the surface."""
    return square <= trust.spacing**2 and scratch.doubt[0] <= trust.doubt


@njit
def descend(
    surface: Surface,
    field: Field,
    trust: Trust,
    bounded: bool,
    state: Array,
    point: Array,
    tolerance: float,
    steps: int,
    scratch: Scratch,
    work: Array,
) -> bool:
    """Anchored Newton from `point` (changed in place) to the surface's closest point to `state`.

    Each step goes along the surface toward `state` and straight back onto it; both parts are capped. The step
    along shrinks where it overshoots; where `bounded`, also where it would leave what is trusted: then the answer
    is the edge of that. Ends with steps straight back. Returns whether the surface was met.
    """
    normal, along, previous = work[0], work[1], work[2]
    rate, before, off = 1.0, np.inf, np.inf
    for step in range(steps):
        square = displacement(surface, field, point, scratch, normal)
        if bounded and step > 0 and not trusted(square, trust, scratch):
            rate *= 0.5
            point[:] = previous
            displacement(surface, field, point, scratch, normal)
        for c in range(point.size):
            along[c] = state[c] - point[c]
        keep_along(scratch.basis, along, scratch.along)
        off, pull = norm(normal), norm(along)
        if off < tolerance and rate * pull < tolerance:
            return True
        if rate < SMALLEST_RATE:
            break
        if pull > 0.7 * before:
            rate = max(0.6 * rate, 0.05)
        before = pull
        back = min(1.0, trust.cap / max(off, 1e-300))
        forth = min(rate, trust.cap / max(pull, 1e-300))
        for c in range(point.size):
            previous[c] = point[c]
            point[c] += forth * along[c] - back * normal[c]
    return step_back(surface, field, point, tolerance, scratch, normal)


@njit
def step_back(
    surface: Surface, field: Field, point: Array, tolerance: float, scratch: Scratch, normal: Array
) -> bool:
    """Straight onto the surface from `point` (changed in place): its foot. Returns whether the surface was met."""
    for _ in range(BACK_STEPS):
        displacement(surface, field, point, scratch, normal)
        if norm(normal) < tolerance:
            return True
        for c in range(point.size):
            point[c] -= normal[c]
    return False


@njit
def find_starts(surface: Surface, trust: Trust, state: Array, scratch: Scratch) -> None:
    """The nearest sure anchors into scratch.starts; simply the nearest ones where sure ones are few around."""
    find_nearest(surface.points, state, scratch)
    enough = (np.sqrt(scratch.squares[0]) + AROUND * trust.spacing) ** 2
    count = min(scratch.starts.size, scratch.nearest.size)
    scratch.starts[:count] = scratch.nearest[:count]
    sure = 0
    for i in range(trust.sure.size):
        if trust.sure[i] and scratch.distances[i] <= enough:
            sure += 1
        else:
            scratch.distances[i] = np.inf
    if sure >= count:
        smallest(scratch.distances, scratch.starts, scratch.start_squares)


@njit
def project_state(
    surface: Surface, field: Field, trust: Trust, state: Array, scratch: Scratch, work: Array, out: Array
) -> bool:
    """The closest trusted point of the surface into `out`; whether one was met.

    A state near the surface is projected from itself, outside the demonstrations too. One far off could meet the
    surface anywhere, also where nothing was demonstrated: it is projected from its nearest sure anchors, within
    what is trusted, and no farther than to the foot of the nearest of them.
    """
    point, best = work[3], work[4]
    displacement(surface, field, state, scratch, work[0])
    off = norm(work[0])
    out[:] = state
    if off < TOLERANCE:
        return True
    near = off < CLOSE * surface.radii[scratch.nearest[0]] and scratch.doubt[0] < GHOST * trust.doubt
    if near and descend(surface, field, trust, False, state, out, TOLERANCE, STEPS, scratch, work):
        return True
    find_starts(surface, trust, state, scratch)
    anchor_into(surface, scratch.starts[0], out)
    met = step_back(surface, field, out, TOLERANCE, scratch, work[0])
    if not met:
        anchor_into(surface, scratch.starts[0], out)
    shortest = np.inf
    for s in range(scratch.starts.size):
        anchor_into(surface, scratch.starts[s], point)
        if descend(surface, field, trust, True, state, point, ROUGH, ROUGH_STEPS, scratch, work):
            distance = gap(state, point)
            if distance < shortest:
                shortest = distance
                best[:] = point
    if shortest < np.inf:
        settled = descend(surface, field, trust, True, state, best, TOLERANCE, STEPS, scratch, work)
        if settled and (not met or gap(state, best) < gap(state, out)):
            out[:] = best
            met = True
    return met


@njit
def anchor_into(surface: Surface, i: int, out: Array) -> None:
    """Copy anchor i."""
    for c in range(out.size):
        out[c] = surface.points[c, i]


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
    scratch = make_scratch(surface, field)
    work = np.empty((5, D))
    points, met = np.empty((B, D)), np.empty(B, np.bool_)
    for i in range(B):
        met[i] = project_state(surface, field, trust, states[i], scratch, work, points[i])
    return points, met


@njit
def project_near(surface: Surface, field: Field, trust: Trust, states: Array, near: Array) -> tuple:
    """Closest points to states (B, D) found by descent from near (B, D) alone; points and whether met (B,)."""
    B, D = states.shape
    scratch = make_scratch(surface, field)
    work = np.empty((5, D))
    points, met = near.copy(), np.empty(B, np.bool_)
    for i in range(B):
        met[i] = descend(surface, field, trust, False, states[i], points[i], TOLERANCE, STEPS, scratch, work)
    return points, met


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
def judge(surface: Surface, field: Field, trust: Trust, states: Array, enough: float) -> tuple:
    """Distances of states (B, D) from the modelled surface, and from the nearest anchor; both (B,).

    A state nearer than `enough` is not projected: there its displacement, which bounds the distance up to a
    square, tells all that was asked, provided that the anchors agree about it.
    """
    scratch = make_scratch(surface, field)
    work, point = np.empty((5, states.shape[1])), np.empty(states.shape[1])
    off, nearest = np.empty(len(states)), np.empty(len(states))
    for i in range(len(states)):
        nearest[i] = np.sqrt(displacement(surface, field, states[i], scratch, work[0]))
        off[i] = norm(work[0])
        if off[i] > enough or scratch.doubt[0] > GHOST * trust.doubt:
            project_state(surface, field, trust, states[i], scratch, work, point)
            for c in range(point.size):
                point[c] -= states[i, c]
            off[i] = norm(point)
    return off, nearest


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


@njit
def doubts(surface: Surface, field: Field, states: Array) -> Array:
    """How far the anchors blended at states (B, D) disagree about the surface; (B,)."""
    B, D = states.shape
    scratch = make_scratch(surface, field)
    normal, result = np.empty(D), np.empty(B)
    for i in range(B):
        displacement(surface, field, states[i], scratch, normal)
        result[i] = scratch.doubt[0]
    return result
