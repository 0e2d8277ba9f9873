"""The anchors nearest to states."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inlined, inner

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

ROUNDING = 1e-14  # relative: two sums of the same numbers may differ by so much


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
) -> None:
    """Looked for among the neighbours of the anchor that was nearest before, then of the nearest of those.

    States that come one after the other lie side by side, and so do those of the last call and this one. By the
    triangle inequality nothing nearer can be missing where the farthest found and that anchor's own distance
    together stay within its reach. Else all anchors are asked, but those passed over at once that are farther than
    all that were nearest before; `nearest` (n, m) must name m anchors for each state from the start.
    """
    last = nearest.shape[1] - 1
    for i in range(len(states)):
        centre = nearest[i, 0]
        found = False
        for _ in range(2 if neighbours.shape[1] else 0):
            own = among(rows, neighbours, centre, states, i, nearest, squares)
            found = math.sqrt(squares[i, last]) + math.sqrt(own) <= reaches[centre]
            if found or nearest[i, 0] == centre:
                break
            centre = nearest[i, 0]
        if not found:
            distances[:] = 0.0
            for c in range(states.shape[1]):
                here = states[i, c]
                for k in range(distances.size):
                    distances[k] += (here - points[c, k]) ** 2
            bound = min(farthest(distances, nearest[i]), farthest(distances, nearest[max(i - 1, 0)]))
            smallest_within(distances, bound, nearest[i], squares[i])


@inner
def farthest(values: Array, indices: Indices) -> float:
    """The largest of the values, 0 or more, at some indices."""
    worst = 0.0
    for j in range(indices.size):
        worst = max(worst, float(values[indices[j]]))
    return worst


@inlined
def among(
    rows: Array, neighbours: Indices, centre: int, states: Array, i: int, nearest: Indices, squares: Array
) -> float:
    """The nearest of an anchor's neighbours to state i; returns the anchor's own squared distance."""
    last = squares.shape[1] - 1
    squares[i] = np.inf
    own, worst = 0.0, np.inf
    for k in range(neighbours.shape[1]):
        anchor = neighbours[centre, k]
        s = 0.0
        for c in range(states.shape[1]):
            s += (states[i, c] - rows[anchor, c]) ** 2
        if k == 0:
            own = s
        if s < worst:
            j = last
            while j > 0 and squares[i, j - 1] > s:
                squares[i, j] = squares[i, j - 1]
                nearest[i, j] = nearest[i, j - 1]
                j -= 1
            squares[i, j] = s
            nearest[i, j] = anchor
            worst = squares[i, last]
    return own


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
