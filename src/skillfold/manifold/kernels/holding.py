"""Geodesics held within the edge of the demonstrations (see `edges`): where they would leave it, they go along it.

A hull is convex, so the distance from it is smooth enough for Newton's steps, which know the face that a state is
beyond. Which anchors span it is looked up during the first steps alone: hulls of other ones would stir up a path that
is nearly at rest.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import inner, njit
from skillfold.manifold.kernels.edges import (
    beyond_edge,
    look_around,
    make_look,
    mean_step,
    nearest_in_hull,
    offset_by,
)
from skillfold.manifold.kernels.geodesic import relax
from skillfold.manifold.kernels.scratch import Scratch, evaluate, make_scratch
from skillfold.manifold.kernels.small import clear, norm, square
from skillfold.manifold.kernels.tabled import POINTS, ROWS, decode_path, encode
from skillfold.tables import Indices, matrix

Array = np.ndarray[Any, np.dtype[np.float64]]

YIELDING = 0.1  # of the spacing: over so much of a path what holds it is evened out
LOOKS, STEPS = 3, 4  # at what is around the path; steps from one to the next
FLAT = 1e-12  # of a squared length: with less of it beside others a direction adds nothing to a face


class Edge(NamedTuple):
    """What holds a path of n states.

    Attributes:
        around: (n, k) anchors whose hull each state should not leave.
        allowed: how far it may.
        stiffness: of what pulls back; 1 is that of a spring between states.
        offsets, inward, carrying, face, squares: memory.
    """

    around: Indices
    allowed: float
    stiffness: float
    offsets: Array
    inward: Array
    carrying: Indices
    face: Array
    squares: Array


@inner
def make_edge(allowed: float, n: int, stride: float, spacing: float, scratch: Scratch, d: int) -> Edge:
    """What holds a path of n states with steps of `stride`, of a surface of dimension d, free directions included."""
    look = make_look(scratch, d)
    return Edge(
        np.empty((n, look.around.size), np.int64),
        allowed,
        (stride / (YIELDING * spacing)) ** 2,
        look.offsets,
        look.inward,
        look.carrying,
        np.empty((d, d)),
        look.squares,
    )


@inner
def pull_back(
    edge: Edge, iteration: int, path: Array, tangents: Array, scratch: Scratch, stiffness: Array, force: Array
) -> None:
    """What an edge adds to the equations of `newton_steps`: force (n, d) and stiffness (n, d, d).

    Both come from the penalty stiffness / 2 max(s - allowed, 0)^2 on the distance s of each state of a path (n, D)
    from its hull along the tangents (n, d, D). Where the hull is nearest with a face, s changes across that alone.
    """
    d, rows = tangents.shape[1], matrix(scratch.model, ROWS)
    inward, face = edge.inward, edge.face
    for i in range(1, len(path) - 1):
        around = edge.around[i]
        if iteration % STEPS == 0 and iteration < LOOKS * STEPS:
            look_around(matrix(scratch.model, POINTS), path[i], scratch.distances, around, edge.squares)
        offset_by(rows, around, path[i], tangents[i], edge.offsets)
        count = nearest_in_hull(edge.offsets, edge.allowed, inward, edge.carrying)
        away = norm(inward)
        if away <= edge.allowed:
            force[i] = 0.0
            stiffness[i] = 0.0
            continue
        beyond = 1.0 - edge.allowed / away
        kept = directions(edge.offsets, edge.carrying[:count], face)
        for a in range(d):
            force[i, a] = edge.stiffness * beyond * inward[a]
            for b in range(d):
                s = (1.0 - beyond) * inward[a] * inward[b] / away**2 + (beyond if a == b else 0.0)
                for e in range(kept):
                    s -= beyond * face[e, a] * face[e, b]
                stiffness[i, a, b] = edge.stiffness * s


@inner
def directions(points: Array, carrying: Indices, face: Array) -> int:
    """Orthonormal rows of the first of `face` (d, d) along the plane of some of the points (k, d); how many."""
    d, kept = points.shape[1], 0
    for j in range(1, carrying.size):
        if kept < d - 1:
            for a in range(d):
                face[kept, a] = points[carrying[j], a] - points[carrying[0], a]
            before = square(face[kept])
            left = clear(face, kept)
            if left > FLAT * before:
                for a in range(d):
                    face[kept, a] /= math.sqrt(left)
                kept += 1
    return kept


@njit
def hold_geodesic(
    t: Indices, path: Array, spacing: float, tolerance: float, cap: float, limit: int, own: bool, rate: float
) -> tuple:
    """Relax a geodesic (n, D) in place, held within the edge as far as its ends are; (iterations, last step).

    0 iterations where it does not leave it. `t` is the table of its model, in whose inner coordinates all lengths
    are; `spacing` is the usual one of the demonstrations.
    """
    n, inside, scratch = len(path), encode(t, path), make_scratch(t, len(path))
    evaluate(inside[1 : n - 1], scratch)
    allowed = beyond_edge(inside, spacing, scratch)
    if allowed == 0.0:
        return 0, 0.0
    edge = make_edge(allowed, n, mean_step(inside), spacing, scratch, scratch.bases.shape[1])
    iterations, moved, _ = relax(inside, tolerance, cap, limit, 1.0, own, rate, scratch, pull_back, edge)
    decode_path(t, path[0].copy(), path[n - 1].copy(), inside, path)
    return iterations, moved
