"""PCTC-RRT*: a tree in joint space whose poses stay inside (algorithms 3 and 4), mended.

Most targets are approached from the tree's own node that is nearest in the workspace; the others by descent from
random joint positions, which are then joined to the tree where that is nearest in joint space.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.keyframes.kernels.charts import to_flat
from skillfold.keyframes.kernels.descent import descend, is_inside, tool_pose
from skillfold.keyframes.kernels.edges import edge_is_clear, facing, is_clear, seems_to_hold, squared_gap
from skillfold.keyframes.kernels.problem import Problem, Work, make_work, problem_at
from skillfold.planning.tree import LOST, branch, cut, hang, lower_costs, unhang
from skillfold.tables import indices, matrix, vector

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

STEPS = 40  # of one descent
ARRIVED = 0.01  # metres: a target is reached
PROGRESS = 0.98  # of the distance left: a descent that closes less in a step is stuck
WIDEST, FACTOR = 0.8, 1.5  # radians: radius of Near at most, and its γ
LEAST = 0.02  # radians: a shorter edge is not worth a node
FROM_TREE, FROM_START, JOIN, END = range(4)  # how a target is used
REFUSED = 2.0  # times as heavy: a node that could not be extended
SAME = 1e-18  # square radians between joint positions that are the same
TRIES = 4  # edges looked at for a better parent


class Tree(NamedTuple):
    """Nodes in joint space with their poses (the paper's Q_q, Q_p and Q_sol), for `limit` nodes.

    Attributes:
        q: (limit, D) joint positions.
        z: (limit, 6) whitened chart coordinates of the poses.
        costs: (limit,) lengths of the ways from the root.
        parents, children, siblings: (limit,) see `skillfold.planning.tree`.
        goals: (limit,) 1 where the pose lies inside the goal.
        size: (1,) how many nodes there are, lost ones too.
        proven: (limit,) 1 where the edge from the parent is known to be clear.
        weights: (limit,) of squared distances: nodes that could not be extended seem farther off.
        squares: (limit,) scratch.
    """

    q: Array
    z: Array
    costs: Array
    parents: Indices
    children: Indices
    siblings: Indices
    goals: Indices
    size: Indices
    proven: Indices
    weights: Array
    squares: Array


@inner
def tree_at(nodes: Indices) -> Tree:
    """The tree that a table describes; its slots are the attributes in their order."""
    return Tree(
        matrix(nodes, 0),
        matrix(nodes, 1),
        vector(nodes, 2),
        indices(nodes, 3),
        indices(nodes, 4),
        indices(nodes, 5),
        indices(nodes, 6),
        indices(nodes, 7),
        indices(nodes, 8),
        vector(nodes, 9),
        vector(nodes, 10),
    )


@inner
def whitened(problem: Problem, y: Array, out: Array) -> None:
    """Chart coordinates y (6,) in which the nearest node is looked for, into `out`."""
    for i in range(6):
        s = 0.0
        for c in range(6):
            s += problem.metric[i, c] * y[c]
        out[i] = s


@inner
def put(problem: Problem, tree: Tree, q: Array, work: Work) -> int:
    """Write a node that hangs nowhere yet: joint positions q (D,), pose `work.pose`; its number."""
    node = tree.size[0]
    for k in range(q.size):
        tree.q[node, k] = q[k]
    to_flat(work.pose, problem.middle, work.other)
    whitened(problem, work.other, tree.z[node])
    tree.goals[node] = 1 if is_inside(problem.goal, work.pose) else 0
    tree.costs[node], tree.weights[node], tree.proven[node] = 0.0, 1.0, 0
    tree.parents[node] = tree.children[node] = tree.siblings[node] = -1
    tree.size[0] = node + 1
    return node


@inner
def near_radius(count: int, dof: int) -> float:
    """Squared radius of Near among `count` nodes."""
    n = max(count, 2)
    return min(FACTOR * (math.log(n) / n) ** (1.0 / dof), WIDEST) ** 2


@inner
def choose_parent(problem: Problem, tree: Tree, node: int, near: int, square: float, work: Work) -> None:
    """Hang a node where its cost is least among those near; the edge to `near` is known to hold.

    Squared lengths of edges from all nodes are left in `tree.squares`.
    """
    best = math.sqrt(squared_gap(problem.turning, tree.q[near], tree.q[node]))
    parent, cost = near, tree.costs[near] + best
    for i in range(node):
        tree.squares[i] = squared_gap(problem.turning, tree.q[i], tree.q[node])
    refused = -1.0
    for _ in range(TRIES):
        # The cheapest that was not refused yet; costs that are alike are refused together.
        found, least = -1, cost
        for i in range(node):
            if tree.squares[i] < square:
                through = tree.costs[i] + math.sqrt(tree.squares[i])
                if refused < through < least:
                    found, least = i, through
        if found < 0 or found == near:
            break
        if seems_to_hold(problem, tree.q[found], tree.q[node], work):
            parent, cost = found, least
            break
        refused = least
    tree.costs[node] = cost
    hang(tree.parents, tree.children, tree.siblings, node, parent)


@inner
def rewire(problem: Problem, tree: Tree, node: int, square: float, work: Work) -> None:
    """Hang nodes near on this one where that lowers their costs, and costs of what hangs on them."""
    for i in range(1, node):
        if not tree.squares[i] < square or i == tree.parents[node]:
            continue
        saving = tree.costs[i] - tree.costs[node] - math.sqrt(tree.squares[i])
        if saving > 1e-9 and seems_to_hold(problem, tree.q[node], tree.q[i], work):
            unhang(tree.parents, tree.children, tree.siblings, i)
            hang(tree.parents, tree.children, tree.siblings, i, node)
            tree.proven[i] = 0
            lower_costs(tree.parents, tree.children, tree.siblings, tree.costs, i, saving)


@inner
def add(problem: Problem, tree: Tree, near: int, q: Array, work: Work) -> int:
    """A new node at q (D,), whose pose is `work.pose` and whose edge from node `near` holds; its number."""
    node = put(problem, tree, q, work)
    square = near_radius(node, q.size)
    choose_parent(problem, tree, node, near, square, work)
    rewire(problem, tree, node, square, work)
    return node


@inner
def has_room(tree: Tree) -> bool:
    """Whether a node more fits in."""
    return tree.size[0] < len(tree.q)


@inner
def try_add(problem: Problem, tree: Tree, near: int, q: Array, work: Work) -> int:
    """The same, once it is looked at whether pose and edge hold and there is room; -1 where not."""
    fits = has_room(tree) and is_inside(problem.hold, work.pose) and is_clear(problem, q)
    return add(problem, tree, near, q, work) if fits and seems_to_hold(problem, tree.q[near], q, work) else -1


@inner
def nearest(tree: Tree, white: Array) -> int:
    """The node whose pose is nearest to whitened coordinates (6,), weights considered."""
    best, least = 0, math.inf
    for i in range(tree.size[0]):
        s = 0.0
        for c in range(6):
            s += (tree.z[i, c] - white[c]) ** 2
        if tree.weights[i] * s < least:
            best, least = i, tree.weights[i] * s
    return best


@inlined
def extend(problem: Problem, tree: Tree, near: int, target: Array, work: Work) -> int:
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
        node = try_add(problem, tree, last, q, work)
        if node < 0:
            break
        last = newest = node
        if done or tree.goals[node]:
            break
    return newest


@inlined
def connect(problem: Problem, tree: Tree, q: Array, work: Work) -> int:
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
        node = try_add(problem, tree, last, way, work)
        if node < 0:
            break
        last = newest = node
        if tree.goals[node]:
            break
    return newest


@inlined
def get_inside(problem: Problem, q: Array, target: Array, work: Work) -> bool:
    """Let joint positions q (D,) descend toward a target (6,) until their pose is inside; whether it is."""
    before = math.inf
    for _ in range(STEPS):
        left = descend(problem, q, target, False, work)
        if is_inside(problem.hold, work.pose):
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
def grow(table: Indices, nodes: Indices, targets: Array, kinds: Indices, starts: Array, first: bool) -> int:
    """Grow a tree by a batch of targets; how many were used: fewer where the tree is full or a first goal is found.

    Args:
        table: of the problem.
        nodes: table of a tree that has a root.
        targets: (T, 6) chart coordinates.
        kinds: (T,) how each is used: `FROM_TREE`, `FROM_START`; `JOIN` and `END` take starts as they are, and `END`
            is a goal.
        starts: (T, D) random joint positions, overwritten.
        first: whether to stop at the first node in the goal.
    """
    problem, tree = problem_at(table), tree_at(nodes)
    work, white = make_work(starts.shape[1]), np.empty(6)
    for t in range(len(targets)):
        if not has_room(tree):
            return t
        newest = -1
        if kinds[t] == FROM_TREE:
            whitened(problem, targets[t], white)
            near = nearest(tree, white)
            newest = extend(problem, tree, near, targets[t], work)
            if newest < 0:
                tree.weights[near] *= REFUSED
        elif kinds[t] >= JOIN or get_inside(problem, starts[t], targets[t], work):
            newest = connect(problem, tree, starts[t], work)
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


@inner
def forget(tree: Tree) -> None:
    """Put nodes that were lost where no target is near."""
    for i in range(tree.size[0]):
        if tree.parents[i] == LOST and tree.z[i, 0] < math.inf:
            tree.goals[i] = 0
            tree.z[i, 0] = math.inf
            for k in range(tree.q.shape[1]):
                tree.q[i, k] = math.nan
