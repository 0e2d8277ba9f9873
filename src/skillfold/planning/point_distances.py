"""The compiled loops over obstacle points in the space of states. `c` is a table (see `tables`), one per thread."""

import math

from skillfold.jit import inner, njit
from skillfold.tables import Array, Indices, matrix, vector

POINTS = 0  # (D, m), one row a coordinate, so that loops run over points
RADIUS = 1  # (1,) of the ball about each point that is forbidden
SQUARES = 2  # (m,) scratch
SLOTS = 3

TOUCH = 1e-12  # nearer to a point than this there is no direction away from it


@inner
def measure(q: Array, c: Indices) -> None:
    """Squared distances of all points from q (D,), into SQUARES."""
    points, squares = matrix(c, POINTS), vector(c, SQUARES)
    for k in range(squares.size):
        squares[k] = 0.0
    for a in range(q.size):
        here = q[a]
        for k in range(squares.size):
            squares[k] += (points[a, k] - here) ** 2


@inner
def away_from(point: int, q: Array, distance: float, c: Indices, out: Array) -> None:
    """The unit vector (D,) from a point to q; nothing at the point itself."""
    points = matrix(c, POINTS)
    for a in range(q.size):
        out[a] = (q[a] - points[a, point]) / distance if distance > TOUCH else 0.0


@njit
def clearance(q: Array, gradient: Array, c: Indices) -> float:
    """Distance of q (D,) from the nearest ball, and its gradient unless that is (0,); NaN where q is not finite."""
    squares = vector(c, SQUARES)
    measure(q, c)
    nearest, least = -1, math.inf
    for k in range(squares.size):
        if not squares[k] < math.inf:
            return math.nan
        if squares[k] < least:
            nearest, least = k, squares[k]
    distance = math.sqrt(least)
    if gradient.size:
        away_from(nearest, q, distance, c, gradient)
    return distance - vector(c, RADIUS)[0]


@njit
def within(q: Array, reach: float, distances: Array, gradients: Array, c: Indices) -> int:
    """How many balls are nearer to q (D,) than `reach`, as many as fit; distances and gradients (…, D) of each.

    -1 where q is not finite.
    """
    squares, radius = vector(c, SQUARES), vector(c, RADIUS)[0]
    measure(q, c)
    count, farthest, total = 0, (reach + radius) ** 2, 0.0
    for k in range(squares.size):
        total += squares[k]
        if squares[k] < farthest and count < distances.size:
            distance = math.sqrt(squares[k])
            distances[count] = distance - radius
            away_from(k, q, distance, c, gradients[count])
            count += 1
    return count if total < math.inf else -1


@njit
def edge(start: Array, end: Array, margin: float, c: Indices) -> float:
    """Share of the straight edge that keeps `margin` from all balls, exactly; 0 where an end is not finite.

    A ball is entered where ‖start + t (end − start) − point‖² = (radius + margin)², a quadratic in t.
    """
    points, squares, radius = matrix(c, POINTS), vector(c, SQUARES), vector(c, RADIUS)[0] + margin
    measure(start, c)
    length = 0.0
    for a in range(start.size):
        length += (end[a] - start[a]) ** 2
    if not length < math.inf:
        return 0.0
    way, share = math.sqrt(length), 1.0
    for k in range(squares.size):
        outside = squares[k] - radius**2
        if not outside > 0.0:
            return 0.0
        if squares[k] > (way + radius) ** 2:
            continue
        toward = 0.0
        for a in range(start.size):
            toward += (end[a] - start[a]) * (points[a, k] - start[a])
        inside = toward * toward - length * outside
        if toward > 0.0 and inside > 0.0:
            # The smaller root, written so that it loses no digits where the ball is far.
            share = min(share, outside / (toward + math.sqrt(inside)))
    return share


@njit
def clearances(states: Array, c: Indices, out: Array, gradients: Array) -> None:
    """Clearance (n,) of states (n, D), and gradients (n, D) unless `gradients` is (0, D)."""
    for i in range(len(states)):
        out[i] = clearance(states[i], gradients[i] if len(gradients) else gradients.ravel(), c)
