"""The anchors nearest to states."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inlined, inner

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

ROUNDING = 1e-14  # relative: two sums of the same numbers may differ by so much
LIKELY = 0.5  # of how far anchors are known: where a state moved farther, it is not even tried with those


@inlined
def nearest_anchors(
    points: Array,
    rows: Array,
    neighbours: Indices,
    reaches: Array,
    states: Array,
    distances: Array,
    nearest: Indices,
    squares: Array,
    around: Indices,
    around_squares: Array,
    origins: Array,
    known: Array,
) -> None:
    """The nearest anchors of states (n, D), sorted, into `nearest` and their squared distances into `squares` (n, m).

    Looked for among those `around` (n, K) that were nearest when a search was last made: from its `origins` (n, D)
    no other is nearer than `known` (n,). By the triangle inequality none can be missing where the farthest found and
    the way from there together stay within that; in an iteration states hardly move, and on a path they lie close to
    the one before. Else a search is made.
    """
    last = nearest.shape[1] - 1
    for i in range(len(states)):
        moved = apart(states, i, origins, i)
        if i > 0 and not moved < LIKELY * known[i]:
            beside = apart(states, i, origins, i - 1)
            if beside < LIKELY * known[i - 1]:
                moved, known[i] = beside, known[i - 1]
                for c in range(states.shape[1]):
                    origins[i, c] = origins[i - 1, c]
                for k in range(around.shape[1]):
                    around[i, k] = around[i - 1, k]
        for attempt in range(2):
            if attempt == 1 or not moved < LIKELY * known[i]:
                known[i] = search(
                    points, rows, neighbours, reaches, states, i, last, distances, around, around_squares
                )
                moved = 0.0
                for c in range(states.shape[1]):
                    origins[i, c] = states[i, c]
            among(rows, around, i, states, i, nearest, squares, i)
            if math.sqrt(squares[i, last]) + moved <= known[i]:
                break


@inner
def apart(a: Array, i: int, b: Array, j: int) -> float:
    """Distance between row i of a and row j of b."""
    s = 0.0
    for c in range(a.shape[1]):
        s += (a[i, c] - b[j, c]) ** 2
    return math.sqrt(s)


@inlined
def search(
    points: Array,
    rows: Array,
    neighbours: Indices,
    reaches: Array,
    states: Array,
    i: int,
    last: int,
    distances: Array,
    around: Indices,
    squares: Array,
) -> float:
    """The anchors nearest to state i into around[i] (K,), exact up to `last`; returns how near others can be.

    Looked for among the neighbours of the anchor that was nearest before, then of the nearest of those: states that
    come one after the other lie side by side, and so do those of the last call and this one. Else all anchors are
    asked, but those passed over at once that are farther than all that were nearest before; `around` (n, K) must
    name K anchors for each state from the start.
    """
    centre, others, found = around[i, 0], 0.0, False
    for _ in range(2 if neighbours.shape[1] else 0):
        own = 0.0
        for c in range(states.shape[1]):
            own += (states[i, c] - rows[centre, c]) ** 2
        others = float(reaches[centre]) - math.sqrt(own)
        if others <= 0.0:
            break
        among(rows, neighbours, centre, states, i, around, squares, 0)
        found = math.sqrt(squares[0, last]) <= others
        if found or around[i, 0] == centre:
            break
        centre = around[i, 0]
    if not found:
        others = math.inf
        distances[:] = 0.0
        for c in range(states.shape[1]):
            here = states[i, c]
            for k in range(distances.size):
                distances[k] += (here - points[c, k]) ** 2
        bound = min(farthest(distances, around[i]), farthest(distances, around[max(i - 1, 0)]))
        smallest_within(distances, bound, around[i], squares[0])
    return min(others, math.sqrt(squares[0, squares.size - 1])) if squares.size < len(rows) else math.inf


@inner
def farthest(values: Array, indices: Indices) -> float:
    """The largest of the values, 0 or more, at some indices."""
    worst = 0.0
    for j in range(indices.size):
        worst = max(worst, float(values[indices[j]]))
    return worst


@inlined
def among(
    rows: Array, asked: Indices, which: int, states: Array, i: int, nearest: Indices, squares: Array, where: int
) -> None:
    """The nearest of the anchors asked[which] to state i, into nearest[i], and their squares into squares[where]."""
    last = squares.shape[1] - 1
    worst = np.inf
    for j in range(last + 1):
        squares[where, j] = np.inf
    for k in range(asked.shape[1]):
        anchor = asked[which, k]
        s = 0.0
        for c in range(states.shape[1]):
            s += (states[i, c] - rows[anchor, c]) ** 2
        if s < worst:
            j = last
            while j > 0 and squares[where, j - 1] > s:
                squares[where, j] = squares[where, j - 1]
                nearest[i, j] = nearest[i, j - 1]
                j -= 1
            squares[where, j] = s
            nearest[i, j] = anchor
            worst = squares[where, last]


@inner
def smallest(values: Array, indices: Indices, found: Array) -> None:
    """The smallest values, sorted, into `found`, and where they stand into `indices`."""
    smallest_within(values, np.inf, indices, found)


@inner
def smallest_within(values: Array, bound: float, indices: Indices, found: Array) -> None:
    """The same, where none of them is larger than `bound`."""
    m = indices.size
    found[:] = np.inf
    worst = bound * (1.0 + ROUNDING)
    for i in range(values.size):
        if values[i] < worst:
            j = m - 1
            while j > 0 and found[j - 1] > values[i]:
                found[j] = found[j - 1]
                indices[j] = indices[j - 1]
                j -= 1
            found[j] = values[i]
            indices[j] = i
            worst = min(worst, found[m - 1])
