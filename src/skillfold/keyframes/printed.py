"""The printed algorithm around its kernels (see `kernels.printed`), with what both variants share."""

from functools import cache
from time import perf_counter

import numpy as np

from skillfold.jit import compile_for
from skillfold.keyframes.grown import Array, Found, Grown, Question, Targets, facing_path, length_of, way_to
from skillfold.keyframes.kernels import printed as kernel
from skillfold.keyframes.kernels import rrtstar

BATCH = 8  # targets between two looks at the clock
ROOM = 20_000  # nodes
TURN = 2 * np.pi


@cache
def prepare_printed() -> None:
    """Have the compiled loop ready, once."""
    table, rows = np.empty(0, np.int64), np.empty((0, 0))
    compile_for(kernel.grow_printed, table, table, rows, rows)


def search_printed(
    question: Question, start: Array, targets: Targets, begun: float, deadline: float, first: bool, seed: int
) -> Found:
    """A way as algorithm 3 finds it; arguments as of `rrtstar.search`, but that it always stops at the first."""
    rng = np.random.default_rng(seed)
    tree, dof = Grown(ROOM, len(start)), len(start)
    rrtstar.plant(question.table.entries, tree.table.entries, start)
    found = Found(np.empty((0, dof)))
    while perf_counter() < deadline and tree.count < ROOM and not len(tree.goals()):
        drawn = targets.draw(rng, BATCH)[0]
        anywhere = rng.uniform(0.0, TURN, (BATCH, dof))
        found.iterations += kernel.grow_printed(question.table.entries, tree.table.entries, drawn, anywhere)
        question.raise_errors()
    found.nodes, found.tree, goals = tree.count, tree.copied(), tree.goals()
    if len(goals):
        way = tree.nodes.q[way_to(tree, int(goals[0]))]
        found.path = facing_path(way if len(way) > 1 else np.repeat(way, 2, axis=0), question.turning)
        found.cost, found.first = length_of(found.path), perf_counter() - begun
        found.costs.append((found.first, found.cost))
    return found
