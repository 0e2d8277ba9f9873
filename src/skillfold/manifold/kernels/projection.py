"""Projection: anchored Newton from several starts."""

from typing import Any

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.manifold.kernels.neighbours import smallest
from skillfold.manifold.kernels.small import copy, keep_along, norm
from skillfold.manifold.kernels.surface import (
    STARTS,
    Field,
    Flags,
    Indices,
    Scratch,
    Surface,
    Trust,
    evaluate,
    make_scratch,
)

Array = np.ndarray[Any, np.dtype[np.float64]]

CLOSE = 0.25  # of a neighbourhood's radius: nearer states are projected from themselves alone
STEPS = 40.0  # (a float: for each whole number Numba would compile anew) of the anchored Newton iteration
TOLERANCE = 1e-10  # of an iteration, in units of the data's rms radius
AROUND = 2.0  # spacings beyond the nearest anchor in which sure ones are looked for
SMALLEST_RATE = 1e-3  # of the step along the surface: below it the edge of the support is met
GHOST = 10.0  # times the usual doubt: where anchors disagree more, a small displacement means nothing
BLOCK = 128  # states that are projected at once
BACK_STEPS = 20  # straight onto the surface, at the end
ROUGH, ROUGH_STEPS = 1e-4, 16.0  # the same, while several starts are compared


@inner
def descend(
    surface: Surface,
    field: Field,
    farthest: float,
    most_doubt: float,
    cap: float,
    states: Array,
    points: Array,
    tolerance: float,
    steps: float,
    scratch: Scratch,
) -> Flags:
    """Anchored Newton from points (n, D; changed in place) to the surface's closest points to states (n, D).

    Each step goes along the surface toward the state and straight back onto it; both parts are capped. The step
    along shrinks where it overshoots, and where it would go `farthest` from the anchors or where these disagree by
    `most_doubt`: then it is taken back, and the answer is the edge of that. Ends with steps straight back. All go
    on at once; those that have arrived drop out. Returns whether each met the surface (n,).
    """
    n, D = states.shape
    met, retreated = np.zeros(n, np.bool_), np.ones(n, np.bool_)
    rate, before = np.ones(n), np.full(n, np.inf)
    active, left = np.arange(n), n
    previous, along, within = points.copy(), np.empty(D), scratch.along
    for _ in range(int(steps)):
        here = points[active[:left]]
        evaluate(surface, field, here, scratch)
        going = 0
        for j in range(left):
            i = active[j]
            outside = scratch.squares[j, 0] > farthest**2 or scratch.doubts[j] > most_doubt
            if outside and not retreated[i]:
                retreated[i] = True
                rate[i] *= 0.5
                copy(previous[i], points[i])
            else:
                normal = scratch.normals[j]
                for c in range(D):
                    along[c] = states[i, c] - points[i, c]
                keep_along(scratch.bases[j], along, within)
                off, pull = norm(normal), norm(along)
                met[i] = off < tolerance and rate[i] * pull < tolerance
                if met[i] or rate[i] < SMALLEST_RATE:
                    continue
                # Of a state that starts from itself, all of the first error is across and none along.
                if off + pull > 0.7 * before[i]:
                    rate[i] = max(0.6 * rate[i], 0.05)
                elif off + pull < 0.5 * before[i]:
                    rate[i] = min(1.25 * rate[i], 1.0)
                before[i] = off + pull
                retreated[i] = False
                back = min(1.0, cap / max(off, 1e-300))
                forth = min(rate[i], cap / max(pull, 1e-300))
                for c in range(D):
                    previous[i, c] = points[i, c]
                    points[i, c] += forth * along[c] - back * normal[c]
            active[going] = i
            going += 1
        left = going
        if left == 0:
            break
    step_back(surface, field, points, tolerance, scratch, met)
    return met


@inlined
def step_back(surface: Surface, field: Field, points: Array, tolerance: float, scratch: Scratch, met: Flags) -> None:
    """Straight from points (n, D; changed in place) to their feet, those left out that have `met` the surface."""
    active = np.flatnonzero(~met)
    left = len(active)
    for _ in range(BACK_STEPS):
        if left == 0:
            break
        here = points[active[:left]]
        evaluate(surface, field, here, scratch)
        going = 0
        for j in range(left):
            i = active[j]
            normal = scratch.normals[j]
            if norm(normal) < tolerance:
                met[i] = True
                continue
            for c in range(normal.size):
                points[i, c] -= normal[c]
            active[going] = i
            going += 1
        left = going


@inlined
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


@inlined
def project_far(surface: Surface, field: Field, trust: Trust, states: Array, out: Array, scratch: Scratch) -> Flags:
    """The closest trusted points to states (n, D) into `out`, and whether the surface was met (n,).

    From the nearest sure anchors of each, within what is trusted, and no farther than to the foot of the nearest.
    """
    n, D = states.shape
    S = scratch.starts.size
    targets, points, anchors = np.empty((n * S, D)), np.empty((n * S, D)), np.empty((n, D))
    for i in range(n):
        find_starts(
            surface.points,
            trust.spacing,
            trust.sure,
            states[i],
            scratch.distances,
            scratch.starts,
            scratch.start_squares,
        )
        for s in range(S):
            copy(states[i], targets[i * S + s])
            copy(surface.rows[scratch.starts[s]], points[i * S + s])
        copy(points[i * S], anchors[i])
        copy(points[i * S], out[i])
    far, doubt, cap = trust.spacing, trust.doubt, trust.cap
    met = descend(surface, field, far, doubt, cap, states, out, TOLERANCE, 0.0, scratch)
    rough = descend(surface, field, far, doubt, cap, targets, points, ROUGH, ROUGH_STEPS, scratch)
    best = anchors.copy()
    for i in range(n):
        shortest = np.inf
        for s in range(i * S, (i + 1) * S):
            if rough[s] and gap(states[i], points[s]) < shortest:
                shortest = gap(states[i], points[s])
                copy(points[s], best[i])
    settled = descend(surface, field, far, doubt, cap, states, best, TOLERANCE, STEPS, scratch)
    for i in range(n):
        if settled[i] and (not met[i] or gap(states[i], best[i]) < gap(states[i], out[i])):
            copy(best[i], out[i])
            met[i] = True
        elif not met[i]:
            copy(anchors[i], out[i])
    return met


@inlined
def project_block(
    surface: Surface, field: Field, trust: Trust, states: Array, out: Array, met: Flags, scratch: Scratch
) -> None:
    """The closest trusted points of the surface to states (n, D) into `out`, and whether one was met, into `met`.

    A state near the surface is projected from itself, outside the demonstrations too. One far off could meet the
    surface anywhere, also where nothing was demonstrated: see `project_far`. So could one about which the anchors
    disagree, unless they speak of one sheet and it is next to that.
    """
    evaluate(surface, field, states, scratch)
    near, within = np.zeros(len(states), np.bool_), np.full(len(states), np.inf)
    for i in range(len(states)):
        copy(states[i], out[i])
        off = norm(scratch.normals[i])
        met[i] = off < TOLERANCE
        doubt = scratch.doubts[i]
        certain = doubt < GHOST * trust.doubt
        if not certain:
            within[i] = trust.ghost  # a foot farther off is not next to it
            certain = max(off, doubt) < trust.ghost
        near[i] = certain and off < CLOSE * surface.radii[scratch.nearest[i, 0]] and not met[i]
    chosen = np.flatnonzero(near)
    targets = states[chosen]
    points = targets.copy()
    found = descend(surface, field, np.inf, np.inf, trust.cap, targets, points, TOLERANCE, STEPS, scratch)
    for k in range(len(chosen)):
        if found[k] and gap(targets[k], points[k]) < within[chosen[k]] ** 2:
            copy(points[k], out[chosen[k]])
            met[chosen[k]] = True
    chosen = np.flatnonzero(~met)
    if len(chosen):
        targets = states[chosen]
        points = np.empty(targets.shape)
        found = project_far(surface, field, trust, targets, points, scratch)
        for k in range(len(chosen)):
            copy(points[k], out[chosen[k]])
            met[chosen[k]] = found[k]


@inner
def gap(a: Array, b: Array) -> float:
    """Squared distance."""
    s = 0.0
    for c in range(a.size):
        s += (a[c] - b[c]) ** 2
    return s


@njit
def project_states(surface: Surface, field: Field, trust: Trust, states: Array) -> tuple:
    """Closest points to states (B, D), in blocks; returns points (B, D) and whether each met the surface (B,)."""
    B = len(states)
    points, met = np.empty(states.shape), np.empty(B, np.bool_)
    scratch = make_scratch(surface, field, STARTS * min(B, BLOCK))
    for first in range(0, B, BLOCK):
        end = min(first + BLOCK, B)
        project_block(surface, field, trust, states[first:end], points[first:end], met[first:end], scratch)
    return points, met


@njit
def project_near(surface: Surface, field: Field, trust: Trust, states: Array, near: Array) -> tuple:
    """Closest points to states (B, D) found by descent from near (B, D) alone; points and whether met (B,)."""
    points = near.copy()
    scratch = make_scratch(surface, field, len(states))
    met = descend(surface, field, np.inf, np.inf, trust.cap, states, points, TOLERANCE, STEPS, scratch)
    return points, met
