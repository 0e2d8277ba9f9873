"""Paths that bend around obstacles: hinge penalties by Gauss-Newton, and the paper's springs (section IV-B).

States are whole coordinates, as in `walking`.
"""

from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.manifold.kernels.acceleration import longest
from skillfold.manifold.kernels.edges import beyond_edge, mean_step
from skillfold.manifold.kernels.geodesic import newton_steps
from skillfold.manifold.kernels.holding import make_edge, pull_back
from skillfold.manifold.kernels.pushes import SIGHT, push_off_limits, push_off_obstacles
from skillfold.manifold.kernels.scratch import Scratch, evaluate, make_scratch
from skillfold.manifold.kernels.small import norm
from skillfold.manifold.kernels.walking import (
    ON_SURFACE,
    SETTLE_STEPS,
    Barrier,
    Chart,
    Support,
    edge_is_clear,
    to_state,
)
from skillfold.tables import Indices

Array = np.ndarray[Any, np.dtype[np.float64]]

STRIDE = 0.5  # of the clearance that a state may go in one step: none tunnels through what is thin
FREED = 0.3  # of the margin that one may go where it has no clearance


@inlined
def frame_path(path: Array, inner: Array, normals: Array, tangents: Array, scratch: Scratch) -> None:
    """Displacements (n, D) from the surface and tangents (n, d, D) of a path of whole coordinates (n, D).

    `inner` is (n, D - f) scratch. Rows of the free directions have been put into `tangents` once and stay.
    """
    n, k = inner.shape
    for i in range(n):
        for c in range(k):
            inner[i, c] = path[i, c]
    evaluate(inner, scratch)
    for i in range(n):
        for c in range(k):
            normals[i, c] = scratch.normals[i, c]
        for a in range(scratch.bases.shape[1]):
            for c in range(k):
                tangents[i, a, c] = scratch.bases[i, a, c]


@inner
def free_rows(tangents: Array, kept: int) -> None:
    """Rows of the free directions, the last of each basis (d, D); `kept` coordinates are not free."""
    n, d, D = tangents.shape
    for i in range(n):
        for a in range(D - kept):
            tangents[i, d - (D - kept) + a, kept + a] = 1.0


class Bending(NamedTuple):
    """Memory of an iteration that bends a path of n states in d dimensions of D.

    Attributes:
        normals, tangents: (n, D) displacements from the surface, (n, d, D) bases.
        stiffness, force: (n, d, d), (n, d) penalties.
        right, steps: (n, d, d + 1), (n, D).
        clear: (n,) clearance, as far as it was looked for.
        slack: (n,) how far each state may go until obstacles can matter to it again.
        distances, gradients: (capacity,), (capacity, D) of obstacles at one state.
        slope, state: (D,).
    """

    normals: Array
    tangents: Array
    stiffness: Array
    force: Array
    right: Array
    steps: Array
    clear: Array
    slack: Array
    distances: Array
    gradients: Array
    slope: Array
    state: Array


@inner
def make_bending(n: int, d: int, D: int, capacity: int) -> Bending:
    """Room for it; everything is zero."""
    return Bending(
        np.zeros((n, D)),
        np.zeros((n, d, D)),
        np.zeros((n, d, d)),
        np.zeros((n, d)),
        np.zeros((n, d, d + 1)),
        np.zeros((n, D)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(capacity),
        np.zeros((capacity, D)),
        np.zeros(D),
        np.zeros(D),
    )


@inlined
def bend_once(
    chart: Chart, barrier: Barrier, path: Array, chain: Array, margin: float, steepest: float, cap: float, b: Bending
) -> tuple:
    """One Gauss-Newton step on ½ Σ ‖e_{i+1} − e_i‖² and the penalties, in place; its length, the steepest gradient.

    The springs are between the states of `chain` e (n, D), which moves along with the path: the path itself, or how
    far it is from one that it should keep the shape of. What is in `b.stiffness` and `b.force` is used up.
    """
    n, D = path.shape
    for i in range(1, n - 1):
        to_state(chart, path[i], b.state)
        push_off_limits(chart, b.state, b.normals[i], b.tangents[i], b.slope, b.stiffness[i], b.force[i])
        b.slack[i] -= norm(b.steps[i])
        if b.slack[i] > 0.0:
            continue
        b.clear[i], steepest = push_off_obstacles(
            chart,
            barrier,
            b.state,
            b.normals[i],
            b.tangents[i],
            margin,
            steepest,
            b.distances,
            b.gradients,
            b.slope,
            b.stiffness[i],
            b.force[i],
        )
        # Before anything came into sight, nothing is known of how fast clearance changes.
        if b.clear[i] >= SIGHT * margin and steepest > 0.0:
            b.slack[i] = (b.clear[i] - margin) / steepest
    newton_steps(chain, b.normals, b.tangents, b.stiffness, b.force, b.right, b.steps)
    for i in range(1, n - 1):
        stride = cap
        if b.clear[i] < SIGHT * margin:
            stride = min(cap, max(STRIDE * b.clear[i], FREED * margin) / max(steepest, 1e-300))
        shrink = min(1.0, stride / max(norm(b.steps[i]), 1e-300))
        for c in range(D):
            b.steps[i, c] *= shrink
            path[i, c] += b.steps[i, c]
    b.stiffness[:] = 0.0
    b.force[:] = 0.0
    return longest(b.steps), steepest


@njit
def bend_clear(
    t: Indices,
    chart: Chart,
    barrier: Barrier,
    path: Array,
    margin: float,
    capacity: int,
    cap: float,
    tolerance: float,
    limit: int,
    spacing: float,
) -> tuple:
    """Make a path (n, D) short and keep it a margin off obstacles, along the surface, in place, its ends fixed.

    With a `spacing`, the usual one of the demonstrations, it is held within their edge besides; 0 lets it go where it
    likes. Returns iterations and the last step; no iteration where it would be held, but does not leave the edge.
    """
    n, D = path.shape
    scratch = make_scratch(t, n)
    kept = scratch.normals.shape[1]
    inner = np.empty((n, kept))
    b = make_bending(n, scratch.bases.shape[1] + D - kept, D, capacity)
    free_rows(b.tangents, kept)
    iteration, moved, steepest, allowed = 0, np.inf, 0.0, 0.0
    if spacing > 0.0:
        for i in range(n):
            for c in range(kept):
                inner[i, c] = path[i, c]
        evaluate(inner[1 : n - 1], scratch)
        allowed = beyond_edge(inner, spacing, scratch)
        if allowed == 0.0:
            return 0, 0.0
    edge = make_edge(allowed, n, mean_step(path), max(spacing, 1e-300), scratch, b.tangents.shape[1])
    while iteration < limit and moved >= tolerance:
        frame_path(path, inner, b.normals, b.tangents, scratch)
        if spacing > 0.0:
            pull_back(edge, iteration, inner, b.tangents, scratch, b.stiffness, b.force)
        b.normals[0] = 0.0  # the ends stay where they are
        b.normals[n - 1] = 0.0
        moved, steepest = bend_once(chart, barrier, path, path, margin, steepest, cap, b)
        iteration += 1
    return iteration, moved


@njit
def bend_aside(
    chart: Chart,
    barrier: Barrier,
    path: Array,
    margin: float,
    capacity: int,
    reach: float,
    cap: float,
    tolerance: float,
    limit: int,
) -> tuple:
    """Push a path (n, D) a margin off obstacles, in place, its ends fixed; elsewhere it keeps its way and shape.

    What an obstacle pushes aside is passed on over `reach` states to each side. Returns iterations and the last step.
    """
    n, D = path.shape
    before, offsets = path.copy(), np.zeros((n, D))
    b = make_bending(n, D, D, capacity)
    for i in range(n):
        for c in range(D):
            b.tangents[i, c, c] = 1.0
    iteration, moved, steepest = 0, np.inf, 0.0
    while iteration < limit and moved >= tolerance:
        for i in range(n):
            for c in range(D):
                offsets[i, c] = path[i, c] - before[i, c]
                b.stiffness[i, c, c] = 1.0 / reach**2
                b.force[i, c] = -offsets[i, c] / reach**2
        moved, steepest = bend_once(chart, barrier, path, offsets, margin, steepest, cap, b)
        iteration += 1
    return iteration, moved


@njit
def settle_path(t: Indices, support: Support, path: Array) -> bool:
    """Bring the inner states of a path (n, D) straight onto the surface; whether all got there and are believed."""
    n, scratch = len(path), make_scratch(t, len(path))
    kept = scratch.normals.shape[1]
    inner = np.empty((n, kept))
    for i in range(n):
        for c in range(kept):
            inner[i, c] = path[i, c]
    off = 1.0
    for _ in range(SETTLE_STEPS):
        evaluate(inner, scratch)
        off = 0.0
        for i in range(1, n - 1):
            off = max(off, norm(scratch.normals[i]))
            for c in range(kept):
                inner[i, c] -= scratch.normals[i, c]
        if off < ON_SURFACE:
            break
    believed = off < ON_SURFACE
    for i in range(1, n - 1):
        believed = believed and scratch.squares[i, 0] < support.farthest and scratch.doubts[i] < support.doubt
        for c in range(kept):
            path[i, c] = inner[i, c]
    return believed


@njit
def first_blocked(chart: Chart, barrier: Barrier, path: Array, margin: float) -> int:
    """Where the first edge of a path (n, D) starts that does not keep the margin; -1 where all do."""
    work = np.empty((2, path.shape[1]))
    for i in range(len(path) - 1):
        if not edge_is_clear(chart, barrier, path[i], path[i + 1], margin, work):
            return i
    return -1
