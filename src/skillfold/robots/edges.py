"""The Numba loops over edges: conservative advancement, by bounds on how fast any point of the robot can move.

Tables and scratch memory as in `distances`.
"""

import math

import numpy as np

from skillfold.jit import inner, njit
from skillfold.robots import kinematics as kin
from skillfold.robots.distances import (
    BOUNDS,
    FEELER_BOUNDS,
    FEELERS,
    LOWER,
    PAIRS,
    UPPER,
    finite,
    measured,
    nearer,
    nearest_point,
    stand,
)
from skillfold.tables import Array, Indices, index_matrix, indices, matrix, vector

SLACK = 1e-4  # metres: an edge nearer than this to the margin is not called clear, so that steps stay finite
MOST = 200_000  # steps: an edge that takes more is none that a robot goes


@inner
def speed_of(bounds: Array, p: int, step: Array, c: Indices) -> float:
    """Longest way [m] of the points of one pair against each other along a straight step (dof,)."""
    columns, ratios = indices(c, kin.COLUMNS), vector(c, kin.RATIOS)
    total = 0.0
    for k in range(columns.size):
        total += bounds[p, k] * abs(ratios[k] * step[columns[k]])
    return total


@inner
def pair_advance(advance: float, margin: float, step: Array, c: Indices) -> float:
    """Share of the step that no pair of shapes can use up, at most `advance`; negative where one has too little."""
    pairs, bounds = index_matrix(c, PAIRS), matrix(c, BOUNDS)
    for p in range(len(pairs)):
        a, b = pairs[p, 0], pairs[p, 1]
        speed = speed_of(bounds, p, step, c)
        need = margin + speed * advance
        if not nearer(a, b, need, c):
            continue
        distance = measured(a, b, need, c)
        if distance < margin + min(SLACK, speed * advance):
            return -1.0
        if distance < need:
            advance = (distance - margin) / speed
    return advance


@inner
def point_advance(advance: float, margin: float, step: Array, c: Indices) -> float:
    """The same for the points of clouds."""
    bounds = matrix(c, FEELER_BOUNDS)
    for g in range(indices(c, FEELERS).size):
        speed = speed_of(bounds, g, step, c)
        need = margin + speed * advance
        distance = nearest_point(g, need, c)
        if distance < margin + min(SLACK, speed * advance):
            return -1.0
        if distance < need:
            advance = (distance - margin) / speed
    return advance


@inner
def limit_room(q: Array, c: Indices) -> float:
    """Smallest way of a coordinate to a limit that counts."""
    lower, upper = vector(c, LOWER), vector(c, UPPER)
    room = math.inf
    for k in range(q.size):
        room = min(room, q[k] - lower[k], upper[k] - q[k])
    return room


@njit
def edge(start: Array, end: Array, margin: float, c: Indices) -> float:
    """How far along the straight edge from `start` to `end` (dof,) clearance stays above `margin`: 1 is all the way.

    Conservative advancement: each step is as long as no point of the robot can need to lose the clearance it has.
    What is called clear is clear between the steps too; within `SLACK` of the margin it may be called blocked.
    """
    # Limits hold all along where they hold at both ends.
    if not (finite(start) and finite(end)) or min(limit_room(start, c), limit_room(end, c)) < margin:
        return 0.0
    step = end - start
    q = np.empty(start.size)
    done = 0.0
    for _ in range(MOST):
        for k in range(q.size):
            q[k] = start[k] + done * step[k]
        stand(q, c)
        advance = pair_advance(1.0 - done, margin, step, c)
        if advance >= 0:
            advance = point_advance(advance, margin, step, c)
        if advance < 0:
            return done
        if done + advance >= 1.0:
            return 1.0
        done += advance
    return done


@njit
def edges(starts: Array, ends: Array, margin: float, c: Indices, out: Array) -> None:
    """`edge` for each pair of rows (n, dof)."""
    for i in range(len(starts)):
        out[i] = edge(starts[i], ends[i], margin, c)
