"""Where on whole demonstrations given states lie: whole motions, part-way ends, via points, direction.

All costs are squared distances over the squared spread of the demonstrations, as in twice a negative log
likelihood, so that they can be added up and compared.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from skillfold.manifold.route_models import IntArray, hats
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
# Over what share of the phases error covariances are averaged, and how many demonstrations' worth of an
# isotropic one they are shrunk toward.
COVARIANCE_WINDOW = 0.1
ISOTROPIC = 5.0


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

    @property
    def whole(self) -> bool:
        """Whether the ends are those of a whole motion."""
        return bool(self.phases[0] == 0.0 and self.phases[1] == 1.0)


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


def locate_between(curves: Array, route: Array, errors: Array, asked: Array) -> Array:
    """Phases of the asked states, start and goal first and last, between located ends.

    Two rulers are averaged: the route that the ends alone would make, with the covariance of its errors, by
    which a state beside the route may also be ahead of it; and the demonstrations one by one, their ends
    corrected, which tell between several ways.

    Args:
        curves: (n, n_phases, D), the demonstrations between the ends.
        route: (n_phases, D).
        errors: (n, n_phases, D), samples of its error.
        asked: (m, D).

    Returns:
        (m,), increasing from 0 to 1.
    """
    nodes = np.array([0, len(route) - 1])
    corrected = curves + hats(len(route), nodes) @ (asked[[0, -1]] - curves[:, nodes])
    squared = ((asked[None, :, None] - corrected[:, None]) ** 2).sum(axis=3)
    costs = (surprise(asked[:, None] - route, errors) + misfit(squared, squared_spread(corrected).mean())) / 2.0
    columns, _ = in_order(with_whole_ends(costs[None]))
    return between_columns(costs, columns[0]) / nodes[1]


def surprise(gaps: Array, errors: Array) -> Array:
    """Twice the negative log likelihood of gaps (m, n_phases, D) from a route with such errors: (m, n_phases).

    The covariance of the errors (n, n_phases, D), averaged over neighbouring phases, is shrunk toward an
    isotropic one, as few demonstrations cannot tell it well.
    """
    n, n_phases, n_dims = errors.shape
    summed = np.einsum("nsi,nsj->sij", errors, errors)
    summed = gaussian_filter1d(summed, COVARIANCE_WINDOW * n_phases, axis=0, mode="nearest")
    variance = np.trace(summed, axis1=1, axis2=2) / (n * n_dims)
    variance += 0.01 * variance.mean() + LEAST_SQUARED_SPREAD / n_dims
    covariance = (summed + ISOTROPIC * variance[:, None, None] * np.eye(n_dims)) / (n + ISOTROPIC)
    inverse = np.linalg.inv(covariance)
    return np.einsum("msi,sij,msj->ms", gaps, inverse, gaps, optimize=True) - np.linalg.slogdet(inverse)[1]


def between_columns(costs: Array, columns: IntArray) -> Array:
    """Expected columns (m,) near the given, increasing ones, whose order they keep; first and last unchanged."""
    refined = columns.astype(np.float64)
    for row in range(1, len(columns) - 1):
        room = (np.diff(columns[row - 1 : row + 2]).min() - 1) // 2
        around = columns[row] + np.arange(-room, room + 1)
        weights = np.exp(0.5 * (costs[row, columns[row]] - costs[row, around]).clip(max=0.0))
        refined[row] = weights @ around / weights.sum()
    return refined
