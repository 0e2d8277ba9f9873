"""A tree of states in arrays, for samplers: compiled functions on them."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

LOST = -2  # parent of a node that was taken out


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


@inner
def hang(parents: Indices, children: Indices, siblings: Indices, node: int, parent: int) -> None:
    """Make `node` the first child of `parent`.

    `children` holds the first child of each node, `siblings` the next child of its parent; -1 is none.
    """
    parents[node] = parent
    siblings[node] = children[parent]
    children[parent] = node


@inner
def unhang(parents: Indices, children: Indices, siblings: Indices, node: int) -> None:
    """Take `node` from among the children of its parent."""
    at = children[parents[node]]
    if at == node:
        children[parents[node]] = siblings[node]
        return
    while siblings[at] != node:
        at = siblings[at]
    siblings[at] = siblings[node]


@inner
def lower_costs(
    parents: Indices, children: Indices, siblings: Indices, costs: Array, top: int, saving: float
) -> None:
    """Take `saving` off the cost of `top` and of all that hangs on it."""
    node = top
    while True:
        costs[node] -= saving
        if children[node] >= 0:
            node = children[node]
            continue
        while node != top and siblings[node] < 0:
            node = parents[node]
        if node == top:
            return
        node = siblings[node]


@inner
def cut(parents: Indices, children: Indices, siblings: Indices, costs: Array, top: int) -> None:
    """Take `top` and all that hangs on it out of the tree: their parent becomes `LOST`, their cost infinite."""
    unhang(parents, children, siblings, top)
    siblings[top] = -1
    node = top
    while True:
        costs[node] = math.inf
        if children[node] >= 0:
            node = children[node]
            continue
        while node != top and siblings[node] < 0:
            above = parents[node]
            parents[node] = LOST
            node = above
        if node == top:
            parents[top] = LOST
            return
        above = siblings[node]
        parents[node] = LOST
        node = above
