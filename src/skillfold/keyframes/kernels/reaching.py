"""Whether poses can be reached at all: descents without obstacles or constraint."""

import math
from typing import Any

import numpy as np

from skillfold.jit import njit
from skillfold.keyframes.kernels.descent import Problem, descend, is_inside, make_work

Array = np.ndarray[Any, np.dtype[np.float64]]

STEPS = 60  # of one descent
PROGRESS = 0.98  # of the distance left: a descent that closes less in a step is stuck


@njit
def reach(problem: Problem, starts: Array, targets: Array) -> int:
    """Let joint positions (n, D) descend, in place, toward targets (n, 6), until one's pose is inside both goal and constraint.

    Returns which is the first, or -1 where none is.
    """
    work = make_work(starts.shape[1])
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
