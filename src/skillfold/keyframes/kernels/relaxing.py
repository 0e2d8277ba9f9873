"""Places of a path moved a little where that makes it shorter: what straight shortcuts cannot do along a border."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner, njit
from skillfold.keyframes.kernels.descent import is_inside, tool_pose
from skillfold.keyframes.kernels.edges import edge_is_clear, is_clear, seems_to_hold
from skillfold.keyframes.kernels.problem import Problem, Work, make_work, problem_at
from skillfold.keyframes.kernels.shortcuts import step_length

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

WORTH = 1e-5  # radians that a move must gain


@inner
def gap_to(path: Array, i: int, q: Array) -> float:
    """Length of the edge from row i to q (D,)."""
    s = 0.0
    for k in range(q.size):
        s += (path[i, k] - q[k]) ** 2
    return math.sqrt(s)


@inner
def propose(path: Array, i: int, last: bool, pull: float, move: Array, out: Array) -> None:
    """Row i moved toward the middle of its neighbours, the last row toward the one before, and by `move` (D,)."""
    other = i - 1 if last else i + 1
    for k in range(out.size):
        middle = 0.5 * (path[i - 1, k] + path[other, k])
        out[k] = path[i, k] + pull * (middle - path[i, k]) + move[k]


@inner
def holds_at(problem: Problem, q: Array, last: bool, work: Work) -> bool:
    """Whether joint positions q (D,) are within limits, inside and clear, and in the goal where they are the last."""
    for k in range(q.size):
        if not problem.turning[k] and not problem.lower[k] <= q[k] <= problem.upper[k]:
            return False
    tool_pose(problem.tool, q, work.pose)
    if last and not is_inside(problem.goal, work.pose):
        return False
    return is_inside(problem.hold, work.pose) and is_clear(problem, q)


@inner
def edges_hold(problem: Problem, path: Array, i: int, last: bool, q: Array, work: Work) -> bool:
    """Whether the edges of row i hold with q (D,) in its place."""
    if not seems_to_hold(problem, path[i - 1], q, work):
        return False
    if not last and not seems_to_hold(problem, q, path[i + 1], work):
        return False
    return edge_is_clear(problem, path[i - 1], q, work) and (last or edge_is_clear(problem, q, path[i + 1], work))


@njit
def relax(table: Indices, path: Array, count: int, picks: Array, pulls: Array, moves: Array, free: bool) -> float:
    """Move places of a path, its first `count` rows, in place; the length that it lost [rad].

    Args:
        table: of the problem.
        path: rows that face each other; the first stays.
        count: of them.
        picks: (r,) in [0, 1), which row is moved.
        pulls: (r,) share of the way toward the middle of its neighbours.
        moves: (r, D) and aside [rad].
        free: whether the last row may move within the goal.
    """
    problem, work, gained = problem_at(table), make_work(path.shape[1]), 0.0
    movable = count - 1 if free else count - 2
    for r in range(len(picks) if movable > 0 else 0):
        i = 1 + int(picks[r] * movable)
        last = i == count - 1
        propose(path, i, last, pulls[r], moves[r], work.q)
        gain = step_length(path, i - 1) - gap_to(path, i - 1, work.q)
        if not last:
            gain += step_length(path, i) - gap_to(path, i + 1, work.q)
        if gain < WORTH or not holds_at(problem, work.q, last, work):
            continue
        if edges_hold(problem, path, i, last, work.q, work):
            for k in range(work.q.size):
                path[i, k] = work.q[k]
            gained += gain
    return gained


@njit
def approach(table: Indices, origin: Array, states: Array, pulls: Array, moves: Array) -> None:
    """Move joint positions (n, D) in the goal nearer to an origin (D,), in place, as far as they stay clear in it.

    Args:
        table: of the problem.
        origin: such as the start: what ends far from it costs at least as much.
        states: within half a turn of the origin where joints are continuous.
        pulls: (r,) share of the way to the origin.
        moves: (r, D) and aside [rad], both tried on each of the states.
    """
    problem, work = problem_at(table), make_work(origin.size)
    for i in range(len(states)):
        for r in range(len(pulls)):
            before, after = 0.0, 0.0
            for k in range(origin.size):
                way = origin[k] - states[i, k]
                work.q[k] = states[i, k] + pulls[r] * way + moves[r, k]
                before += way * way
                after += (origin[k] - work.q[k]) ** 2
            if after < before and holds_at(problem, work.q, True, work):
                for k in range(origin.size):
                    states[i, k] = work.q[k]
