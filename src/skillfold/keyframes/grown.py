"""Trees, targets and ways of the planner in Python's hands."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skillfold.keyframes.compiled import raise_error
from skillfold.keyframes.constraint import CompiledConstraint
from skillfold.keyframes.kernels import rrtstar as kernel
from skillfold.keyframes.kernels.nodes import Tree
from skillfold.tables import Table, table_of

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]
Batch = tuple[Array, Indices, Indices, Array]

ROOM = 20_000  # nodes of a tree
REACH = 0.3  # η, radians: longest edge of a tree
FROM_TREE = 0.8  # share of the targets that are approached from the tree
GOAL_BIAS = 0.2  # share that is drawn from the goal
TURN = 2 * np.pi


class Grown:
    """A tree in Python's hands, and its table."""

    def __init__(self, limit: int, dof: int) -> None:
        """Room for `limit` nodes of a robot with `dof` joints."""
        parents, children, siblings, goals, proven = (np.empty(limit, np.int64) for _ in range(5))
        states, poses, count = np.empty((limit, dof)), np.empty((limit, 6)), np.zeros(1, np.int64)
        costs, weights, squares = (np.empty(limit) for _ in range(3))
        self.nodes = Tree(states, poses, costs, parents, children, siblings, goals, count, proven, weights, squares)
        self.table = table_of(dict(enumerate(self.nodes)), len(self.nodes))

    @property
    def count(self) -> int:
        """How many nodes there are, lost ones too."""
        return int(self.nodes.size[0])

    def copied(self) -> tuple[Array, Indices]:
        """Joint positions (n, D) of the nodes that are not lost, and the parent (n,) of each; -1 is the root's."""
        kept = np.flatnonzero(np.isfinite(self.nodes.costs[: self.count]))
        parents = np.searchsorted(kept, self.nodes.parents[kept])
        parents[0] = -1
        return self.nodes.q[kept], parents

    def goals(self) -> Indices:
        """Nodes in the goal."""
        return np.flatnonzero(self.nodes.goals[: self.count])


@dataclass(frozen=True)
class Question:
    """A problem as compiled loops take it.

    Attributes:
        table: see `kernels.problem`.
        margin: clearance [m] that edges keep.
        turning: (D,) which joints are continuous.
        limits: (2, D) of the joints.
        constraints: that the loops may call.
    """

    table: Table
    margin: float
    turning: Flags
    limits: Array
    constraints: tuple[CompiledConstraint, ...] = ()

    def raise_errors(self) -> None:
        """Raise what went wrong in users' constraints since this was last asked."""
        for constraint in self.constraints:
            raise_error(constraint)


@dataclass(frozen=True)
class Targets:
    """Where targets come from.

    Attributes:
        inside, goal: (count, seed) → chart coordinates (count, 6) inside, and in the goal.
        states: (count, seed) → random joint positions (count, D) within limits.
        aim: joint positions (n, D) → chart coordinates (n, 6) of what is nearest to their poses in the goal; None
            where that is no region.
        end: (D,) joint positions that are the goal, where it is no region.
    """

    inside: Callable[[int, int], Array]
    goal: Callable[[int, int], Array]
    states: Callable[[int, int], Array]
    aim: Callable[[Array], Array] | None = None
    end: Array | None = None

    def draw(self, rng: np.random.Generator, count: int) -> Batch:
        """Targets (count, 6), how each is used, from which node, and random joint positions (count, D)."""
        kinds = np.where(rng.random(count) < FROM_TREE, kernel.FROM_TREE, kernel.FROM_START)
        goals = np.flatnonzero(rng.random(count) < GOAL_BIAS)
        seeds = rng.integers(2**31, size=3).tolist()
        targets, states = self.inside(count, seeds[0]), self.states(count, seeds[1])
        targets[goals] = self.goal(len(goals), seeds[2])
        if self.end is None:
            kinds[goals[kinds[goals] == kernel.FROM_START]] = kernel.FROM_FAR
        else:
            kinds[goals[::2]] = kernel.END
            states[goals[::2]] = self.end
        return targets, kinds, np.full(count, -1), states


@dataclass
class Found:
    """The best way and how it was found.

    Attributes:
        path: (n, D) joint positions, each facing the one before; empty where there is none.
        cost: its length [rad]; infinite where there is none.
        nodes: of the tree.
        iterations: targets used.
        first: seconds until the first way was there, NaN where there is none.
        costs: (seconds, cost) of each better way.
        tree: joint positions (n, D) of the last tree's nodes, and the parent (n,) of each.
    """

    path: Array
    cost: float = np.inf
    nodes: int = 0
    iterations: int = 0
    first: float = np.nan
    costs: list[tuple[float, float]] = field(default_factory=list)
    tree: tuple[Array, Indices] | None = None

    def take(self, other: "Found") -> None:
        """What another search found, where it is better."""
        self.nodes += other.nodes
        self.iterations += other.iterations
        if np.isnan(self.first):
            self.first = other.first
        if other.cost < self.cost:
            self.path, self.cost = other.path, other.cost
            self.costs.append(other.costs[-1])


def way_to(tree: Grown, node: int) -> Indices:
    """The nodes from the root to one of them."""
    nodes = [node]
    while tree.nodes.parents[nodes[-1]] >= 0:
        nodes.append(int(tree.nodes.parents[nodes[-1]]))
    return np.array(nodes[::-1])


def facing_path(states: Array, turning: Flags) -> Array:
    """States (n, D) with full turns of continuous joints added so that none is passed between two states."""
    return np.vstack([states[:1], states[0] + np.cumsum(facing_steps(np.diff(states, axis=0), turning), axis=0)])


def facing_steps(steps: Array, turning: Flags) -> Array:
    """Steps (n, D) less full turns of continuous joints."""
    steps = steps.copy()
    steps[:, turning] -= TURN * np.floor(steps[:, turning] / TURN + 0.5)
    return steps


def length_of(path: Array) -> float:
    """Length [rad] of a path (n, D)."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def dense(path: Array, spacing: float) -> Array:
    """The path (n, D) with more states on its edges, none farther apart than `spacing`; ends and corners are kept."""
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    counts = np.maximum(np.ceil(lengths / spacing - 1e-9), 1).astype(int)
    edges = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(edges)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[edges]
    return np.vstack([path[edges] + share[:, None] * (path[edges + 1] - path[edges]), path[-1:]])
