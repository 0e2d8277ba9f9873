"""PCTC-RRT* around its kernels: batches of targets, time, the best way so far."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.jit import compile_for
from skillfold.keyframes.kernels import rrtstar as kernel
from skillfold.keyframes.kernels.nodes import Tree
from skillfold.keyframes.kernels.reaching import reach
from skillfold.keyframes.kernels.shortcuts import shorten
from skillfold.tables import Table, table_of

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

ROOM = 20_000  # nodes of a tree
REACH = 0.3  # η, radians: longest edge of a tree
FROM_TREE = 0.8  # share of the targets that are approached from the tree
GOAL_BIAS = 0.2  # share that is drawn from the goal
BATCHES = (32, 64, 128)  # targets between two looks at the clock, the last again and again
SHORTCUTS = 20  # tried on each path
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
        """Joint positions (n, D) of the nodes, and the parent (n,) of each."""
        return self.nodes.q[: self.count].copy(), self.nodes.parents[: self.count].copy()

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
    """

    table: Table
    margin: float
    turning: Flags


@dataclass(frozen=True)
class Targets:
    """Where targets come from.

    Attributes:
        inside, goal: (count, seed) → chart coordinates (count, 6) inside, and in the goal.
        states: (count, seed) → random joint positions (count, D) within limits.
        end: (D,) joint positions that are the goal, where it is no region.
    """

    inside: Callable[[int, int], Array]
    goal: Callable[[int, int], Array]
    states: Callable[[int, int], Array]
    end: Array | None = None

    def draw(self, rng: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
        """Targets (count, 6), how each is used, and random joint positions (count, D)."""
        kinds = np.where(rng.random(count) < FROM_TREE, kernel.FROM_TREE, kernel.FROM_START)
        goals = np.flatnonzero(rng.random(count) < GOAL_BIAS)
        seeds = rng.integers(2**31, size=3).tolist()
        targets, states = self.inside(count, seeds[0]), self.states(count, seeds[1])
        targets[goals] = self.goal(len(goals), seeds[2])
        if self.end is not None:
            kinds[goals[::2]] = kernel.END
            states[goals[::2]] = self.end
        return targets, kinds, states


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
        tree: joint positions (n, D) of the nodes, and the parent (n,) of each, -1 for the root.
    """

    path: Array
    cost: float = np.inf
    nodes: int = 0
    iterations: int = 0
    first: float = np.nan
    costs: list[tuple[float, float]] = field(default_factory=list)
    tree: tuple[Array, Indices] | None = None


@cache
def prepare() -> None:
    """Have the compiled loops ready, once: no time limit should have to wait for them."""
    table, rows, flag = np.empty(0, np.int64), np.empty((0, 0)), True
    compile_for(kernel.plant, table, table, rows.ravel())
    compile_for(kernel.grow, table, table, rows, table, rows, flag)
    compile_for(kernel.prove, table, table, 0)
    compile_for(shorten, table, rows, 0, rows)
    compile_for(reach, table, rows, rows)


def search(
    question: Question, start: Array, targets: Targets, begun: float, deadline: float, first: bool, seed: int
) -> Found:
    """A way from joint positions `start` (D,), whose pose is inside, to a pose inside the goal.

    Args:
        question: what is asked.
        start: the root of the tree.
        targets: where targets come from.
        begun, deadline: when the clock of the answer started, and when to give up or stop; seconds of `perf_counter`.
        first: whether the first way is enough; else it is made better until the deadline.
        seed: same seed, same targets.
    """
    rng = np.random.default_rng(seed)
    tree = Grown(ROOM, len(start))
    kernel.plant(question.table.entries, tree.table.entries, start)
    found, turn = Found(np.empty((0, len(start)))), 0
    if tree.nodes.goals[0]:
        return Found(np.stack([start, start]), 0.0, 1, 0, perf_counter() - begun, [(perf_counter() - begun, 0.0)])
    while (turn == 0 or perf_counter() < deadline) and tree.count < ROOM:
        batch = targets.draw(rng, BATCHES[min(turn, len(BATCHES) - 1)])
        turn += 1
        if _use(question, tree, batch, found, rng, begun, first) and first:
            break
    found.nodes, found.tree = tree.count, tree.copied()
    return found


def _use(
    question: Question,
    tree: Grown,
    batch: tuple[Array, Array, Array],
    found: Found,
    rng: np.random.Generator,
    begun: float,
    first: bool,
) -> bool:
    """Grow the tree by a batch of targets, or until a first way is found; whether a better one was."""
    used, better = 0, False
    while used < len(batch[0]) and tree.count < ROOM:
        used += kernel.grow(question.table.entries, tree.table.entries, *(part[used:] for part in batch), first)
        better = improve(question, tree, found, rng, begun)
        if better and first:
            break
        if better:
            give_back(question, tree, found.path)
    found.iterations += used
    return better


def improve(question: Question, tree: Grown, found: Found, rng: np.random.Generator, begun: float) -> bool:
    """Take the tree's best way where it is better than what was found, and shorten it; whether that was better."""
    best = proven_goal(question, tree, found.cost)
    if best < 0:
        return False
    if np.isnan(found.first):
        found.first = perf_counter() - begun
    path = way_to(tree, best, question.turning)
    short = shortened(question, path, rng.random((SHORTCUTS, 2)))
    cost = length_of(short)
    if not cost < found.cost:
        return False
    found.path, found.cost = short, cost
    found.costs.append((perf_counter() - begun, cost))
    return True


def proven_goal(question: Question, tree: Grown, cost: float) -> int:
    """The goal node that costs least, its way clear all along; -1 where none costs less than `cost`."""
    while True:
        goals, costs = tree.goals(), tree.nodes.costs
        best = int(goals[costs[goals].argmin()]) if len(goals) else -1
        if best < 0 or not costs[best] < cost - 1e-9:
            return -1
        if kernel.prove(question.table.entries, tree.table.entries, best):
            return best


def give_back(question: Question, tree: Grown, path: Array) -> None:
    """Make the states of a path nodes of the tree."""
    states = dense(path, REACH)[1:].copy()
    kinds, targets = np.full(len(states), kernel.JOIN), np.empty((len(states), 6))
    kernel.grow(question.table.entries, tree.table.entries, targets, kinds, states, False)


def shortened(question: Question, path: Array, picks: Array) -> Array:
    """A path with shortcuts; no longer than before."""
    room = np.empty((len(path) + 2 * len(picks), path.shape[1]))
    room[: len(path)] = path
    return room[: shorten(question.table.entries, room, len(path), picks)].copy()


def way_to(tree: Grown, node: int, turning: Flags) -> Array:
    """The way (n, D) from the root to a node, each state facing the one before."""
    nodes = [node]
    while tree.nodes.parents[nodes[-1]] >= 0:
        nodes.append(int(tree.nodes.parents[nodes[-1]]))
    return facing_path(tree.nodes.q[nodes[::-1]], turning)


def facing_path(states: Array, turning: Flags) -> Array:
    """States (n, D) with full turns of continuous joints added so that none is passed between two states."""
    steps = np.diff(states, axis=0)
    steps[:, turning] -= TURN * np.floor(steps[:, turning] / TURN + 0.5)
    return np.vstack([states[:1], states[0] + np.cumsum(steps, axis=0)])


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
