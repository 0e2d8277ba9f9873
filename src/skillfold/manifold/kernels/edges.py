"""Where the demonstrations end: at the convex hull of the anchors around a state, seen along the surface.

Whoever goes a spacing beyond the last anchor may cross what the demonstrations never crossed, such as a floor that
nobody spoke of. Within the hull of the nearest ones that is crossed only as far as they lie about a hollow.
"""

import math
from typing import Any, NamedTuple

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
APART = 2.0  # spacings between states that are looked at
ENDS = 1.5  # times as far beyond it as its ends are, a path may go: who asked for these wants what lies between


@inner
def nearest_in_hull(points: Array, enough: float, found: Array, carrying: Indices) -> int:
    """The point of the convex hull of points (k, d) nearest to the origin, into `found` (d,).

    Or one within `enough` of the origin, where that is in reach. By Wolfe's algorithm: the point farthest behind
    joins those that carry the hull's face, and those leave without which it is nearer. Returns how many carry the
    face in the end, the first of `carrying` (d + 2,).
    """
    d, count = points.shape[1], 1
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
        ahead, carried = 0.0, False
        for c in range(d):
            ahead += points[behind, c] * found[c]
        for i in range(count):
            carried = carried or carrying[i] == behind  # by rounding alone
        if square <= enough**2 or square - ahead <= SURE * square or carried or count == d + 2:
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
    return count


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


class Look(NamedTuple):
    """Memory of a look at the edge around a state.

    Attributes:
        around, squares: (k,) anchors that span the hull, and their squared distances.
        offsets: (k, d) of them.
        inward: (d,) to the nearest point of the hull.
        carrying: (d + 2,).
    """

    around: Indices
    squares: Array
    offsets: Array
    inward: Array
    carrying: Indices


@inner
def make_look(scratch: Scratch, d: int) -> Look:
    """Room for it, on a surface of dimension d."""
    k = min(HULL + A_DIMENSION * d, scratch.distances.size)
    return Look(np.empty(k, np.int64), np.empty(k), np.empty((k, d)), np.empty(d), np.empty(d + 2, np.int64))


@inner
def is_within(state: Array, i: int, short: float, scratch: Scratch, look: Look) -> bool:
    """Whether a state is no farther than `short` beyond the edge; if it is, the way back is in `look.inward`.

    Scratch was evaluated there or hardly aside, as state i.
    """
    rows, basis = matrix(scratch.model, ROWS), scratch.bases[i]
    known = min(scratch.around.shape[1], look.around.size)
    # Amid those that are known already it needs no look at all.
    if is_amid(rows, scratch.around[i, :known], state, basis, short, look):
        return True
    look_around(matrix(scratch.model, POINTS), state, scratch.distances, look.around, look.squares)
    return is_amid(rows, look.around, state, basis, short, look)


@inlined
def beyond_edge(path: Array, spacing: float, scratch: Scratch) -> float:
    """How far beyond the edge a path (n, D) may go, if it goes farther, else 0; that depends on where its ends are.

    Scratch was evaluated at its inner states.
    """
    n, look = len(path), make_look(scratch, scratch.bases.shape[1])
    allowed, looked = SHORT * spacing, False
    stride = max(1, int(min(APART * spacing / max(mean_step(path), 1e-300), n)))
    for i in range(min(stride, n // 2), n - 1, stride):
        if is_within(path[i], i - 1, allowed, scratch, look):
            continue
        if not looked:  # at the ends, which are seldom asked
            looked = True
            for end, row in ((0, 0), (n - 1, n - 3)):
                if not is_within(path[end], row, SHORT * spacing, scratch, look):
                    allowed = max(allowed, ENDS * norm(look.inward))
        if not is_within(path[i], i - 1, allowed, scratch, look):
            return allowed
    return 0.0


@inner
def mean_step(path: Array) -> float:
    """Mean distance of consecutive states (n, D)."""
    length = 0.0
    for i in range(1, len(path)):
        square = 0.0
        for c in range(path.shape[1]):
            square += (path[i, c] - path[i - 1, c]) ** 2
        length += math.sqrt(square)
    return length / (len(path) - 1)


@inlined
def draw_in(spacing: float, points: Array, tolerance: float, scratch: Scratch, on: Flags) -> None:
    """Points of the surface (n, D; changed in place) beyond the edge of the demonstrations, brought to it.

    Those alone that are `on` the surface (n,); one that loses it on the way is so no longer.
    """
    d = scratch.bases.shape[1]
    look = make_look(scratch, d)
    within, moved = ~on, False
    for _ in range(TURNS):
        evaluate(points, scratch)
        for i in range(len(points)):
            within[i] = within[i] or is_within(points[i], i, SHORT * spacing, scratch, look)
            if not within[i]:
                moved = True
                for c in range(points.shape[1]):
                    points[i, c] -= scratch.normals[i, c]
                    for a in range(d):
                        points[i, c] += look.inward[a] * scratch.bases[i, a, c]
        if within.all():
            break
    if moved:
        met = descend(np.inf, np.inf, np.inf, points, points, tolerance, 0.0, scratch)
        for i in range(len(points)):
            on[i] = on[i] and met[i]


@inner
def look_around(columns: Array, state: Array, distances: Array, around: Indices, squares: Array) -> None:
    """The nearest anchors of one state, sorted, and their squared distances."""
    distances[:] = 0.0
    for c in range(state.size):
        for i in range(distances.size):
            distances[i] += (state[c] - columns[c, i]) ** 2
    smallest(distances, around, squares)


@inner
def is_amid(rows: Array, around: Indices, state: Array, basis: Array, short: float, look: Look) -> bool:
    """Whether a state is no farther than `short` from the hull of anchors, along the rows of a basis (d, D).

    The way there along them is in `look.inward`.
    """
    offsets = look.offsets[: around.size]
    offset_by(rows, around, state, basis, offsets)
    nearest_in_hull(offsets, short, look.inward, look.carrying)
    return norm(look.inward) <= 1.001 * short


@inner
def offset_by(rows: Array, around: Indices, state: Array, basis: Array, offsets: Array) -> None:
    """Offsets (k, d) of anchors from a state along the rows of a basis (d, D)."""
    for j in range(around.size):
        for a in range(len(basis)):
            s = 0.0
            for c in range(state.size):
                s += basis[a, c] * (rows[around[j], c] - state[c])
            offsets[j, a] = s
