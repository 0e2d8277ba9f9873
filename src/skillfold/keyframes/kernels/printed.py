"""Algorithms 3 and 4 as printed, with what it takes to run: what the mended ones are compared with.

Kept are random starts in [0, 2π], the test of p_s, which only exists on paper, in place of the robot's pose, e1 + e2,
the plain pseudo-inverse, and costs of descendants that stay as they were. Added are an end to descents, the offset of
line 17 in eq. 3b, a running least cost in line 9 of algorithm 4, a cap on Near, and edges that are followed safely.
One covariance, the child's, sets the step size of eq. 6, in which all others would only change its length.
"""

import math
from typing import Any

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.kernels.charts import to_flat, to_full
from skillfold.keyframes.kernels.descent import along_axis, face, is_inside, solve_damped, tool_pose, twist
from skillfold.keyframes.kernels.edges import edge_is_clear, facing, squared_gap
from skillfold.keyframes.kernels.nodes import Tree, has_room, near_radius, nearest, put, tree_at, whitened
from skillfold.keyframes.kernels.problem import Problem, Work, make_work, problem_at
from skillfold.planning.tree import hang, unhang

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

STEPS = 200  # of one descent at most
HALVINGS = 10  # N: of the first step, if it leads away from the target
ARRIVED = 0.01  # metres: p_s is projected on p_sRef
ROUNDING = 1e-10  # of the damping: what keeps the pseudo-inverse finite


@inner
def whole_step(axis: Array, y: Array, target: Array, out: Array) -> None:
    """Both differences of eq. 4 (6,), without eq. 2's factor: to the target, and to the axis with its offset."""
    dot, square = 0.0, 0.0
    for c in range(6):
        weight = 1.0 if c < 3 else LENGTH * LENGTH
        way = axis[1, c] - axis[0, c]
        dot += weight * way * (target[c] - axis[0, c])
        square += weight * way * way
    # The target's place is not kept within the axis, the pose's is (Gauss_Lin_Interpol).
    there = dot / max(square, 1e-300)
    here = along_axis(axis, y)
    for c in range(6):
        ahead = target[c] - y[c]
        out[c] = 2.0 * ahead + (here - there) * (axis[1, c] - axis[0, c])


@inner
def white_length(problem: Problem, a: Array, b: Array) -> float:
    """Mahalanobis distance between chart coordinates (6,), in gates of the child."""
    total = 0.0
    for i in range(6):
        s = 0.0
        for c in range(6):
            s += problem.metric[i, c] * (b[c] - a[c])
        total += s * s
    return math.sqrt(total)


@inner
def step_size(problem: Problem, y: Array, target: Array, step: Array, aside: Array) -> float:
    """δ_n of eq. 6, halved until the first step leads toward the target; 0 where it never does."""
    for c in range(6):
        aside[c] = y[c] + step[c] - (target[c] - y[c])
    goal, line = white_length(problem, y, target), white_length(problem, y, aside)
    size = 1.0 / max(math.sqrt(goal * goal + line * line), 1e-300)
    for _ in range(HALVINGS):
        for c in range(6):
            aside[c] = y[c] + size * step[c]
        if white_length(problem, aside, target) <= goal:
            return size
        size *= 0.5
    return 0.0


@inner
def off_by(y: Array, target: Array) -> float:
    """Distance [m] between chart coordinates (6,)."""
    s = 0.0
    for c in range(6):
        s += (1.0 if c < 3 else LENGTH * LENGTH) * (target[c] - y[c]) ** 2
    return math.sqrt(s)


@inner
def move_by_both(problem: Problem, q: Array, y: Array, onward: Array, work: Work) -> None:
    """Lines 22 to 27: q (D,) moves by J⁺(e1 + e2), from p_s (chart y) to its next (chart onward); `work` faces q."""
    to_full(y, problem.middle, work.passing)
    to_full(onward, problem.middle, work.wanted)
    twist(work.passing, work.wanted, work.other)
    twist(work.pose, work.wanted, work.step)
    for c in range(6):
        work.step[c] += work.other[c]
    solve_damped(work.jacobian, work.square, work.step, ROUNDING)
    for k in range(q.size):
        for i in range(6):
            q[k] += work.jacobian[i, k] * work.step[i]


@inner
def extend_printed(problem: Problem, tree: Tree, q: Array, y: Array, work: Work, white: Array) -> int:
    """Algorithm 4: steer from the node whose pose is nearest to y (6,) toward q (D,); the new node, or -1."""
    if not has_room(tree):
        return -1
    whitened(problem, y, white)
    near = nearest(tree, white)
    facing(problem.turning, tree.q[near], q, work.q)
    share = min(1.0, problem.reach / max(math.sqrt(squared_gap(problem.turning, tree.q[near], q)), 1e-300))
    for k in range(q.size):
        work.q[k] = tree.q[near, k] + share * (work.q[k] - tree.q[near, k])
    if not edge_is_clear(problem, tree.q[near], work.q, work):
        return -1
    tool_pose(problem.tool, work.q, work.pose)
    node = put(problem, tree, work.q, work)
    parent, square = near, near_radius(node, q.size)
    cost = tree.costs[near] + math.sqrt(squared_gap(problem.turning, tree.q[near], work.q))
    for i in range(node):
        tree.squares[i] = squared_gap(problem.turning, tree.q[i], work.q)
        through = tree.costs[i] + math.sqrt(tree.squares[i])
        if tree.squares[i] < square and through < cost and edge_is_clear(problem, tree.q[i], work.q, work):
            parent, cost = i, through
    tree.costs[node] = cost
    hang(tree.parents, tree.children, tree.siblings, node, parent)
    rewire_printed(problem, tree, node, square, work)
    return node


@inlined
def rewire_printed(problem: Problem, tree: Tree, node: int, square: float, work: Work) -> None:
    """Lines 15 to 21: costs of what hangs on rewired nodes stay as they were."""
    for i in range(1, node):
        cost = tree.costs[node] + math.sqrt(tree.squares[i])
        if not tree.squares[i] < square or i == tree.parents[node] or cost >= tree.costs[i] or above(tree, i, node):
            continue
        if edge_is_clear(problem, tree.q[node], tree.q[i], work):
            unhang(tree.parents, tree.children, tree.siblings, i)
            hang(tree.parents, tree.children, tree.siblings, i, node)
            tree.costs[i] = cost


@inner
def above(tree: Tree, node: int, below: int) -> bool:
    """Whether a node lies on another's way to the root: stale costs would close a circle there."""
    while below >= 0:
        if below == node:
            return True
        below = tree.parents[below]
    return False


@njit
def grow_printed(table: Indices, nodes: Indices, targets: Array, starts: Array) -> int:
    """Algorithm 3 for targets (T, 6) and random joint positions (T, D), overwritten, until a node is in the goal.

    Returns how many targets were used.
    """
    problem, tree = problem_at(table), tree_at(nodes)
    work, white, y, onward = make_work(starts.shape[1]), np.empty(6), np.empty(6), np.empty(6)
    for t in range(len(targets)):
        q, target, size = starts[t], targets[t], -1.0
        tool_pose(problem.tool, q, work.pose)
        to_flat(work.pose, problem.middle, y)
        for _ in range(STEPS):
            to_full(y, problem.middle, work.passing)
            arrived = off_by(y, target) < ARRIVED
            if arrived or is_inside(problem.hold, work.passing):
                node = extend_printed(problem, tree, q, y, work, white)
                if not has_room(tree) or (node >= 0 and tree.goals[node] == 1):
                    return t + 1
            if arrived:
                break
            whole_step(problem.axis, y, target, work.flat)
            if size < 0.0:
                size = step_size(problem, y, target, work.flat, onward)
            if size == 0.0:
                break
            for c in range(6):
                onward[c] = y[c] + size * work.flat[c]
            face(problem, q, work)
            move_by_both(problem, q, y, onward, work)
            for c in range(6):
                y[c] = onward[c]
    return len(targets)
