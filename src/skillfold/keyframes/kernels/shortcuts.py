"""Shortcuts of a path that stay inside and clear."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner, njit
from skillfold.keyframes.kernels.edges import edge_is_clear, seems_to_hold, wound
from skillfold.keyframes.kernels.problem import make_work, problem_at

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

GAIN = 1e-3  # of its length that a way must lose, or the shortcut is not worth it


@inner
def step_length(path: Array, i: int) -> float:
    """Length of the edge that starts at row i."""
    s = 0.0
    for k in range(path.shape[1]):
        s += (path[i + 1, k] - path[i, k]) ** 2
    return math.sqrt(s)


@inner
def point_at(path: Array, count: int, way: float, out: Array) -> int:
    """The point (D,) of a path's first `count` rows at a length from its start; the row its edge starts at."""
    i, length = 0, step_length(path, 0)
    while way > length and i < count - 2:
        way -= length
        i += 1
        length = step_length(path, i)
    share = min(way / max(length, 1e-300), 1.0)
    for k in range(out.size):
        out[k] = path[i, k] + share * (path[i + 1, k] - path[i, k])
    return i


@inner
def splice(path: Array, count: int, i: int, j: int, a: Array, b: Array) -> int:
    """Replace the rows i + 1 to j by a and b (D,); the new number of rows."""
    shift = i + 3 - (j + 1)
    if shift <= 0:
        for row in range(j + 1, count):
            for k in range(a.size):
                path[row + shift, k] = path[row, k]
    else:
        for row in range(count - 1, j, -1):
            for k in range(a.size):
                path[row + shift, k] = path[row, k]
    for k in range(a.size):
        path[i + 1, k], path[i + 2, k] = a[k], b[k]
    return count + shift


@njit
def shorten(table: Indices, path: Array, count: int, picks: Array) -> int:
    """Straight shortcuts between places of a path, its first `count` rows, in place; the number of rows left.

    Each row of `picks` (r, 2) in [0, 1) names two places by their share of the length. Rows face each other: no edge
    is longer than half a turn of a continuous joint. Where the way between winds round such a joint, the shortcut
    turns it the shorter way, and all rows behind lose the full turns.
    """
    D, problem = path.shape[1], problem_at(table)
    a, b, turns, work = np.empty(D), np.empty(D), np.empty(D), make_work(D)
    for r in range(len(picks)):
        total = 0.0
        for i in range(count - 1):
            total += step_length(path, i)
        first, last = min(picks[r, 0], picks[r, 1]) * total, max(picks[r, 0], picks[r, 1]) * total
        i, j = point_at(path, count, first, a), point_at(path, count, last, b)
        wound(problem.turning, a, b, turns)
        chord = 0.0
        for k in range(D):
            b[k] -= turns[k]
        for k in range(D):
            chord += (b[k] - a[k]) ** 2
        gained = last - first - math.sqrt(chord)
        if i == j or count + i + 2 - j > len(path) or gained < GAIN * total:
            continue
        if seems_to_hold(problem, a, b, work) and edge_is_clear(problem, a, b, work):
            count = splice(path, count, i, j, a, b)
            for row in range(i + 3, count):
                for k in range(D):
                    path[row, k] -= turns[k]
    return count
