"""A tree of states in arrays, for samplers: compiled functions on them."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]


@inner
def nearest_node(states: Array, count: int, target: Array) -> int:
    """Which of the first `count` states (…, D) is nearest to the target (D,)."""
    best, least = 0, math.inf
    for i in range(count):
        s = 0.0
        for c in range(target.size):
            s += (states[i, c] - target[c]) ** 2
        if s < least:
            best, least = i, s
    return best


@inner
def branch(parents: Indices, node: int, out: Indices) -> int:
    """The nodes from `node` to the root, whose parent is -1, into `out`; how many."""
    count = 0
    while node >= 0:
        out[count] = node
        node = parents[node]
        count += 1
    return count
