"""The worst places of a path, in one compiled loop: the check looks for them in every plan."""

import math
from typing import Any

import numpy as np

from skillfold.jit import njit

Array = np.ndarray[Any, np.dtype[np.float64]]


@njit
def worst_places(over: Array, outside: Array, states: Array) -> tuple:
    """Where values (m,) and (m,) are largest, and of a path (n, D) where its longest step starts.

    Returns these three places, the length of that step, and of the path. What is no number counts as the largest.
    """
    a, b, c, longest, length = 0, 0, 0, 0.0, 0.0
    for i in range(1, over.size):
        if over[i] > over[a] or math.isnan(over[i]):
            a = i
        if outside[i] > outside[b] or math.isnan(outside[i]):
            b = i
    for i in range(1, len(states)):
        square = 0.0
        for k in range(states.shape[1]):
            square += (states[i, k] - states[i - 1, k]) ** 2
        step = math.sqrt(square)
        length += step
        if step > longest:
            longest, c = step, i - 1
    return a, b, c, longest, length
