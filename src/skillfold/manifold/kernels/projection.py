"""Projection: anchored Newton from several starts."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.manifold.kernels.edges import draw_in, look_around
from skillfold.manifold.kernels.neighbours import smallest
from skillfold.manifold.kernels.newton import begin_at, carry, descend
from skillfold.manifold.kernels.scratch import STARTS, Scratch, evaluate, make_scratch
from skillfold.manifold.kernels.small import copy
from skillfold.manifold.kernels.surface import Flags, Indices, Trust
from skillfold.manifold.kernels.tabled import NEIGHBOURS, POINTS, RADII, ROWS, encode, moved
from skillfold.tables import index_matrix, matrix, vector

Array = np.ndarray[Any, np.dtype[np.float64]]

CLOSE = 0.25  # of a neighbourhood's radius: nearer states are projected from their own foot alone
STEPS = 40.0  # (a float: for each whole number Numba would compile anew) of the anchored Newton iteration
TOLERANCE = 1e-10  # of an iteration, in units of the data's rms radius
AROUND = 2.0  # spacings beyond the nearest anchor in which sure ones are looked for
GHOST = 10.0  # times the usual doubt: where anchors disagree more, a small displacement means nothing
BLOCK = 64  # states that are projected at once: so few that what they look up stays in the processor's cache
ROUGH, ROUGH_STEPS = 1e-4, 16.0  # the same, while several starts are compared


@inlined
def find_starts(
    points: Array, spacing: float, sure: Flags, state: Array, distances: Array, starts: Indices, squares: Array
) -> None:
    """The nearest sure anchors into `starts`; simply the nearest ones where sure ones are few around."""
    look_around(points, state, distances, starts, squares)
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
def project_far(trust: Trust, states: Array, out: Array, scratch: Scratch) -> Flags:
    """The closest trusted points to states (n, D) into `out`, and whether the surface was met (n,).

    From the nearest sure anchors of each, within what is trusted, no farther out than the demonstrations and no
    farther than to the foot of the nearest.
    """
    n, D = states.shape
    S, t = scratch.starts.size, scratch.model
    anchor_points, rows, neighbours = matrix(t, POINTS), matrix(t, ROWS), index_matrix(t, NEIGHBOURS)
    targets, points, anchors = np.empty((n * S, D)), np.empty((n * S, D)), np.empty(n * S, np.int64)
    for i in range(n):
        find_starts(
            anchor_points,
            trust.spacing,
            trust.sure,
            states[i],
            scratch.distances,
            scratch.starts,
            scratch.start_squares,
        )
        for s in range(S):
            anchors[i * S + s] = scratch.starts[s]
    for j in range(n * S):
        begin_at(neighbours, scratch, j, anchors[j])
        for c in range(D):
            targets[j, c] = states[j // S, c]
            points[j, c] = rows[anchors[j], c]
    far, doubt, cap = trust.spacing, trust.doubt, trust.cap
    feet, best = points[::S].copy(), points[::S].copy()
    rough = descend(far, doubt, cap, targets, points, ROUGH, ROUGH_STEPS, scratch)
    for i in range(n):
        chosen, shortest = i * S, np.inf
        for j in range(i * S, (i + 1) * S):
            if rough[j] and gap(states[i], points[j]) < shortest:
                chosen, shortest = j, gap(states[i], points[j])
                copy(points[j], best[i])
        begin_at(neighbours, scratch, i, anchors[chosen])
    settled = descend(far, doubt, cap, states, best, TOLERANCE, STEPS, scratch)
    draw_in(trust.spacing, best, TOLERANCE, scratch, settled)
    for i in range(n):
        begin_at(neighbours, scratch, i, anchors[i * S])
        copy(feet[i], out[i])
    met = descend(far, doubt, cap, states, out, TOLERANCE, 0.0, scratch)
    for i in range(n):
        if settled[i] and (not met[i] or gap(states[i], best[i]) < gap(states[i], out[i])):
            copy(best[i], out[i])
            met[i] = True
        elif not met[i]:
            copy(feet[i], out[i])
    return met


@inlined
def project_block(trust: Trust, states: Array, out: Array, met: Flags, scratch: Scratch) -> None:
    """The closest trusted points of the surface to states (n, D) into `out`, and whether one was met, into `met`.

    A state near the surface is projected from its foot, outside the demonstrations too. One far off could meet the
    surface anywhere, also where nothing was demonstrated: see `project_far`. So could one about which the anchors
    disagree, unless they speak of one sheet and it is next to that.
    """
    evaluate(states, scratch)
    n, D = states.shape
    radii = vector(scratch.model, RADII)
    near, within = np.zeros(n, np.bool_), np.full(n, np.inf)
    for i in range(n):
        off = 0.0
        for c in range(D):
            off += scratch.normals[i, c] ** 2
        off = math.sqrt(off)
        met[i] = off < TOLERANCE
        doubt = scratch.doubts[i]
        certain = doubt < GHOST * trust.doubt
        if not certain:
            within[i] = trust.ghost  # a foot farther off is not next to it
            certain = max(off, doubt) < trust.ghost
        near[i] = certain and off < CLOSE * radii[scratch.nearest[i, 0]] and not met[i]
        back = 0.0 if met[i] else min(1.0, trust.cap / off)
        for c in range(D):
            out[i, c] = states[i, c] - back * scratch.normals[i, c]
    chosen = np.flatnonzero(near)
    for k in range(len(chosen)):
        carry(scratch, chosen[k], k)
    targets, points = states[chosen], out[chosen]
    found = descend(np.inf, np.inf, trust.cap, targets, points, TOLERANCE, STEPS, scratch)
    for k in range(len(chosen)):
        i, moved = chosen[k], 0.0
        for c in range(D):
            out[i, c] = points[k, c]
            moved += (points[k, c] - targets[k, c]) ** 2
        met[i] = found[k] and moved < within[i] ** 2
    chosen = np.flatnonzero(~met)
    if len(chosen):
        targets = states[chosen]
        points = np.empty(targets.shape)
        found = project_far(trust, targets, points, scratch)
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


@inlined
def project_states(t: Indices, trust: Trust, states: Array) -> tuple:
    """Closest points to states (B, D), in blocks; returns points (B, D) and whether each met the surface (B,)."""
    B = len(states)
    points, met = np.empty(states.shape), np.empty(B, np.bool_)
    scratch = make_scratch(t, STARTS * min(B, BLOCK))
    for first in range(0, B, BLOCK):
        end = min(first + BLOCK, B)
        project_block(trust, states[first:end], points[first:end], met[first:end], scratch)
    return points, met


@inlined
def project_near(t: Indices, trust: Trust, states: Array, near: Array) -> tuple:
    """Closest points to states (B, D) found by descent from near (B, D) alone; points and whether met (B,)."""
    points = near.copy()
    scratch = make_scratch(t, len(states))
    met = descend(np.inf, np.inf, trust.cap, states, points, TOLERANCE, STEPS, scratch)
    return points, met


@njit
def bring_onto(t: Indices, trust: Trust, states: Array) -> tuple:
    """`project_states` for the model of a table and its own states (B, D); what is free stays."""
    inner = encode(t, states)
    points, met = project_states(t, trust, inner)
    return moved(t, states, inner, points), met


@njit
def bring_onto_near(t: Indices, trust: Trust, states: Array, near: Array) -> tuple:
    """`project_near` in the same way."""
    inner = encode(t, states)
    points, met = project_near(t, trust, inner, encode(t, near))
    return moved(t, states, inner, points), met
