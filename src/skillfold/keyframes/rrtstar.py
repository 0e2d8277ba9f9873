"""PCTC-RRT* around its kernels: batches of targets, time, the best way so far."""

from functools import cache
from time import perf_counter

import numpy as np

from skillfold.jit import compile_for
from skillfold.keyframes.compiled import prepare_constraints
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
    facing_steps,
    length_of,
    way_to,
)
from skillfold.keyframes.kernels import rrtstar as kernel
from skillfold.keyframes.kernels.reaching import reach
from skillfold.keyframes.kernels.relaxing import approach, relax
from skillfold.keyframes.kernels.shortcuts import shorten
from skillfold.robots.compiled import prepare_obstacles
from skillfold.robots.kinematics import poses
from skillfold.worst import worst_places

BATCHES = (32, 64, 128)  # targets between two looks at the clock, the last again and again
SHORTCUTS = 12  # tried on each path
MOVES = 60  # of places of a path, tried at a time
PULL = 0.5  # of the moves that go toward the middle of the neighbours, too
MOVED = (0.01, 0.03, 0.1, 0.3)  # radians: how far aside
LOCAL = 32  # targets of a batch that shortens the best way
BESIDE, ENDED, AIMED = 0.7, 0.2, 0.1  # shares: beside it in joint space, to a near end, from it to other ends
SPREADS = (0.03, 0.1, 0.3, 0.6)  # radians: how far beside
STRAIGHT = 0.5  # of those beside it lie beside the straight edge to a near end instead
ENDS, SLIDES, NEAR = 16, 300, 4  # descents to the goal, moves of each nearer to the start, and how many are kept


@cache
def prepare() -> None:
    """Have the compiled loops ready, once, also those of poses, constraints, obstacles and the check.

    No time limit should have to wait for them: a first plan that does so is another one than the second.
    """
    prepare_obstacles()
    prepare_constraints()
    table, rows, flag = np.empty(0, np.int64), np.empty((0, 0)), True
    compile_for(poses, rows, 0, rows.ravel(), rows.ravel(), table, rows)
    compile_for(worst_places, rows.ravel(), rows.ravel(), rows)
    compile_for(kernel.plant, table, table, rows.ravel())
    compile_for(kernel.grow, table, table, rows, table, table, rows, flag)
    compile_for(kernel.prove, table, table, 0)
    compile_for(shorten, table, rows, 0, rows)
    compile_for(reach, table, rows, rows)
    compile_for(relax, table, rows, 0, rows.ravel(), rows.ravel(), rows, flag)
    compile_for(approach, table, rows.ravel(), rows, rows.ravel(), rows)


def search(
    question: Question, start: Array, targets: Targets, begun: float, deadline: float, first: bool, seed: int
) -> Found:
    """A way from joint positions `start` (D,), whose pose is inside, to a pose inside the goal.

    Where the first way is not enough, the tree goes on as RRT*, beside the best way and toward ends that lie near the
    start in joint space: of a pose's postures most cost far more than the best, whatever the way.

    Args:
        question: what is asked.
        start: the root of the tree.
        targets: where targets come from.
        begun, deadline: when the clock of the answer started, and when to give up or stop; seconds of `perf_counter`.
        first: whether the first way is enough; else it is made better until the deadline.
        seed: same seed, same targets.
    """
    growth = Growth(question, start, targets, begun, np.random.default_rng(seed))
    if not first:
        growth.ends = growth.near_ends()
    growth.find(deadline)
    if not first and len(growth.found.path):
        growth.improve(deadline)
    growth.found.nodes, growth.found.tree = growth.tree.count, growth.tree.copied()
    return growth.found


class Growth:
    """One tree that grows, and the best way in it."""

    def __init__(
        self, question: Question, start: Array, targets: Targets, begun: float, rng: np.random.Generator
    ) -> None:
        """See `search`; `rng` draws all that is random."""
        self.question, self.start, self.targets, self.begun, self.rng = question, start, targets, begun, rng
        self.tree, self.found = Grown(ROOM, len(start)), Found(np.empty((0, len(start))))
        self.chain, self.ends = np.zeros(0, int), np.empty((0, len(start)))
        kernel.plant(question.table.entries, self.tree.table.entries, start)

    def find(self, deadline: float) -> None:
        """Grow until a first way is found, or time is up."""
        turn = 0
        if self.tree.nodes.goals[0]:
            self.note(np.repeat(self.tree.nodes.q[:1], 2, axis=0))
        while not len(self.found.path) and (turn == 0 or perf_counter() < deadline) and self.tree.count < ROOM:
            count = BATCHES[min(turn, len(BATCHES) - 1)]
            batch = self.local(count) if len(self.ends) else self.targets.draw(self.rng, count)
            used, turn = 0, turn + 1
            while used < len(batch[0]) and self.tree.count < ROOM and not len(self.found.path):
                used += self.grow(_rest(batch, used), True)
                self.look()
            self.found.iterations += used

    def improve(self, deadline: float) -> None:
        """Make the best way shorter until time is up."""
        self.polish()
        self.give_back()
        while perf_counter() < deadline and self.tree.count < ROOM and self.found.cost > 0.0:
            self.found.iterations += self.grow(self.local(LOCAL), False)
            better = self.look()
            if self.polish() or better:
                self.give_back()

    def grow(self, batch: Batch, first: bool) -> int:
        """Use a batch of targets; how many were used."""
        used = kernel.grow(self.question.table.entries, self.tree.table.entries, *batch, first)
        self.question.raise_errors()
        return used

    def near_ends(self) -> Array:
        """Joint positions (n, D) in the goal, nearest to the start first; none where one is asked for."""
        if self.targets.end is not None:
            return self.ends
        seeds = self.rng.integers(2**31, size=2).tolist()
        states, targets = self.targets.states(ENDS, seeds[0]), self.targets.goal(ENDS, seeds[1])
        states[::2] = self.start
        reached, used = [], 0
        while used < ENDS:
            at = reach(self.question.table.entries, states[used:], targets[used:])
            if at < 0:
                break
            reached.append(states[used + at])
            used += at + 1
        if not reached:
            return self.ends
        ends = self.start + facing_steps(np.array(reached) - self.start, self.question.turning)
        approach(self.question.table.entries, self.start, ends, *self.moves(SLIDES))
        return ends[np.linalg.norm(ends - self.start, axis=1).argsort()[:NEAR]]

    def some_ends(self, count: int) -> Array:
        """Near ends (count, D), the nearest most often; there must be some."""
        if not count:
            return self.ends[:0]
        which = self.rng.exponential(1.0, count).astype(int)
        return self.ends[np.minimum(which, len(self.ends) - 1)]

    def local(self, count: int) -> Batch:
        """Targets near a good way (local bias): beside it, near ends, other ends from it; or anywhere."""
        targets, kinds, froms, states = self.targets.draw(self.rng, count)
        use = self.rng.random(count)
        near = np.flatnonzero(use < BESIDE)
        states[near], kinds[near] = self.beside(len(near)), kernel.JOIN
        chain = self.chain[np.isfinite(self.tree.nodes.costs[self.chain])]  # what is not lost
        if self.targets.aim is not None and len(chain):
            ends = np.flatnonzero(use > 1.0 - AIMED)
            froms[ends] = self.rng.choice(chain, len(ends))
            targets[ends], kinds[ends] = self.targets.aim(self.tree.nodes.q[froms[ends]]), kernel.FROM_TREE
        if len(self.ends):
            ends = np.flatnonzero(self.rng.random(count) < ENDED)
            kinds[ends], states[ends] = kernel.JOIN, self.some_ends(len(ends))
        return targets, kinds, froms, states

    def beside(self, count: int) -> Array:
        """Joint positions (count, D) beside the best way, or beside the straight edge to a near end."""
        points, share = np.empty((count, len(self.start))), self.rng.random((count, 1))
        straight = self.rng.random(count) < (STRAIGHT if len(self.found.path) else 1.0) * (len(self.ends) > 0)
        points[straight] = self.start + share[straight] * (self.some_ends(straight.sum()) - self.start)
        if len(self.found.path):
            path, edges = self.found.path, self.rng.integers(len(self.found.path) - 1, size=count)
            points[~straight] = (path[edges] + share * (path[edges + 1] - path[edges]))[~straight]
        aside = self.rng.choice(SPREADS, (count, 1)) * self.rng.standard_normal(points.shape)
        return np.clip(points + aside, *self.question.limits)

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
        free = self.targets.end is None
        relax(self.question.table.entries, path, len(path), self.rng.random(MOVES), *self.moves(MOVES), free)
        return path

    def moves(self, count: int) -> tuple[Array, Array]:
        """How far to go toward where it is shorter (count,), some not at all; and aside (count, D) [rad]."""
        pulls = self.rng.random(count) * (self.rng.random(count) < PULL)
        return pulls, self.rng.choice(MOVED, (count, 1)) * self.rng.standard_normal((count, len(self.start)))

    def shortened(self, path: Array) -> Array:
        """A path with shortcuts; no longer than before."""
        picks = self.rng.random((SHORTCUTS, 2))
        room = np.empty((len(path) + 2 * len(picks), path.shape[1]))
        room[: len(path)] = path
        return room[: shorten(self.question.table.entries, room, len(path), picks)].copy()


def _rest(batch: Batch, used: int) -> Batch:
    targets, kinds, froms, starts = batch
    return targets[used:], kinds[used:], froms[used:], starts[used:]
