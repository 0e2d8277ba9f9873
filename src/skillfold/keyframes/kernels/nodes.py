"""The tree of PCTC-RRT* in joint space, with choose-parent and rewiring (algorithm 4, lines 5 to 27), mended.

Line 9 keeps the least cost so far, and costs of what hangs on rewired nodes follow. Edges are inside and seem clear.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import inner
from skillfold.keyframes.kernels.charts import to_flat
from skillfold.keyframes.kernels.descent import is_inside
from skillfold.keyframes.kernels.edges import seems_to_hold, squared_gap
from skillfold.keyframes.kernels.problem import Problem, Work
from skillfold.planning.tree import LOST, hang, lower_costs, unhang
from skillfold.tables import indices, matrix, vector

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

WIDEST, FACTOR = 0.8, 1.5  # radians: radius of Near at most, and its γ
TIE = 1e-9  # radians: costs that differ by less are the same
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
def choose_parent(problem: Problem, tree: Tree, node: int, square: float, work: Work) -> None:
    """Hang the newest node where its cost is least among those near.

    Squared lengths of edges from all nodes are left in `tree.squares`.
    """
    near = parent = tree.parents[node]
    cost = tree.costs[node]
    for i in range(node):
        tree.squares[i] = squared_gap(problem.turning, tree.q[i], tree.q[node])
    refused = -1.0
    for _ in range(TRIES):
        # The cheapest that was not refused yet; costs that are alike are refused together.
        found, least = -1, cost - TIE
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
    if parent != near:
        unhang(tree.parents, tree.children, tree.siblings, node)
        hang(tree.parents, tree.children, tree.siblings, node, parent)
        tree.costs[node] = cost


@inner
def rewire(problem: Problem, tree: Tree, node: int, square: float, work: Work) -> None:
    """Hang nodes near on this one where that lowers their costs, and costs of what hangs on them."""
    for i in range(1, node):
        if not tree.squares[i] < square or i == tree.parents[node]:
            continue
        saving = tree.costs[i] - tree.costs[node] - math.sqrt(tree.squares[i])
        if saving > TIE and seems_to_hold(problem, tree.q[node], tree.q[i], work):
            unhang(tree.parents, tree.children, tree.siblings, i)
            hang(tree.parents, tree.children, tree.siblings, i, node)
            tree.proven[i] = 0
            lower_costs(tree.parents, tree.children, tree.siblings, tree.costs, i, saving)


@inner
def add(problem: Problem, tree: Tree, near: int, q: Array, work: Work) -> int:
    """A new node at q (D,), whose pose is `work.pose` and whose edge from node `near` holds; its number."""
    node = put(problem, tree, q, work)
    tree.costs[node] = tree.costs[near] + math.sqrt(squared_gap(problem.turning, tree.q[near], q))
    hang(tree.parents, tree.children, tree.siblings, node, near)
    return node


@inner
def settle(problem: Problem, tree: Tree, node: int, work: Work) -> None:
    """RRT*: the newest node and those near it hang where their costs are least."""
    square = near_radius(node, tree.q.shape[1])
    choose_parent(problem, tree, node, square, work)
    rewire(problem, tree, node, square, work)


@inner
def has_room(tree: Tree) -> bool:
    """Whether a node more fits in."""
    return tree.size[0] < len(tree.q)


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


@inner
def forget(tree: Tree) -> None:
    """Put nodes that were lost where no target is near."""
    for i in range(tree.size[0]):
        if tree.parents[i] == LOST and tree.z[i, 0] < math.inf:
            tree.goals[i] = 0
            tree.z[i, 0] = math.inf
            for k in range(tree.q.shape[1]):
                tree.q[i, k] = math.nan
