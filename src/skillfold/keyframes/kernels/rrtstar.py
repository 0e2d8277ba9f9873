"""PCTC-RRT*: a tree in joint space whose poses stay inside (algorithms 3 and 4), mended.

Most targets are approached from the tree's own node that is nearest in the workspace; the others by descent from
random joint positions, which are then joined to the tree where that is nearest in joint space.
"""

import math
from typing import Any

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.keyframes.kernels.descent import descend, is_inside, tool_pose
from skillfold.keyframes.kernels.edges import edge_is_clear, facing, is_clear, seems_to_hold, squared_gap
from skillfold.keyframes.kernels.nodes import (
    Tree,
    add,
    forget,
    has_room,
    nearest,
    put,
    settle,
    tree_at,
    whitened,
)
from skillfold.keyframes.kernels.problem import Problem, Work, make_work, problem_at
from skillfold.planning.tree import branch, cut

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

STEPS = 40  # of one descent
ARRIVED = 0.01  # metres: a target is reached
PROGRESS = 0.98  # of the distance left: a descent that closes less in a step is stuck
LEAST = 0.02  # radians: a shorter edge is not worth a node
FROM_TREE, FROM_START, FROM_FAR, JOIN, END = range(5)  # how a target is used
REFUSED = 2.0  # times as heavy: a node that could not be extended
SAME = 1e-18  # square radians between joint positions that are the same


@inner
def try_add(problem: Problem, tree: Tree, near: int, q: Array, star: bool, work: Work) -> int:
    """A new node at q (D,), whose pose is `work.pose`; -1 where there is no way from `near`, or no room.

    It hangs on node `near`, or where `star` is set on the best of those near.
    """
    if not has_room(tree) or not is_inside(problem.hold, work.pose) or not is_clear(problem, q):
        return -1
    if not seems_to_hold(problem, tree.q[near], q, work):
        return -1
    node = add(problem, tree, near, q, work)
    if star:
        settle(problem, tree, node, work)
    return node


@inlined
def extend(problem: Problem, tree: Tree, near: int, target: Array, star: bool, work: Work) -> int:
    """Grow from a node toward a target (6,) as far as poses are inside and edges hold; the last new node, or -1."""
    q, last, newest, before = work.q, near, -1, math.inf
    for k in range(q.size):
        q[k] = tree.q[near, k]
    for _ in range(STEPS):
        left = descend(problem, q, target, True, work)
        done = left < ARRIVED or left > PROGRESS * before
        before = left
        square = squared_gap(problem.turning, tree.q[last], q)
        if square < LEAST**2 or (not done and square < 0.25 * problem.reach**2):
            if done:
                break
            continue
        node = try_add(problem, tree, last, q, star, work)
        if node < 0:
            break
        last = newest = node
        if done or tree.goals[node]:
            break
    return newest


@inlined
def connect(problem: Problem, tree: Tree, q: Array, star: bool, work: Work) -> int:
    """Grow straight toward joint positions q (D,) from the node that is nearest to them; the last new node, or -1."""
    last, newest, least, way = 0, -1, math.inf, work.q
    for i in range(tree.size[0]):
        square = squared_gap(problem.turning, tree.q[i], q)
        if square < least:
            last, least = i, square
    facing(problem.turning, tree.q[last], q, q)
    for i in range(int(math.sqrt(least) / problem.reach) + 1, 0, -1):
        for k in range(q.size):
            way[k] = tree.q[last, k] + (q[k] - tree.q[last, k]) / i
        tool_pose(problem.tool, way, work.pose)
        node = try_add(problem, tree, last, way, star, work)
        if node < 0:
            break
        last = newest = node
        if tree.goals[node]:
            break
    return newest


@inlined
def get_inside(problem: Problem, q: Array, target: Array, goal: bool, work: Work) -> bool:
    """Let joint positions q (D,) descend toward a target (6,) until their pose is inside; whether it is.

    Where the target is one of the goal, until it is in the goal, too: where much is inside, a way there is not found
    by poses inside alone, for most postures of the goal are far from those nearby in the workspace.
    """
    before = math.inf
    for _ in range(STEPS):
        left = descend(problem, q, target, False, work)
        if is_inside(problem.hold, work.pose) and not (goal and not is_inside(problem.goal, work.pose)):
            return True
        if left > PROGRESS * before:
            return False
        before = left
    return False


@njit
def plant(table: Indices, nodes: Indices, q: Array) -> None:
    """Make joint positions q (D,) the root of an empty tree."""
    problem, tree, work = problem_at(table), tree_at(nodes), make_work(q.size)
    tree.size[0] = 0
    tool_pose(problem.tool, q, work.pose)
    put(problem, tree, q, work)


@njit
def grow(
    table: Indices, nodes: Indices, targets: Array, kinds: Indices, froms: Indices, starts: Array, first: bool
) -> int:
    """Grow a tree by a batch of targets; how many were used: fewer where the tree is full or a first goal is found.

    Args:
        table: of the problem.
        nodes: table of a tree that has a root.
        targets: (T, 6) chart coordinates.
        kinds: (T,) how each is used: `FROM_TREE`, `FROM_START`, `FROM_FAR` for those of the goal; `JOIN` and `END`
            take starts as they are, and `END` is a goal.
        froms: (T,) nodes that `FROM_TREE` starts from; -1 is the nearest.
        starts: (T, D) random joint positions, overwritten.
        first: whether to stop at the first node in the goal. Nodes then hang where they were grown from: to choose
            parents and to rewire takes half the time of a first way, and shortcuts do as much for it.
    """
    problem, tree = problem_at(table), tree_at(nodes)
    work, white = make_work(starts.shape[1]), np.empty(6)
    for t in range(len(targets)):
        if not has_room(tree):
            return t
        newest = -1
        if kinds[t] == FROM_TREE:
            whitened(problem, targets[t], white)
            near = froms[t] if froms[t] >= 0 else nearest(tree, white)
            newest = extend(problem, tree, near, targets[t], not first, work)
            if newest < 0 and froms[t] < 0:
                tree.weights[near] *= REFUSED
        elif kinds[t] >= JOIN or get_inside(problem, starts[t], targets[t], kinds[t] == FROM_FAR, work):
            newest = connect(problem, tree, starts[t], not first, work)
            if kinds[t] == END and newest >= 0 and squared_gap(problem.turning, tree.q[newest], starts[t]) < SAME:
                tree.goals[newest] = 1
        if first and newest >= 0 and tree.goals[newest]:
            return t + 1
    return len(targets)


@njit
def prove(table: Indices, nodes: Indices, goal: int) -> bool:
    """Whether the way to a node is clear all along; at an edge that is not, the tree loses what hangs on it."""
    problem, tree = problem_at(table), tree_at(nodes)
    work, way = make_work(tree.q.shape[1]), np.empty(tree.size[0], np.int64)
    for i in range(branch(tree.parents, goal, way) - 2, -1, -1):
        node = way[i]
        if tree.proven[node]:
            continue
        if not edge_is_clear(problem, tree.q[tree.parents[node]], tree.q[node], work):
            cut(tree.parents, tree.children, tree.siblings, tree.costs, node)
            forget(tree)
            return False
        tree.proven[node] = 1
    return True
