"""PCTC-RRT* around its kernels: batches of targets, time, the best way so far."""

from functools import cache
from time import perf_counter

import numpy as np

from skillfold.jit import compile_for
from skillfold.keyframes.grown import (
    REACH,
    ROOM,
    Array,
    Batch,
    Found,
    Grown,
    Question,
    Targets,
    dense,
    facing_path,
    length_of,
    way_to,
)
from skillfold.keyframes.kernels import rrtstar as kernel
from skillfold.keyframes.kernels.reaching import reach
from skillfold.keyframes.kernels.relaxing import relax
from skillfold.keyframes.kernels.shortcuts import shorten

BATCHES = (32, 64, 128)  # targets between two looks at the clock, the last again and again
SHORTCUTS = 12  # tried on each path
MOVES = 60  # of places of a path, tried at a time
PULL = 0.5  # of the moves that go toward the middle of the neighbours, too
MOVED = (0.01, 0.03, 0.1, 0.3)  # radians: how far aside
ROUNDS = 4  # of shortcuts and moves on the first way of each tree
TREES, SHARE = 6, 0.3  # trees that are begun anew where time is left, and the share of it that they may take
LOCAL = 48  # targets of a batch that shortens the best way
BESIDE, AIMED = 0.5, 0.25  # shares of them beside it in joint space, and toward another end from somewhere on it
SPREADS = (0.03, 0.1, 0.3)  # radians: how far beside


@cache
def prepare() -> None:
    """Have the compiled loops ready, once: no time limit should have to wait for them."""
    table, rows, flag = np.empty(0, np.int64), np.empty((0, 0)), True
    compile_for(kernel.plant, table, table, rows.ravel())
    compile_for(kernel.grow, table, table, rows, table, table, rows, flag)
    compile_for(kernel.prove, table, table, 0)
    compile_for(shorten, table, rows, 0, rows)
    compile_for(reach, table, rows, rows)
    compile_for(relax, table, rows, 0, rows.ravel(), rows.ravel(), rows, flag)


def search(
    question: Question, start: Array, targets: Targets, begun: float, deadline: float, first: bool, seed: int
) -> Found:
    """A way from joint positions `start` (D,), whose pose is inside, to a pose inside the goal.

    Where the first way is not enough, a few more trees are grown to a first way: they differ more than a tree
    improves in the same time. The last one then grows on, with the best way in it.

    Args:
        question: what is asked.
        start: the root of the trees.
        targets: where targets come from.
        begun, deadline: when the clock of the answer started, and when to give up or stop; seconds of `perf_counter`.
        first: whether the first way is enough; else it is made better until the deadline.
        seed: same seed, same targets.
    """
    found = Found(np.empty((0, len(start))))
    anew = perf_counter() + SHARE * (deadline - perf_counter())
    turn = 0
    while True:
        growth = Growth(question, start, targets, begun, np.random.default_rng([seed, turn]))
        growth.find(deadline)
        for _ in range(0 if first else ROUNDS):
            growth.polish()
        found.take(growth.found)
        turn += 1
        if first or turn == TREES or perf_counter() > anew:
            break
    if not first and len(found.path):
        growth.improve(found, deadline)
    found.tree = growth.tree.copied()
    return found


class Growth:
    """One tree that grows, and the best way in it."""

    def __init__(
        self, question: Question, start: Array, targets: Targets, begun: float, rng: np.random.Generator
    ) -> None:
        """See `search`; `rng` draws all that is random."""
        self.question, self.targets, self.begun, self.rng = question, targets, begun, rng
        self.tree, self.found, self.chain = (
            Grown(ROOM, len(start)),
            Found(np.empty((0, len(start)))),
            np.zeros(0, int),
        )
        kernel.plant(question.table.entries, self.tree.table.entries, start)

    def find(self, deadline: float) -> None:
        """Grow until a first way is found, or time is up."""
        turn = 0
        if self.tree.nodes.goals[0]:
            self.note(np.repeat(self.tree.nodes.q[:1], 2, axis=0))
        while not len(self.found.path) and (turn == 0 or perf_counter() < deadline) and self.tree.count < ROOM:
            batch = self.targets.draw(self.rng, BATCHES[min(turn, len(BATCHES) - 1)])
            used, turn = 0, turn + 1
            while used < len(batch[0]) and self.tree.count < ROOM and not len(self.found.path):
                used += self.grow(_rest(batch, used), True)
                self.look()
            self.found.iterations += used
        self.found.nodes = self.tree.count

    def improve(self, best: Found, deadline: float) -> None:
        """Make the best way of all trees, taken into this one, shorter until time is up."""
        nodes, iterations = best.nodes - self.found.nodes, best.iterations
        self.found = best
        self.give_back()
        while perf_counter() < deadline and self.tree.count < ROOM and best.cost > 0.0:
            iterations += self.grow(self.local(LOCAL), False)
            better = self.look()
            if self.polish() or better:
                self.give_back()
        best.nodes, best.iterations = nodes + self.tree.count, iterations

    def grow(self, batch: Batch, first: bool) -> int:
        """Use a batch of targets; how many were used."""
        return kernel.grow(self.question.table.entries, self.tree.table.entries, *batch, first)

    def local(self, count: int) -> Batch:
        """Targets once there is a way: near it in joint space (local bias), another end of it, or anywhere."""
        targets, kinds, froms, states = self.targets.draw(self.rng, count)
        use = self.rng.random(count)
        near = np.flatnonzero(use < BESIDE)
        path = self.found.path
        edges, share = self.rng.integers(len(path) - 1, size=len(near)), self.rng.random((len(near), 1))
        points = path[edges] + share * (path[edges + 1] - path[edges])
        spread = self.rng.choice(SPREADS, (len(near), 1))
        states[near] = np.clip(points + spread * self.rng.standard_normal(points.shape), *self.question.limits)
        kinds[near] = kernel.JOIN
        chain = self.chain[np.isfinite(self.tree.nodes.costs[self.chain])]  # what is not lost
        if self.targets.aim is not None and len(chain):
            ends = np.flatnonzero(use > 1.0 - AIMED)
            froms[ends] = self.rng.choice(chain, len(ends))
            targets[ends], kinds[ends] = self.targets.aim(self.tree.nodes.q[froms[ends]]), kernel.FROM_TREE
        return targets, kinds, froms, states

    def look(self) -> bool:
        """Take the tree's best way where it is better than what was found, and shorten it; whether it was."""
        best = self.proven_goal()
        if best < 0:
            return False
        if np.isnan(self.found.first):
            self.found.first = perf_counter() - self.begun
        path = facing_path(self.tree.nodes.q[way_to(self.tree, best)], self.question.turning)
        return self.note(self.shortened(path))

    def polish(self) -> bool:
        """Try other shortcuts, and places of the best way a little aside; whether that made it shorter."""
        return len(self.found.path) > 0 and self.note(self.relaxed(self.shortened(self.found.path)))

    def note(self, path: Array) -> bool:
        """Keep a path where it is better; whether it is."""
        cost, found = length_of(path), self.found
        if not cost < found.cost - 1e-9:
            return False
        found.path, found.cost = path, cost
        found.costs.append((perf_counter() - self.begun, cost))
        if np.isnan(found.first):
            found.first = found.costs[-1][0]
        return True

    def proven_goal(self) -> int:
        """The goal node that costs least, its way clear all along; -1 where none costs less than what was found."""
        while True:
            goals, costs = self.tree.goals(), self.tree.nodes.costs
            best = int(goals[costs[goals].argmin()]) if len(goals) else -1
            if best < 0 or not costs[best] < self.found.cost - 1e-9:
                return -1
            if kernel.prove(self.question.table.entries, self.tree.table.entries, best):
                return best

    def give_back(self) -> None:
        """Make the states of the best way nodes of the tree."""
        states = dense(self.found.path, REACH)[1:].copy()
        count, before = len(states), self.tree.count
        joined = np.full(count, kernel.JOIN), np.full(count, -1)
        self.grow((np.empty((count, 6)), *joined, states), False)
        self.chain = np.arange(before, self.tree.count)

    def relaxed(self, path: Array) -> Array:
        """A path with places moved; no longer than before."""
        path = dense(path, REACH)
        pulls = self.rng.random(MOVES) * (self.rng.random(MOVES) < PULL)
        moves = self.rng.choice(MOVED, (MOVES, 1)) * self.rng.standard_normal((MOVES, path.shape[1]))
        free = self.targets.end is None
        relax(self.question.table.entries, path, len(path), self.rng.random(MOVES), pulls, moves, free)
        return path

    def shortened(self, path: Array) -> Array:
        """A path with shortcuts; no longer than before."""
        picks = self.rng.random((SHORTCUTS, 2))
        room = np.empty((len(path) + 2 * len(picks), path.shape[1]))
        room[: len(path)] = path
        return room[: shorten(self.question.table.entries, room, len(path), picks)].copy()


def _rest(batch: Batch, used: int) -> Batch:
    targets, kinds, froms, starts = batch
    return targets[used:], kinds[used:], froms[used:], starts[used:]
