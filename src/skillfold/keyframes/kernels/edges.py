"""Straight edges between joint positions: how long they are, and whether they hold the constraint and are clear."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner, njit
from skillfold.keyframes.kernels.descent import FULL, Problem, Work, is_inside, make_work, tool_pose, turned

Array = np.ndarray[Any, np.dtype[np.float64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

SPACING = 0.01  # radians between the poses of an edge that are looked at


@inner
def squared_gap(turning: Flags, a: Array, b: Array) -> float:
    """Squared length of the edge from a to b (D,), continuous joints turning the shorter way."""
    s = 0.0
    for k in range(a.size):
        d = b[k] - a[k]
        if turning[k]:
            d = turned(d)
        s += d * d
    return s


@inner
def facing(turning: Flags, a: Array, b: Array, out: Array) -> None:
    """b (D,) less full turns, so that the edge from a is straight; `out` may be b."""
    for k in range(a.size):
        out[k] = a[k] + turned(b[k] - a[k]) if turning[k] else b[k]


@inner
def stays_inside(problem: Problem, a: Array, b: Array, work: Work) -> bool:
    """Whether the poses of the straight edge from a to b (D,) hold the constraint, b's too."""
    length = math.sqrt(squared_gap(problem.turning, a, b))
    count = int(length / SPACING) + 1
    for i in range(1, count + 1):
        for k in range(a.size):
            work.state[k] = a[k] + i / count * (b[k] - a[k])
        tool_pose(problem.tool, work.state, work.passing)
        if not is_inside(problem.hold, work.passing):
            return False
    return True


@inner
def edge_holds(problem: Problem, a: Array, b: Array, work: Work) -> bool:
    """Whether the edge from a to b (D,) is clear and inside; `work.end` is then b, facing a."""
    facing(problem.turning, a, b, work.end)
    if problem.edge(a, work.end, problem.margin, problem.arguments) < 1.0:
        return False
    return stays_inside(problem, a, work.end, work)
