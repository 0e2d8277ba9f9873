"""Geodesics: Algorithm 1 put right for a first path, then both conditions of section IV-A solved together."""

from typing import Any

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.manifold.kernels.acceleration import copy_rows, longest, mix, take
from skillfold.manifold.kernels.frames import follow_surface, make_frames
from skillfold.manifold.kernels.scratch import Scratch, evaluate, make_scratch
from skillfold.manifold.kernels.small import copy, keep_along, norm, solve_in_place
from skillfold.manifold.kernels.tabled import decode_path, encode, surface_at
from skillfold.tables import Indices

Array = np.ndarray[Any, np.dtype[np.float64]]

GROWN = 2000  # states that a first path may have
COARSE = 9  # states of the path that is relaxed first, where many are asked
ROUGH = 1e-4  # tolerance of that, in rms radii of the data: a curve through so few states is off by more
MEMORY = 5  # iterations that the acceleration looks back on
WORSE = 2.0  # times the last step: a larger one shows that what was learnt of the iteration no longer holds


@inlined
def grow_path(start: Array, goal: Array, step: float, grown: Array, scratch: Scratch) -> int:
    """Grow from both ends in turn along the projected direction until they meet; the number of states grown.

    Algorithm 1 with its faults mended: the grown points are kept, in `grown` (limit, D), start first; steps go
    toward the other end, along the tangents found last; each is followed by one straight back onto the surface.
    Returns 0 where the ends do not meet within the limit or stop getting closer.
    """
    limit, D = grown.shape
    normal, basis, within = scratch.normals[0], scratch.bases[0], scratch.along
    direction, tangents = np.empty(D), np.empty((2, *basis.shape))
    left, right = 0, limit - 1
    copy(start, grown[left])
    copy(goal, grown[right])
    while True:
        for c in range(D):
            direction[c] = grown[right, c] - grown[left, c]
        gap = norm(direction)
        if gap <= 1.5 * step:
            break
        if right - left < 2:
            return 0
        grown_already = left + limit - 1 - right
        forward = grown_already % 2 == 0
        here, there, side = (left, left + 1, 0) if forward else (right, right - 1, 1)
        if grown_already < 2:
            evaluate(grown[here : here + 1], scratch)
            copy_rows(basis, tangents[side])
        keep_along(tangents[side], direction, within)
        length = norm(direction)
        if length < 1e-6 * gap:
            return 0
        signed = step / length if forward else -step / length
        for c in range(D):
            grown[there, c] = grown[here, c] + signed * direction[c]
        evaluate(grown[there : there + 1], scratch)
        copy_rows(basis, tangents[side])
        for c in range(D):
            grown[there, c] -= normal[c]
        if forward:
            left = there
        else:
            right = there
    count = left + 1 + limit - right
    for i in range(right, limit):
        copy(grown[i], grown[left + 1 + i - right])
    return count


@njit
def resample(path: Array, out: Array) -> None:
    """The polyline `path` at equal arc lengths; first and last rows are copied as they are."""
    n, D = path.shape
    m = out.shape[0]
    lengths = np.zeros(n)
    for i in range(1, n):
        s = 0.0
        for c in range(D):
            s += (path[i, c] - path[i - 1, c]) ** 2
        lengths[i] = lengths[i - 1] + np.sqrt(s)
    j = 0
    for i in range(m):
        wanted = lengths[n - 1] * i / (m - 1)
        while j < n - 2 and lengths[j + 1] < wanted:
            j += 1
        span = lengths[j + 1] - lengths[j]
        t = (wanted - lengths[j]) / span if span > 0.0 else 0.0
        for c in range(D):
            out[i, c] = (1.0 - t) * path[j, c] + t * path[j + 1, c]
    copy(path[0], out[0])
    copy(path[n - 1], out[m - 1])


@inner
def newton_steps(
    path: Array, normals: Array, tangents: Array, stiffness: Array, force: Array, right: Array, steps: Array
) -> None:
    """Steps δ (n, D) that would bring a path (n, D) onto the surface and make it straight along it.

    With the displacement r from the surface and H's tangents T at every inner point, solves

        N'δ_i = −N'r_i,    T_i'(δ_{i−1} − 2δ_i + δ_{i+1}) = −T_i'(q_{i−1} − 2q_i + q_{i+1})

    for all points at once: on the surface, and no pull along it (err_M = 0 and ∇err_length = 0). With
    δ_i = T_i t_i − r_i this is block tridiagonal in the d-vectors t_i. A further force f − S t along the tangents,
    force (n, d) and stiffness (n, d, d), is added to that pull.
    """
    n, D = path.shape
    d = tangents.shape[1]
    block, link, pull = np.empty((d, d)), np.zeros((d, d)), np.empty(D)
    for i in range(1, n - 1):
        for c in range(D):
            bend = path[i - 1, c] - 2.0 * path[i, c] + path[i + 1, c]
            pull[c] = bend - normals[i - 1, c] + 2.0 * normals[i, c] - normals[i + 1, c]
        for a in range(d):
            s = 0.0
            for c in range(D):
                s -= tangents[i, a, c] * pull[c]
            right[i, a, d] = s - force[i, a]
            for b in range(d):
                block[a, b] = (-2.0 if a == b else 0.0) - stiffness[i, a, b]
        if i > 1:
            for a in range(d):
                for e in range(d):
                    s = link[e, a]  # of this point's tangents with those of the one before
                    for b in range(d):
                        block[a, b] -= s * right[i - 1, e, b]
                    right[i, a, d] -= s * right[i - 1, e, d]
        for a in range(d):
            for b in range(d):
                s = 0.0
                if i < n - 2:
                    for c in range(D):
                        s += tangents[i, a, c] * tangents[i + 1, b, c]
                right[i, a, b] = link[a, b] = s
        solve_in_place(block, right[i])
    for i in range(n - 2, 0, -1):
        if i < n - 2:
            for a in range(d):
                for b in range(d):
                    right[i, a, d] -= right[i, a, b] * right[i + 1, b, d]
        for c in range(D):
            steps[i, c] = -normals[i, c]
            for a in range(d):
                steps[i, c] += tangents[i, a, c] * right[i, a, d]


@inlined
def relax(
    path: Array,
    tolerance: float,
    cap: float,
    limit: int,
    share: float,
    own: bool,
    rate: float,
    scratch: Scratch,
    hold: Any,
    edge: Any,
) -> tuple:
    """Make `path` (n, D) a geodesic in place, its ends fixed; (iterations, step that would be next, share left).

    Iterates `newton_steps`, which leave out how the surface bends: each leaves about the same share of the error.
    So they are accelerated, and the shares seen last tell how large the next step may be; below `tolerance` it is
    not taken. Before any is seen, `share` is believed. Its tangents are the field's, or the surface's `own`; of each
    step a share `rate` is taken. The kernel `hold` adds force and stiffness to the equations, where an `edge` wants
    them.
    """
    n, D = path.shape
    d = scratch.bases.shape[1]
    right, steps, before = np.empty((n, d, d + 1)), np.zeros((n, D)), np.zeros((n, D))
    stiffness, force = np.zeros((n, d, d)), np.zeros((n, d))
    path_changes, step_changes = np.zeros((MEMORY, n, D)), np.zeros((MEMORY, n, D))
    normals, tangents = np.zeros((n, D)), np.zeros((n, d, D))
    surface = surface_at(scratch.model)
    frames = make_frames(surface, d, n - 2 if own else 0)
    next_size, size, earlier, iteration, known = np.inf, np.inf, 0.0, 0, 0
    while iteration < limit and next_size >= tolerance:
        evaluate(path[1 : n - 1], scratch)
        if own:
            follow_surface(surface, path[1 : n - 1], iteration == 0, scratch, frames)
        for i in range(1, n - 1):  # the ends stay where they are
            copy(scratch.normals[i - 1], normals[i])
            copy_rows(scratch.bases[i - 1], tangents[i])
        hold(edge, iteration, path, tangents, scratch, stiffness, force)
        slot = known % MEMORY
        copy_rows(steps, path_changes[slot])
        newton_steps(path, normals, tangents, stiffness, force, right, steps)
        last, size = size, longest(steps)
        if iteration > 0:
            earlier, share = share, min(size / last, 1.0)
        next_size = size * (share if iteration < 2 else max(share, earlier))
        known = known + 1 if iteration > 0 and size < WORSE * last else 0
        for i in range(n):
            for c in range(D):
                step_changes[slot, i, c] = steps[i, c] - before[i, c]
                before[i, c] = steps[i, c]
        if known > 0:
            m = min(known, MEMORY)
            mix(path_changes[:m], step_changes[:m], steps)
        take(path, steps, rate, cap)
        iteration += 1
    return iteration, next_size, share


@inlined
def leave_free(
    edge: None, iteration: int, path: Array, tangents: Array, scratch: Scratch, stiffness: Array, force: Array
) -> None:
    """Of a path that nothing holds: force and stiffness stay 0."""


@inlined
def refine(coarse: Array, path: Array) -> None:
    """A smooth curve through the states of `coarse` (m, D), read at the n states of `path`; cubic through four."""
    m, D = coarse.shape
    n = len(path)
    for i in range(n):
        at = i * (m - 1) / (n - 1)
        j = min(max(int(at) - 1, 0), m - 4)
        t = at - j
        a, b, c, d = t, t - 1.0, t - 2.0, t - 3.0
        w0, w1, w2, w3 = -b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0
        for k in range(D):
            path[i, k] = w0 * coarse[j, k] + w1 * coarse[j + 1, k] + w2 * coarse[j + 2, k] + w3 * coarse[j + 3, k]
    copy(coarse[0], path[0])
    copy(coarse[m - 1], path[n - 1])


@inlined
def solve_inner(
    first: Array,
    step: float,
    path: Array,
    tolerance: float,
    cap: float,
    limit: int,
    own: bool,
    rate: float,
    scratch: Scratch,
) -> tuple:
    """`solve_geodesic` in inner coordinates."""
    grow = len(first) == 2
    if grow:
        grown = np.empty((GROWN, first.shape[1]))
        first = grown[: grow_path(first[0], first[1], step, grown, scratch)]
    if len(first) == 0:
        return 0, np.inf
    now = np.empty((COARSE, first.shape[1])) if grow and len(path) >= 3 * COARSE else path
    resample(first, now)
    share = 1.0
    while True:
        enough = tolerance if len(now) == len(path) else max(tolerance, ROUGH)
        iterations, moved, share = relax(now, enough, cap, limit, share, own, rate, scratch, leave_free, None)
        if len(now) == len(path):
            return iterations, moved
        refine(now, path)
        now = path


@njit
def solve_geodesic(
    t: Indices,
    first: Array,
    step: float,
    path: Array,
    tolerance: float,
    cap: float,
    limit: int,
    own: bool,
    rate: float,
) -> tuple:
    """Relax a first path (m, D) of states into `path` (n, D); (iterations, last step).

    Of two states alone the path between them is grown; 0 iterations where they do not meet. Grown paths of many
    states are relaxed with few of them first, which takes away most of the error at little cost. `t` is the table
    of the model (see `tabled`), in whose inner coordinates steps and tolerances are.
    """
    begun = encode(t, first)
    inside = np.empty((len(path), begun.shape[1]))
    scratch = make_scratch(t, len(path))
    iterations, moved = solve_inner(begun, step, inside, tolerance, cap, limit, own, rate, scratch)
    if iterations > 0:
        decode_path(t, first[0], first[len(first) - 1], inside, path)
    return iterations, moved
