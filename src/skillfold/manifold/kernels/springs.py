"""Algorithm 2 of paper 000: path states as a chain of springs that obstacles push aside (section IV-B)."""

from typing import Any

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.manifold.kernels.detours import frame_path, free_rows
from skillfold.manifold.kernels.projection import gap
from skillfold.manifold.kernels.scratch import make_scratch
from skillfold.manifold.kernels.small import keep_along, norm, square
from skillfold.manifold.kernels.walking import Chart, to_slope, to_state
from skillfold.planning.barrier import Barrier, within_at
from skillfold.tables import Indices

Array = np.ndarray[Any, np.dtype[np.float64]]

RATE = 0.3  # γ, of a force
EVENING = 0.25  # γ of the curvature step; above 0.5 it would overshoot


@njit
def relax_springs(
    t: Indices,
    chart: Chart,
    barrier: Barrier,
    path: Array,
    margin: float,
    capacity: int,
    tolerance: float,
    limit: int,
) -> tuple:
    """Let springs and obstacles move a path (n, D) in place along the surface, its ends fixed.

    As printed but for three faults: curvature is evened out by C − C̄, since the printed C̄ − C sharpens it; states
    are brought back onto the surface after each step along the tangents; and as mean forces balance inside the reach
    of obstacles, where the printed rule is never met, it ends when nothing moves by more than the tolerance. Returns
    iterations and the last step.
    """
    n, D = path.shape
    scratch = make_scratch(t, n)
    kept = scratch.normals.shape[1]
    d, inner = scratch.bases.shape[1] + D - kept, np.empty((n, kept))
    normals, tangents, work = np.zeros((n, D)), np.zeros((n, d, D)), np.empty(d)
    distances, gradients = np.empty(capacity), np.zeros((capacity, D))
    moves, bends = np.zeros((n, D)), np.zeros((n, D))
    slope, state, mean = np.empty(D), np.empty(D), np.empty(D)
    free_rows(tangents, kept)
    rest = 0.0
    for i in range(n - 1):
        rest += np.sqrt(gap(path[i], path[i + 1])) / (n - 1)
    iteration, moved = 0, np.inf
    while iteration < limit and moved >= tolerance:
        frame_path(path, inner, normals, tangents, scratch)
        bend(path, bends, mean)
        moved = 0.0
        for i in range(1, n - 1):
            move = moves[i]
            to_state(chart, path[i], state)
            count = max(within_at(barrier.within)(state, margin, distances, gradients, barrier.arguments), 0)
            move[:] = 0.0
            for p in range(count):
                to_slope(chart, gradients[p], slope)
                # Clearance over its gradient is a way in the space of states, in the gradient's direction; at an
                # obstacle point itself there is no gradient and no way.
                push = RATE * (margin - distances[p]) / max(square(slope), 1e-300) / count
                for c in range(D):
                    move[c] += push * slope[c]
            if count:
                pull_of(path[i - 1], path[i], rest, move)
                pull_of(path[i + 1], path[i], rest, move)
            for c in range(D):
                move[c] += EVENING * (bends[i, c] - mean[c])
            keep_along(tangents[i], move, work)
            moved = max(moved, norm(move))
        for i in range(1, n - 1):
            for c in range(D):
                path[i, c] += moves[i, c] - normals[i, c]
        iteration += 1
    return iteration, moved


@inner
def pull_of(neighbour: Array, here: Array, rest: float, move: Array) -> None:
    """Add a neighbour's share of the mean force: away where it is nearer than at rest, else toward it."""
    length = max(np.sqrt(gap(neighbour, here)), 1e-300)
    for c in range(here.size):
        move[c] += 0.5 * RATE * (rest - length) / length * (here[c] - neighbour[c])


@inlined
def bend(path: Array, bends: Array, mean: Array) -> None:
    """Second differences (n, D) of a path, which are C s², and their mean (D,) over its inner states."""
    n, D = path.shape
    mean[:] = 0.0
    for i in range(1, n - 1):
        for c in range(D):
            bends[i, c] = path[i - 1, c] - 2.0 * path[i, c] + path[i + 1, c]
            mean[c] += bends[i, c] / (n - 2)
