"""Whether poses can be reached at all: descents without obstacles or constraint."""

import math
from typing import Any

import numpy as np

from skillfold.jit import njit
from skillfold.keyframes.kernels.descent import descend, is_inside
from skillfold.keyframes.kernels.problem import make_work, problem_at

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

STEPS = 60  # of one descent
PROGRESS = 0.98  # of the distance left: a descent that closes less in a step is stuck


@njit
def reach(table: Indices, starts: Array, targets: Array) -> int:
    """Let joint positions (n, D) descend, in place, toward targets (n, 6), until a pose is in goal and constraint.

    Returns whose is the first, or -1 where none is.
    """
    problem, work = problem_at(table), make_work(starts.shape[1])
    for i in range(len(starts)):
        before = math.inf
        for _ in range(STEPS):
            left = descend(problem, starts[i], targets[i], False, work)
            if is_inside(problem.goal, work.pose) and is_inside(problem.hold, work.pose):
                return i
            if left > PROGRESS * before:
                break
            before = left
    return -1
