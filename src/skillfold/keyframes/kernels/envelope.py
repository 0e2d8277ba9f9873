"""Soft-Envelopes for compiled loops: membership of poses, and the nearest poses inside (see `chains`)."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner, njit
from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.kernels import chains
from skillfold.keyframes.kernels.charts import to_full
from skillfold.keyframes.kernels.ellipsoids import Numbers, dot, multiplier, times
from skillfold.tables import matrix, vector

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

GAP = 1e-13  # of the squared distance, between the least found and the least possible: there a search along s stops
STEPS = 80  # of the search, at most; ten are usual
LEAST = 0.01  # of a bracket is cut off by each
HALF_TURN = LENGTH * math.pi * (1.0 - 1e-9)  # longest rotation vector of a chart, scaled
INSIDE = 1.0 - 1e-9  # √d² of projected and sampled poses, so that rounding does not put them outside
TRIES = 14  # each with four times the slack, where poses are a billion times as far off as an ellipsoid is thin


@inner
def part(row: Array, block: int) -> Numbers:
    """A block's matrix of a station."""
    o = 6 * block
    return row[o], row[o + 1], row[o + 2], row[o + 3], row[o + 4], row[o + 5]


@inner
def mixed(first: Numbers, second: Numbers, t: float) -> Numbers:
    """(1 - t) · first + t · second, of two matrices."""
    return (
        first[0] + t * (second[0] - first[0]),
        first[1] + t * (second[1] - first[1]),
        first[2] + t * (second[2] - first[2]),
        first[3] + t * (second[3] - first[3]),
        first[4] + t * (second[4] - first[4]),
        first[5] + t * (second[5] - first[5]),
    )


@inner
def less(first: Numbers, second: Numbers) -> Numbers:
    """Difference of two matrices."""
    return (
        first[0] - second[0],
        first[1] - second[1],
        first[2] - second[2],
        first[3] - second[3],
        first[4] - second[4],
        first[5] - second[5],
    )


@inner
def away(first: Numbers, second: Numbers, step: Numbers, v: Numbers, t: float) -> Numbers:
    """How far a point lies from a block's ellipsoid at t along a segment: squared, its slope, and the way (3,) back.

    `first` and `second` are the matrices at the segment's ends, `step` the way between their means, v the way from
    the first mean to the point.
    """
    u = (v[0] - t * step[0], v[1] - t * step[1], v[2] - t * step[2])
    mu, x0, x1, x2 = multiplier(mixed(first, second, t), u)
    x = (x0, x1, x2)
    slope = -mu * (2.0 * dot(step, x) + dot(x, times(less(second, first), x)))
    return mu * mu * dot(x, x), slope, mu * x0, mu * x1, mu * x2


@inner
def from_slice(blocks: Numbers, t: float) -> Numbers:
    """(t, squared distance to the slice at t of a segment, its slope)."""
    p = away(blocks[0], blocks[1], blocks[2], blocks[3], t)
    r = away(blocks[4], blocks[5], blocks[6], blocks[7], t)
    return t, p[0] + r[0], p[1] + r[1]


@inner
def ends_of(y: Array, k: int, table: Indices) -> Numbers:
    """What `away` wants of both blocks of segment k."""
    stations, start, axis = matrix(table, chains.STATIONS), vector(table, chains.START), vector(table, chains.AXIS)
    n = len(stations) - 1
    share, s = 1.0 / n, k / n
    return (
        part(stations[k], 0),
        part(stations[k + 1], 0),
        (share * axis[0], share * axis[1], share * axis[2]),
        (y[0] - start[0] - s * axis[0], y[1] - start[1] - s * axis[1], y[2] - start[2] - s * axis[2]),
        part(stations[k], 1),
        part(stations[k + 1], 1),
        (share * axis[3], share * axis[4], share * axis[5]),
        (y[3] - start[3] - s * axis[3], y[4] - start[4] - s * axis[4], y[5] - start[5] - s * axis[5]),
    )


@inner
def between(low: Numbers, high: Numbers, level: bool) -> Numbers:
    """Where to look next between (t, value, slope) at both sides of a minimum; and what it cannot be below.

    That is how low the tangents meet, and where they do is the tip of a kink; where a line through both slopes is
    `level` is the bottom of a parabola.
    """
    width = high[0] - low[0]
    meet = (high[1] - low[1] - high[2] * width) / (low[2] - high[2])
    step = low[2] * width / (low[2] - high[2]) if level else meet
    return low[0] + min(max(step, LEAST * width), (1.0 - LEAST) * width), low[1] + low[2] * meet


@inner
def nearest_slice(blocks: Numbers, end: float, best: float) -> Numbers:
    """Least squared distance to the slices of a segment and its t; once it must be above `best`, only that it is.

    `end`, 0 or 1, is looked at first.
    """
    low, high = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    for i in range(STEPS):  # both ends first: fewer places to compile what is called
        t, floor = (abs(end - i), 0.0) if i < 2 else between(low, high, i % 2 == 0)
        if i > 1 and (not min(low[1], high[1]) * (1.0 - GAP) > floor or floor > best):
            break
        here = from_slice(blocks, t)
        if i < 2 and (here[1] - abs(here[2]) > best or (here[2] >= 0.0 if t == 0.0 else here[2] <= 0.0)):
            return here[1], t
        if here[2] < 0.0:
            low = here
        else:
            high = here
    return (low[1], low[0]) if low[1] <= high[1] else (high[1], high[0])


@inner
def farther(y: Array, k: int, table: Indices, best: float) -> bool:
    """Whether all of segment k is certainly farther from y than the root of `best`."""
    axis, reaches = vector(table, chains.AXIS), matrix(table, chains.REACHES)
    n, square = len(reaches), 0.0
    for block in range(2):
        if reaches[k, block] > 0.0:
            length = 0.0
            for c in range(3 * block, 3 * block + 3):
                length += axis[c] * axis[c]
            s = chains.place(y, table, block)
            off = max(chains.beyond(s, k, n) - 1.0 / math.sqrt(reaches[k, block]), 0.0)
            square += length * off * off
    return square > best


@inner
def nearest_segment(y: Array, s: float, table: Indices) -> Numbers:
    """Segment and t along it of the slice that is nearest to y; s is where to look first."""
    n = len(matrix(table, chains.SEGMENTS))
    first = chains.segment_at(s, n)
    best, segment, at = math.inf, first, 0.0
    for i in range(-1, n):
        k = first if i < 0 else i
        if i == first or farther(y, k, table, best):
            continue
        value, t = nearest_slice(ends_of(y, k, table), 1.0 if k < first else 0.0, best)
        if value < best:
            best, segment, at = value, k, t
    return segment, at


@inner
def back(first: Numbers, second: Numbers, step: Numbers, v: Numbers, t: float, inside: float) -> Numbers:
    """How far to move (3,) so that the block is inside the slice at t: √d² is then at most `inside`."""
    sigma = mixed(first, second, t)
    u = (v[0] - t * step[0], v[1] - t * step[1], v[2] - t * step[2])
    _, x0, x1, x2 = multiplier(sigma, u)
    w = times(sigma, (x0, x1, x2))
    root = math.sqrt(dot(w, (x0, x1, x2)))
    share = inside / root if root > inside else 1.0
    return share * w[0] - u[0], share * w[1] - u[1], share * w[2] - u[2]


@inner
def in_chart(turn: Numbers, mean: Numbers) -> Numbers:
    """The turn itself, or where it is more than half a turn what the chart covers of the way to it from the mean.

    Beyond, the same rotation has other coordinates, and gates so wide need not hold those.
    """
    d = (turn[0] - mean[0], turn[1] - mean[1], turn[2] - mean[2])
    short = dot(mean, mean) - HALF_TURN * HALF_TURN
    if dot(turn, turn) <= HALF_TURN * HALF_TURN or short >= 0.0:
        return turn
    a, b = dot(d, d), dot(mean, d)
    share = (math.sqrt(b * b - a * short) - b) / a
    return mean[0] + share * d[0], mean[1] + share * d[1], mean[2] + share * d[2]


@inner
def drawn_in(y: Array, s: float, table: Indices, near: Array, out: Array) -> float:
    """The pose (7,) inside that is nearest to scaled coordinates (6,) outside, to `out`; and how far [m] it is.

    `s` is where to look first, `near` (6,) scratch. What rounding on the way to a pose puts outside goes farther in.
    """
    k, t = nearest_segment(y, s, table)
    b = ends_of(y, k, table)
    mean = (y[3] - b[7][0] + t * b[6][0], y[4] - b[7][1] + t * b[6][1], y[5] - b[7][2] + t * b[6][2])
    slack, moved = 1.0 - INSIDE, 0.0
    for _ in range(TRIES):
        p, r = back(b[0], b[1], b[2], b[3], t, 1.0 - slack), back(b[4], b[5], b[6], b[7], t, 1.0 - slack)
        turn = in_chart((y[3] + r[0], y[4] + r[1], y[5] + r[2]), mean)
        moved = 0.0
        for c in range(3):
            near[c], near[c + 3] = y[c] + p[c], turn[c] / LENGTH
            moved += p[c] * p[c] + (turn[c] - y[c + 3]) * (turn[c] - y[c + 3])
        to_full(near, vector(table, chains.MIDDLE), out)
        chains.scaled(out, table, near)
        if chains.membership_of(near, table)[0] <= 1.0:
            break
        slack *= 4.0
    return math.sqrt(moved)


@inner
def excess(pose: Array, table: Indices) -> float:
    """√d² - 1 of a pose (7,): at most 0 inside."""
    y = np.empty(6)
    chains.scaled(pose, table, y)
    return math.sqrt(chains.membership_of(y, table)[0]) - 1.0


@inner
def projected(pose: Array, out: Array, table: Indices) -> Numbers:
    """√d² - 1 of a pose (7,), and how far [m] the nearest pose inside is, which goes to `out` (7,)."""
    y, near = np.empty(6), np.empty(6)
    chains.scaled(pose, table, y)
    square, s = chains.membership_of(y, table)
    moved = 0.0
    if square <= 1.0:
        for c in range(7):
            out[c] = pose[c]
    else:
        moved = drawn_in(y, s, table, near, out)
    return math.sqrt(square) - 1.0, moved


@njit
def memberships(poses: Array, table: Indices, squares: Array, places: Array) -> None:
    """Least d² (n,) of poses (n, 7) and its s (n,)."""
    y = np.empty(6)
    for i in range(len(poses)):
        chains.scaled(poses[i], table, y)
        squares[i], places[i] = chains.membership_of(y, table)


@njit
def projections(poses: Array, table: Indices, out: Array, distances: Array) -> None:
    """Nearest poses inside (n, 7) of poses (n, 7), and their distances (n,) [m]."""
    for i in range(len(poses)):
        distances[i] = projected(poses[i], out[i], table)[1]
