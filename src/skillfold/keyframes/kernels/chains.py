"""Chains of ellipsoids in a chart of poses, and how far inside or outside them poses lie.

A chain has n + 1 stations at s = k/n, each with a mean and for each block, position and rotation, a matrix Σ: inside
is v'Σ⁻¹v ≤ 1 in both. Between stations means and matrices go straight. v'Σ⁻¹v is convex in v and Σ together, so along
a segment both the worse block's d² and the distance to the slice are convex in s. Coordinates are scaled: all six in
metres.
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
GAP = 1e-13  # of d², that the next step of a search along s can gain: there it stops
STEPS = 60  # of the search, at most; five are usual
NEWTON = 8  # after so many every other one halves what is left: near a very thin end parabolas tell little
FARTHEST = 4.0  # step, in segments


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
    """A block's d² at t, and its first and second derivative."""
    a0, a1, a2, b0, b1, b2, l0, l1, l2 = block
    g0, g1, g2 = l0 - 1.0, l1 - 1.0, l2 - 1.0
    w0, w1, w2 = 1.0 / (1.0 + t * g0), 1.0 / (1.0 + t * g1), 1.0 / (1.0 + t * g2)
    u0, u1, u2 = a0 - t * b0, a1 - t * b1, a2 - t * b2
    q0, q1, q2 = u0 * w0, u1 * w1, u2 * w2
    c0, c1, c2 = b0 + q0 * g0, b1 + q1 * g1, b2 + q2 * g2
    slope = q0 * (b0 + c0) + q1 * (b1 + c1) + q2 * (b2 + c2)
    return u0 * q0 + u1 * q1 + u2 * q2, -slope, 2.0 * (c0 * c0 * w0 + c1 * c1 * w1 + c2 * c2 * w2)


@inner
def bottom(parabola: Numbers) -> float:
    """The step to the bottom of a parabola (value, slope, bend)."""
    _, slope, bend = parabola
    return -slope / bend if abs(slope) < FARTHEST * bend else -math.copysign(FARTHEST, slope)


@inner
def ahead(parabola: Numbers, step: float) -> float:
    """A parabola's value after a step."""
    return parabola[0] + step * (parabola[1] + 0.5 * parabola[2] * step)


@inner
def descent(upper: Numbers, lower: Numbers) -> Numbers:
    """The step to where the greater of two parabolas is least, and how much lower that is; `upper` is greater here.

    That is the bottom of one of them, if the other is below it there, or else where they cross between the two.
    """
    step, other = bottom(upper), bottom(lower)
    a = ahead(lower, step) - ahead(upper, step)
    if a <= 0.0:
        return step, upper[0] - ahead(upper, step)
    if ahead(upper, other) <= ahead(lower, other):
        return other, upper[0] - ahead(lower, other)
    width, bend = other - step, lower[2] - upper[2]
    b, c = (lower[1] - upper[1] + bend * step) * width, 0.5 * bend * width * width
    step += width * min(2.0 * a / (math.sqrt(max(b * b - 4.0 * a * c, 0.0)) - b), 1.0)
    return step, upper[0] - ahead(upper, step)


@inner
def lowest(position: Numbers, rotation: Numbers, t: float, best: float) -> Numbers:
    """Least d² along a segment and its place, looking first at t; once it must be above `best`, only that it is."""
    low, high, least, at = -1.0, 2.0, math.inf, t  # nothing seen yet within 0 and 1
    for i in range(STEPS):
        upper, lower = square(position, t), square(rotation, t)
        if upper[0] < lower[0]:
            upper, lower = lower, upper
        if upper[0] < least:
            least, at = upper[0], t
        if upper[1] < 0.0:
            low = t
        else:
            high = t
        left = t - max(low, 0.0) if upper[1] >= 0.0 else t - min(high, 1.0)
        step, gain = descent(upper, lower)
        then = min(max(t + step, 0.0), 1.0)
        if then == t or gain <= GAP * (1.0 + least) or upper[0] - upper[1] * left > best:
            break
        trusted = low < then < high and (i < NEWTON or i % 2 == 0)
        t = then if trusted else 0.5 * (max(low, 0.0) + min(high, 1.0))
    return least, at


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
        t = min(max(by_position * n - k, 0.0), 1.0)
        value, t = lowest(block_of(row, 0, y), block_of(row, 1, y), t, best)
        if value < best:
            best, at = value, (k + t) / n
    return best, at
