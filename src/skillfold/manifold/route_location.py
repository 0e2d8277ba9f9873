"""Where on whole demonstrations given states lie: whole motions, part-way ends, via points, direction.

All costs are squared distances over the squared spread of the demonstrations, as in twice a negative log
likelihood, so that they can be added up and compared.
"""

from dataclasses import dataclass

import numpy as np

from skillfold.manifold.route_models import IntArray
from skillfold.motion import Array

# A whole motion is the simplest reading: part-way ends must fit clearly better, and by 3 spreads.
PART_WAY_COST = 9.0
PART_WAY_FACTOR = 1.5
# Forward is the simpler direction; a circle, say, leads from each state to each other one both ways.
REVERSED_COST = 2.0
# At equal states the phases of two demonstrations differ by about a twentieth.
PHASE_SPREAD = 0.05
# Curves are scaled to unit rms radius: no spread is taken to be below a hundredth of it.
LEAST_SQUARED_SPREAD = 1e-4


@dataclass(frozen=True)
class Location:
    """Phases of the asked ends.

    Attributes:
        phases: (2,) increasing in [0, 1], on which the demonstrations agree.
        own: (n, 2), each demonstration's own.
        reversed: whether they count from the end of the demonstrations.
        supported: distance of the asked ends from the nearest demonstration there, in spreads.
    """

    phases: Array
    own: Array
    reversed: bool
    supported: float


def squared_spread(curves: Array) -> Array:
    """Mean squared distance from a demonstration to the nearest other one, at each phase: (n_phases,).

    The nearest one and not the mean, because demonstrations may take several ways. A third of the average
    over the phases is mixed in: where all demonstrations meet in one point, a spread of nothing would make
    every other state infinitely far.
    """
    nearest = np.zeros(curves.shape[1])
    for i, curve in enumerate(curves):
        nearest += ((np.delete(curves, i, axis=0) - curve) ** 2).sum(axis=2).min(axis=0)
    nearest /= len(curves)
    return (2.0 * nearest + nearest.mean()) / 3.0 + LEAST_SQUARED_SPREAD


def misfit(squared: Array, spread: Array | float) -> Array:
    """How badly each asked state fits the demonstrations at each phase: (m, n_phases).

    Twice the negative log of a mixture of one Gaussian around each demonstration.

    Args:
        squared: (n, m, n_phases), squared distances.
        spread: (n_phases,) or a scalar, squared.
    """
    scaled = squared / spread
    least = scaled.min(axis=0)
    return least - 2.0 * np.log(np.exp(0.5 * (least - scaled)).mean(axis=0))


def in_order(costs: Array) -> tuple[IntArray, Array]:
    """Increasing columns, one for each row, whose costs have the least sum (dynamic programming).

    Args:
        costs: (b, m, n_phases), b problems at once; infinite where a column is forbidden.

    Returns:
        Columns (b, m) and their summed costs (b,).
    """
    best, back = costs[:, 0], []
    for row in range(1, costs.shape[1]):
        least = np.minimum.accumulate(best, axis=1)
        where = np.where(best <= least, np.arange(best.shape[1]), 0)
        back.append(np.maximum.accumulate(where, axis=1))
        best = costs[:, row].copy()
        best[:, 1:] += least[:, :-1]
        best[:, 0] = np.inf
    problems = np.arange(len(costs))
    chosen = [best.argmin(axis=1)]
    for previous in reversed(back):
        chosen.append(previous[problems, chosen[-1] - 1])
    return np.stack(chosen[::-1], axis=1), best.min(axis=1)


def with_whole_ends(costs: Array) -> Array:
    """The same costs (..., m, n_phases) with the first row held at the first phase, the last at the last."""
    held = costs.copy()
    held[..., 0, 1:] = np.inf
    held[..., -1, :-1] = np.inf
    return held


def agreed(squared: Array, spread: Array) -> tuple[IntArray, bool, bool]:
    """Columns on which the demonstrations agree, whether the motion is whole, and whether it is reversed."""
    free = misfit(squared, float(spread.mean()))
    # The ends of a whole motion are judged by the spread there: people start here and there, but end in one
    # place. To compare phases with each other, one spread for all serves better.
    whole = free.copy()
    whole[[0, -1]] = misfit(squared[:, [0, -1]], spread)
    both = np.stack([free, free[:, ::-1]])
    columns, cost = in_order(both)
    whole_columns, whole_cost = in_order(with_whole_ends(np.stack([whole, whole[:, ::-1]])))
    part_cost = PART_WAY_FACTOR * cost + PART_WAY_COST
    is_whole = whole_cost <= part_cost
    least = np.minimum(whole_cost, part_cost)
    turned = int(least[1] + REVERSED_COST < least[0])
    chosen = whole_columns if is_whole[turned] else columns
    return chosen[turned], bool(is_whole[turned]), bool(turned)


def locate(curves: Array, spread: Array, asked: Array) -> Location:
    """Locate start and goal of the asked states (m, D) on demonstrations (n, n_phases, D).

    First on all demonstrations together, and with the via points between them, which tells a state met twice,
    or an end from a crossing; then on each demonstration by itself, near the common answer.
    """
    squared = ((asked[None, :, None] - curves[:, None]) ** 2).sum(axis=3)
    nodes, whole, turned = agreed(squared, spread)
    if turned:
        squared, spread = squared[:, :, ::-1], spread[::-1]
    squared, nodes = squared[:, [0, -1]], nodes[[0, -1]]
    last = curves.shape[1] - 1
    apart = (np.arange(last + 1) - nodes[:, None]) / (last * PHASE_SPREAD)
    costs = squared / spread.mean() + apart**2
    own, _ = in_order(with_whole_ends(costs) if whole else costs)
    nearest = squared[:, [0, 1], nodes].min(axis=0) / spread[nodes]
    return Location(nodes / last, own / last, turned, float(np.sqrt(nearest.max())))


def locate_between(route: Array, spread: Array, asked: Array) -> Array:
    """Phases of the asked states, start and goal first and last, on the route that the ends alone would make.

    That route is a better ruler than the demonstrations, whose ends lie elsewhere.

    Args:
        route: (n_phases, D).
        spread: (n_phases,), its standard deviation.
        asked: (m, D).

    Returns:
        (m,), increasing from 0 to 1.
    """
    variance = spread**2 + 0.01 * (spread**2).mean() + LEAST_SQUARED_SPREAD
    costs = ((asked[:, None] - route) ** 2).sum(axis=2) / variance
    columns, _ = in_order(with_whole_ends(costs[None]))
    return columns[0] / (len(route) - 1)
