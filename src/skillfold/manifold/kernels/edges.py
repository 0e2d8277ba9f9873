"""Where the demonstrations end: at the convex hull of the anchors around a state, seen along the surface.

Whoever goes a spacing beyond the last anchor may cross what the demonstrations never crossed, such as a floor that
nobody spoke of. Within the hull of the nearest ones that is crossed only as far as they lie about a hollow.
"""

from typing import Any

import numpy as np

from skillfold.jit import inlined, inner
from skillfold.manifold.kernels.neighbours import smallest
from skillfold.manifold.kernels.newton import descend
from skillfold.manifold.kernels.scratch import Scratch, evaluate
from skillfold.manifold.kernels.small import norm, solve_in_place
from skillfold.manifold.kernels.surface import Flags
from skillfold.manifold.kernels.tabled import POINTS, ROWS
from skillfold.tables import Indices, matrix

Array = np.ndarray[Any, np.dtype[np.float64]]

# Anchors that span the hull, and more for each dimension: fewer might lie all on one side by chance.
HULL, A_DIMENSION = 12, 4
TURNS = 8  # along the surface and back onto it: hulls change on the way
ROUNDS = 100  # of Wolfe's algorithm, at most; it ends by itself after a few
SURE = 1e-10  # of the square of a distance, that it may be off by
ROUNDING = 1e-12  # of the squares of lengths, added to them: points that coincide would tell of no hull
SHORT = 0.02  # of the spacing: states no farther beyond the edge stay


@inner
def nearest_in_hull(points: Array, enough: float, found: Array) -> None:
    """The point of the convex hull of points (k, d) nearest to the origin, into `found` (d,).

    Or one within `enough` of the origin, where that is in reach. By Wolfe's algorithm: the point farthest behind
    joins those that carry the hull's face, and those leave without which it is nearer.
    """
    d = points.shape[1]
    carrying, count = np.empty(d + 2, np.int64), 1
    shares, wanted, gram = np.zeros(d + 2), np.empty((d + 3, 1)), np.empty((d + 3, d + 3))
    carrying[0], shares[0] = smallest_product(points, points[0]), 1.0
    for _ in range(ROUNDS):
        square = 0.0
        for c in range(d):
            found[c] = 0.0
            for i in range(count):
                found[c] += shares[i] * points[carrying[i], c]
            square += found[c] ** 2
        behind = smallest_product(points, found)
        ahead = 0.0
        for c in range(d):
            ahead += points[behind, c] * found[c]
        if square <= enough**2 or square - ahead <= SURE * square or count == d + 2:
            break
        carrying[count], shares[count] = behind, 0.0
        count += 1
        while True:
            nearest_in_plane(points, carrying, count, gram, wanted)
            way = 1.0
            for i in range(count):
                if wanted[i, 0] <= 0.0:
                    way = min(way, shares[i] / max(shares[i] - wanted[i, 0], 1e-300))
            kept = 0
            for i in range(count):
                share = shares[i] + way * (wanted[i, 0] - shares[i])
                if wanted[i, 0] > 0.0 or share > SURE:
                    carrying[kept], shares[kept] = carrying[i], share
                    kept += 1
            if kept == count:
                break
            count = kept


@inner
def smallest_product(points: Array, direction: Array) -> int:
    """Which of points (k, d) is the farthest behind along a direction."""
    least, found = np.inf, 0
    for i in range(len(points)):
        s = 0.0
        for c in range(direction.size):
            s += points[i, c] * direction[c]
        if s < least:
            least, found = s, i
    return found


@inner
def nearest_in_plane(points: Array, carrying: Indices, count: int, gram: Array, shares: Array) -> None:
    """Shares (n, 1), adding up to 1, of the first `count` carrying points in the point of their plane nearest to 0.

    Gram (n, n) is memory; what is not used of it stays apart.
    """
    n = len(gram)
    for i in range(n):
        shares[i, 0] = 0.0
        for j in range(n):
            gram[i, j] = 1.0 if i == j else 0.0
    for i in range(count):
        for j in range(i + 1):
            s = 0.0
            for c in range(points.shape[1]):
                s += points[carrying[i], c] * points[carrying[j], c]
            gram[i, j] = gram[j, i] = s * (1.0 + ROUNDING) if i == j else s
        gram[i, n - 1] = gram[n - 1, i] = 1.0
    gram[n - 1, n - 1], shares[n - 1, 0] = 0.0, 1.0
    solve_in_place(gram, shares)


@inlined
def draw_in(spacing: float, points: Array, tolerance: float, scratch: Scratch, on: Flags) -> None:
    """Points of the surface (n, D; changed in place) beyond the edge of the demonstrations, brought to it.

    Those alone that are `on` the surface (n,); one that loses it on the way is so no longer.
    """
    rows, d = matrix(scratch.model, ROWS), scratch.bases.shape[1]
    k = min(HULL + A_DIMENSION * d, len(rows))
    known, around, squares = min(scratch.around.shape[1], k), np.empty(k, np.int64), np.empty(k)
    offsets, inward, short = np.empty((k, d)), np.empty(d), SHORT * spacing
    within, moved = ~on, False
    for _ in range(TURNS):
        evaluate(points, scratch)
        for i in range(len(points)):
            if not within[i]:
                # Amid those that are known already it needs no look at all.
                for j in range(known):
                    around[j] = scratch.around[i, j]
                within[i] = is_amid(rows, around[:known], points[i], scratch.bases[i], short, offsets[:known], inward)
                if not within[i]:
                    look_around(matrix(scratch.model, POINTS), points[i], scratch.distances, around, squares)
                    within[i] = is_amid(rows, around, points[i], scratch.bases[i], short, offsets, inward)
                if not within[i]:
                    moved = True
                    for c in range(points.shape[1]):
                        points[i, c] -= scratch.normals[i, c]
                        for a in range(d):
                            points[i, c] += inward[a] * scratch.bases[i, a, c]
        if within.all():
            break
    if moved:
        met = descend(np.inf, np.inf, np.inf, points, points, tolerance, 0.0, scratch)
        for i in range(len(points)):
            on[i] = on[i] and met[i]


@inlined
def look_around(columns: Array, state: Array, distances: Array, around: Indices, squares: Array) -> None:
    """The nearest anchors of one state, sorted, and their squared distances."""
    distances[:] = 0.0
    for c in range(state.size):
        for i in range(distances.size):
            distances[i] += (state[c] - columns[c, i]) ** 2
    smallest(distances, around, squares)


@inner
def is_amid(
    rows: Array, around: Indices, state: Array, basis: Array, short: float, offsets: Array, inward: Array
) -> bool:
    """Whether a state is no farther than `short` from the hull of anchors, along the rows of a basis (d, D).

    The way there along them is in `inward` (d,); offsets is (k, d) memory.
    """
    for j in range(around.size):
        for a in range(len(basis)):
            offsets[j, a] = 0.0
            for c in range(state.size):
                offsets[j, a] += basis[a, c] * (rows[around[j], c] - state[c])
    nearest_in_hull(offsets, short, inward)
    return norm(inward) <= 1.001 * short
