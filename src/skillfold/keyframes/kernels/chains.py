"""Chains of ellipsoids in a chart of poses, and how far inside or outside them poses lie.

A chain has n + 1 stations at s = k/n, each with a mean and for each block, position and rotation, a matrix Σ: inside
is v'Σ⁻¹v ≤ 1 in both. Between stations means and matrices go straight. v'Σ⁻¹v is convex in v and Σ together, so along
a segment both the worse block's d² and the distance to the slice are convex in s: their minimum is where tangents
from both sides meet. Coordinates are scaled: all six in metres.
"""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner
from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.kernels.charts import to_flat
from skillfold.keyframes.kernels.ellipsoids import Numbers
from skillfold.tables import matrix, vector

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

# Slots of a chain's table.
MIDDLE = 0  # (4,) middle rotation of the chart
START = 1  # (6,) mean at s = 0
AXIS = 2  # (6,) mean at s = 1 less that at s = 0
STATIONS = 3  # (n + 1, 12) Σ of position and rotation, six numbers each
SEGMENTS = 4  # (n, 36) for each block: W' row by row, W'm, b and λ, see `block_of`
REACHES = 5  # (n, 2) least d² per squared difference in s along the block's axis
SLOTS = 6

WIDTH = 18  # numbers of a block in SEGMENTS
GAP = 1e-12  # between the least value found and the least possible, where a search along s stops
LEAST = 0.1  # of a bracket is cut off by each step of the search
STEPS = 80  # of the search, at most; ten are usual


@inner
def scaled(pose: Array, table: Indices, y: Array) -> None:
    """Scaled chart coordinates (6,) of a pose (7,)."""
    to_flat(pose, vector(table, MIDDLE), y)
    for c in range(3, 6):
        y[c] *= LENGTH


@inner
def block_of(row: Array, block: int, y: Array) -> Numbers:
    """What gives a block's d² along a segment: a = W'(y - m), b, λ.

    W turns the matrix at the segment's start into the identity and that at its end into λ, so that at t from 0 to 1
    d² = Σ (a - t b)² / (1 + t (λ - 1)).
    """
    o, c = WIDTH * block, 3 * block
    u, v, w = y[c], y[c + 1], y[c + 2]
    return (
        row[o] * u + row[o + 1] * v + row[o + 2] * w - row[o + 9],
        row[o + 3] * u + row[o + 4] * v + row[o + 5] * w - row[o + 10],
        row[o + 6] * u + row[o + 7] * v + row[o + 8] * w - row[o + 11],
        row[o + 12],
        row[o + 13],
        row[o + 14],
        row[o + 15],
        row[o + 16],
        row[o + 17],
    )


@inner
def square(block: Numbers, t: float) -> Numbers:
    """A block's d² at t, and its slope."""
    value, slope = 0.0, 0.0
    a0, a1, a2, b0, b1, b2, l0, l1, l2 = block
    for a, b, g in ((a0, b0, l0 - 1.0), (a1, b1, l1 - 1.0), (a2, b2, l2 - 1.0)):
        u = a - t * b
        q = u / (1.0 + t * g)
        value += u * q
        slope -= q * (2.0 * b + q * g)
    return value, slope


@inner
def worse(position: Numbers, rotation: Numbers, t: float) -> Numbers:
    """(t, d² there of the block farther out, its slope)."""
    first, second = square(position, t), square(rotation, t)
    value, slope = first if first[0] >= second[0] else second
    return t, value, slope


@inner
def crossing(low: Numbers, high: Numbers) -> Numbers:
    """Where tangents (t, value, slope) at both sides of a minimum meet, kept off the sides; and how low they meet."""
    width = high[0] - low[0]
    step = (high[1] - low[1] - high[2] * width) / (low[2] - high[2])
    return low[0] + min(max(step, LEAST * width), (1.0 - LEAST) * width), low[1] + low[2] * step


@inner
def lowest(position: Numbers, rotation: Numbers, best: float) -> Numbers:
    """Least d² along a segment and its t; once it must be above `best`, only that it is."""
    low, high = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    for i in range(STEPS):  # both ends first: fewer places to compile what is called
        t, floor = (float(i), 0.0) if i < 2 else crossing(low, high)
        if i > 1 and (not min(low[1], high[1]) - floor > GAP * (1.0 + floor) or floor > best):
            break
        here = worse(position, rotation, t)
        if (i == 0 and here[2] >= 0.0) or (i == 1 and here[2] <= 0.0):
            return here[1], t
        if here[2] < 0.0:
            low = here
        else:
            high = here
    return (low[1], low[0]) if low[1] <= high[1] else (high[1], high[0])


@inner
def place(y: Array, table: Indices, block: int) -> float:
    """Nearest s of a block's axis, which goes on beyond its ends; 0 if it has no length."""
    start, axis = vector(table, START), vector(table, AXIS)
    along, length = 0.0, 0.0
    for c in range(3 * block, 3 * block + 3):
        along += axis[c] * (y[c] - start[c])
        length += axis[c] * axis[c]
    return along / length if length > 0.0 else 0.0


@inner
def beyond(s: float, k: int, n: int) -> float:
    """How far s is from segment k of n."""
    return max(k / n - s, s - (k + 1) / n, 0.0)


@inner
def segment_at(s: float, n: int) -> int:
    """The segment, of n, nearest to s; the first for NaN."""
    return min(max(int(s * n), 0), n - 1) if 0.0 < s < 1.0 else (n - 1 if s >= 1.0 else 0)


@inner
def membership_of(y: Array, table: Indices) -> Numbers:
    """Least d² over the chain of scaled coordinates (6,), and its s."""
    segments, reaches = matrix(table, SEGMENTS), matrix(table, REACHES)
    n = len(segments)
    by_position, by_rotation = place(y, table, 0), place(y, table, 1)
    first = segment_at(by_position, n)
    best, at = math.inf, 0.0
    for i in range(-1, n):  # the most likely one first, then all
        k = first if i < 0 else i
        p, r = beyond(by_position, k, n), beyond(by_rotation, k, n)
        if max(p * p * reaches[k, 0], r * r * reaches[k, 1]) > best or i == first:
            continue
        row = segments[k]
        value, t = lowest(block_of(row, 0, y), block_of(row, 1, y), best)
        if value < best:
            best, at = value, (k + t) / n
    return best, at
