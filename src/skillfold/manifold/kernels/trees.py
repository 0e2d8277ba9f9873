"""Two trees on the surface that grow toward each other until they meet: RRT-Connect with tangent steps."""

from typing import Any

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.manifold.kernels.projection import gap
from skillfold.manifold.kernels.scratch import make_scratch
from skillfold.manifold.kernels.small import copy
from skillfold.manifold.kernels.walking import Chart, Support, edge_is_clear, walk
from skillfold.planning.barrier import Barrier
from skillfold.planning.tree import branch, nearest_node

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

LOST = -2  # parent of a node that hangs on a blocked edge
LOCAL = 2.5  # steps: how far nodes look that were blocked before


@njit
def search(
    t: Indices,
    support: Support,
    chart: Chart,
    barrier: Barrier,
    ends: Array,
    targets: Array,
    picks: Array,
    step: float,
    margin: float,
    path: Array,
    count: int,
) -> tuple:
    """A clear way between ends (2, D) into `path` (limit, D): connected where `count` is 0, then shortened.

    Two questions in one function, so that what they share is compiled once. Returns the number of states, 0 where
    there is no way, and how many targets were used.
    """
    used = 0
    if count == 0:
        count, used = connect(t, support, chart, barrier, ends, targets, step, margin, path)
    if count > 0:
        count = shorten(t, support, chart, barrier, path, count, picks, step, margin)
    return count, used


@inlined
def connect(
    t: Indices,
    support: Support,
    chart: Chart,
    barrier: Barrier,
    ends: Array,
    targets: Array,
    step: float,
    margin: float,
    path: Array,
) -> tuple:
    """A clear way on the surface from ends[0] to ends[1] (2, D) into `path` (limit, D).

    Args:
        t: table of the model.
        support, chart, barrier: where it is believed, and what is in the way.
        ends: start and goal, on the surface.
        targets: (T, D) states toward which trees grow, in turn.
        step: between nodes.
        margin: clearance that edges keep.
        path: a tree holds half as many nodes as it has rows.

    Returns:
        The number of path states, 0 where the trees did not meet; and targets used.
    """
    D, limit = ends.shape[1], len(path) // 2
    states, parents, counts = np.empty((2, limit, D)), np.empty((2, limit), np.int64), np.ones(2, np.int64)
    stuck, work, aside = np.zeros((2, limit), np.bool_), np.empty((2, D)), np.empty(D)
    for side in range(2):
        copy(ends[side], states[side, 0])
        parents[side, 0] = -1
    for turn in range(len(targets)):
        side = turn % 2
        # The first two turns try the straight way.
        target = ends[1 - side] if turn < 2 else targets[turn]
        near = nearest_node(states[side], counts[side], target)
        if stuck[side, near] and turn > 0:
            look_aside(states[side, near], targets[turn], targets[turn - 1], LOCAL * step, aside)
            target = aside
        newest = extend(t, support, chart, barrier, states, parents, counts, side, target, step, margin)
        if newest < 0:
            stuck[side, near] = True
            continue
        tip, other = states[side, newest], 1 - side
        last = extend(t, support, chart, barrier, states, parents, counts, other, tip, step, margin)
        if last < 0:
            last = nearest_node(states[other], counts[other], tip)
        if gap(states[other, last], tip) > step * step * (1.0 + 1e-9):
            continue
        if not edge_is_clear(chart, barrier, states[other, last], tip, margin, work):
            stuck[other, last] = True
            continue
        whole = True
        for tree in range(2):
            node = newest if tree == side else last
            whole = (
                cut_blocked(chart, barrier, states[tree], parents[tree], counts[tree], node, margin, work) and whole
            )
        if whole:
            left, right = (newest, last) if side == 0 else (last, newest)
            return joined(states, parents, left, right, path), turn + 1
    return 0, len(targets)


@inner
def cut_blocked(
    chart: Chart,
    barrier: Barrier,
    states: Array,
    parents: Indices,
    count: int,
    node: int,
    margin: float,
    work: Array,
) -> bool:
    """Whether the way from a node to the root is clear; at an edge that is not, the tree loses what hangs on it.

    Trees grow over states that seem clear, and only a way that joins them has its edges looked at: most never do.
    """
    blocked = -1
    while parents[node] >= 0:
        if not edge_is_clear(chart, barrier, states[parents[node]], states[node], margin, work):
            blocked = node
        node = parents[node]
    if blocked < 0:
        return True
    # Nodes come after their parents. Those that are lost go where no target is near.
    parents[blocked] = LOST
    for i in range(blocked, count):
        if parents[i] == LOST or (parents[i] >= 0 and parents[parents[i]] == LOST):
            parents[i] = LOST
            states[i] = np.inf
    return False


@inlined
def look_aside(node: Array, one: Array, other: Array, far: float, out: Array) -> None:
    """A target `far` from a node in the direction between two random ones, into `out` (D,).

    What lies beyond an obstacle draws the nodes nearest to it, which it blocks, again and again: these look around.
    """
    length = max(np.sqrt(gap(one, other)), 1e-300)
    for c in range(node.size):
        out[c] = node[c] + far / length * (one[c] - other[c])


@inner
def extend(
    t: Indices,
    support: Support,
    chart: Chart,
    barrier: Barrier,
    states: Array,
    parents: Indices,
    counts: Indices,
    side: int,
    target: Array,
    step: float,
    margin: float,
) -> int:
    """Grow one tree from its node nearest to the target as far as the way is clear; the last new node, or -1."""
    count = counts[side]
    scratch = make_scratch(t, 1)
    near = nearest_node(states[side], count, target)
    free = states[side, count:]
    added, _ = walk(support, chart, barrier, states[side, near], target, step, margin, free, scratch)
    for i in range(added):
        parents[side, count + i] = near if i == 0 else count + i - 1
    counts[side] = count + added
    return count + added - 1 if added else -1


@inlined
def joined(states: Array, parents: Indices, left: int, right: int, path: Array) -> int:
    """The way from the first tree's root over node `left` and over `right` to the second's; the number of states."""
    nodes = np.empty(states.shape[1], np.int64)
    count = branch(parents[0], left, nodes)
    for i in range(count):
        copy(states[0, nodes[count - 1 - i]], path[i])
    more = branch(parents[1], right, nodes)
    for i in range(more):
        copy(states[1, nodes[i]], path[count + i])
    return count + more


@inlined
def shorten(
    t: Indices,
    support: Support,
    chart: Chart,
    barrier: Barrier,
    path: Array,
    count: int,
    picks: Array,
    step: float,
    margin: float,
) -> int:
    """Shortcuts between random states of a path, its first `count` rows, in place; the number of states left.

    Each pair of `picks` (r, 2) in [0, 1) names two places by their share of the states; where a straight walk between
    them is clear and shorter, it takes the place of what lies between.
    """
    D = path.shape[1]
    scratch, work, found = make_scratch(t, 1), np.empty((2, D)), np.empty(path.shape)
    for r in range(len(picks)):
        i, j = int(picks[r, 0] * count), int(picks[r, 1] * count)
        i, j = min(i, j), max(i, j)
        if j - i < 2:
            continue
        # A walk has no more states than what it replaces, or it is no shortcut.
        room = found[: j - i - 1]
        more, arrived = walk(support, chart, barrier, path[i], path[j], step, margin, room, scratch)
        last = path[i] if more == 0 else found[more - 1]
        shorter = way(found[:more], path[i], path[j]) < 0.999 * way(path[i + 1 : j], path[i], path[j])
        clear = arrived and shorter and edge_is_clear(chart, barrier, last, path[j], margin, work)
        for k in range(more):
            clear = clear and edge_is_clear(
                chart, barrier, path[i] if k == 0 else found[k - 1], found[k], margin, work
            )
        if not clear:
            continue
        for k in range(more):
            copy(found[k], path[i + 1 + k])
        for k in range(j, count):
            copy(path[k], path[i + 1 + more + k - j])
        count -= j - i - 1 - more
    return count


@inner
def way(between: Array, start: Array, end: Array) -> float:
    """Length of the way from start over the states between to the end."""
    total, last = 0.0, start
    for i in range(len(between)):
        total += np.sqrt(gap(last, between[i]))
        last = between[i]
    return total + np.sqrt(gap(last, end))
