"""Straight edges between joint positions: how long they are, and whether they hold the constraint and are clear."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner
from skillfold.keyframes.kernels.descent import tool_pose, turned
from skillfold.keyframes.kernels.problem import FULL, Problem, Work

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

SPAN = 0.06  # radians between the poses of an edge that are looked at, besides those half-way
CLOSER = 8  # parts of a span that is looked at more closely


@inner
def squared_gap(turning: Indices, a: Array, b: Array) -> float:
    """Squared length of the edge from a to b (D,), continuous joints turning the shorter way."""
    s = 0.0
    for k in range(a.size):
        d = b[k] - a[k]
        if turning[k]:
            d = turned(d)
        s += d * d
    return s


@inner
def facing(turning: Indices, a: Array, b: Array, out: Array) -> None:
    """Write b (D,) less full turns, so that the edge from a is straight; `out` may be b."""
    for k in range(a.size):
        out[k] = a[k] + turned(b[k] - a[k]) if turning[k] else b[k]


@inner
def wound(turning: Indices, a: Array, b: Array, out: Array) -> None:
    """Write the full turns (D,) that b (D,) must lose to face a; zeros where it does."""
    for k in range(a.size):
        out[k] = FULL * math.floor((b[k] - a[k]) / FULL + 0.5) if turning[k] else 0.0


@inner
def excess_at(problem: Problem, a: Array, b: Array, share: float, work: Work) -> float:
    """Excess of the pose at a share of the way from a to b (D,)."""
    for k in range(a.size):
        work.state[k] = a[k] + share * (b[k] - a[k])
    tool_pose(problem.tool, work.state, work.passing)
    return problem.hold.excess(work.passing, problem.hold.arguments)


@inner
def stays_inside(problem: Problem, a: Array, b: Array, work: Work) -> bool:
    """Whether the poses of the straight edge from a to b (D,) hold the constraint; a's does.

    Spans are looked at in their middles and at their ends, and more closely where the excess, as far as it bends
    there, could rise above the level between.
    """
    level = problem.hold.level
    spans = int(math.sqrt(squared_gap(problem.turning, a, b)) / SPAN) + 1
    first = excess_at(problem, a, b, 0.0, work)
    for i in range(spans):
        middle = excess_at(problem, a, b, (i + 0.5) / spans, work)
        last = excess_at(problem, a, b, (i + 1.0) / spans, work)
        highest = max(middle, last)
        if highest > level:
            return False
        if max(first, highest) + abs(first - 2.0 * middle + last) > level:
            for j in range(1, CLOSER):
                if excess_at(problem, a, b, (i + j / CLOSER) / spans, work) > level:
                    return False
        first = last
    return True


@inner
def is_clear(problem: Problem, q: Array) -> bool:
    """Whether joint positions q (D,) keep the margin."""
    return problem.clearance(q, q[:0], problem.arguments) > problem.margin


@inner
def seems_to_hold(problem: Problem, a: Array, b: Array, work: Work) -> bool:
    """Whether the edge from a to b (D,), both clear, is inside, and clear half-way."""
    end, middle = work.end, work.state
    facing(problem.turning, a, b, end)
    for k in range(a.size):
        middle[k] = 0.5 * (a[k] + end[k])
    return is_clear(problem, middle) and stays_inside(problem, a, end, work)


@inner
def edge_is_clear(problem: Problem, a: Array, b: Array, work: Work) -> bool:
    """Whether the edge from a to b (D,) is clear all along."""
    facing(problem.turning, a, b, work.end)
    return problem.edge(a, work.end, problem.margin, problem.arguments) >= 1.0
