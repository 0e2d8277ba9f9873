"""Training of the tangent field to its end: a quasi-Newton method on the weights, with ε eliminated.

Alternating least squares holds ε while it moves H, so turning or stretching H's columns along the manifold, which
costs next to nothing, takes it hundreds of iterations. With ε = ε(W) put in (variable projection) the objective's
curvature is about

    Σ_e ε_e ε_e' ⊗ f_e f_e' ⊗ Q_e + λ I ⊗ L ⊗ I,    Q = I − H (H'H + λI)⁻¹ H',

which knows that only motion along normals counts. Averaged over the directions of ε it is one matrix of K D rows
for all columns of H: the metric in which limited-memory BFGS starts. It neglects curvature in proportion to the
misfit; that share of the metric of alternating least squares, which has no Q, is added.
"""

from collections import deque
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from skillfold.manifold.kernels.alignment import across
from skillfold.manifold.training import (
    Problem,
    alignment,
    balance,
    factorised,
    field_at_edges,
    objective,
    solved,
)

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

MEMORY = 10  # pairs of steps and changes of the gradient
RENEWED = 20  # iterations after which the metric is worked out anew
METRIC_EDGES = 1000  # it is averaged over
WINDOW, SETTLED = 5, 3e-2  # training ends where so many iterations decrease the objective by no more than this share
SUFFICIENT = 1e-4  # of the decrease that the slope promises
SHORTEST = 1e-6  # step: where not even this one decreases the objective, rounding rules


class _Point(NamedTuple):
    """Weights, the objective there with ε put in, its gradient (half of it, times E), ε, and Hε − Δ."""

    weights: Array
    value: float
    gradient: Array
    eps: Array
    misfit: Array


def _point(problem: Problem, weights: Array) -> _Point:
    field = field_at_edges(problem.values, weights)
    eps, misfit = alignment(field, problem.steps, problem.ridge)
    outer = np.multiply(eps[:, None], misfit, out=field)  # the field's memory: it is large, and needed no more
    gradient = np.swapaxes((outer.reshape(-1, eps.shape[1]) @ problem.values.T).reshape(*field.shape[:2], -1), 1, 2)
    gradient = gradient + problem.ridge * (problem.smoothness @ weights)
    return _Point(weights, objective(problem, weights, eps, misfit), gradient, eps, misfit)


@dataclass(frozen=True)
class Metric:
    """Cholesky factor of the mean curvature, (K D, K D)."""

    factor: Array

    @staticmethod
    def at(problem: Problem, point: _Point) -> "Metric":
        """The metric for descents from about here, of problems that differ in the ridge alone."""
        d, E = point.eps.shape
        thin = slice(None, None, -(-E // METRIC_EDGES))
        values, eps = np.ascontiguousarray(problem.values[:, thin]), point.eps[:, thin]
        (K, n), D = values.shape, len(problem.steps)
        weights = E / n * (eps**2).sum(0) / d
        neglected = float((point.misfit**2).sum() / (problem.steps**2).sum())
        # Both factors are symmetric: of each, half is enough.
        Q, (k, m) = np.empty((D * (D + 1) // 2, n)), np.triu_indices(K)
        across(field_at_edges(values, point.weights), problem.ridge, neglected, weights, Q)
        halves = (values[k] * values[m]) @ Q.T
        matrix = halves[_places(K)[:, None, :, None], _places(D)[None, :, None, :]]
        for c in range(D):
            matrix[:, c, :, c] += problem.ridge * problem.smoothness
        return Metric(factorised(matrix.reshape(K * D, K * D)))

    def solve(self, gradient: Array) -> Array:
        """The step (d, K, D) against a gradient, in this metric the steepest."""
        return solved(self.factor, gradient.reshape(len(gradient), -1).T).T.reshape(gradient.shape)


@lru_cache(maxsize=16)
def _places(n: int) -> Indices:
    """Where each entry of a symmetric matrix (n, n) stands in its upper half, row by row."""
    rows, columns = np.triu_indices(n)
    places = np.empty((n, n), np.int64)
    places[rows, columns] = places[columns, rows] = np.arange(len(rows))
    return places


class _Pair(NamedTuple):
    """A step, the change of the gradient along it, their product, and that change solved for in the metric."""

    step: Array
    change: Array
    product: float
    solved: Array


def _direction(pairs: deque[_Pair], gradient: Array, solved: Array) -> Array:
    """The two loops of limited-memory BFGS, from the gradient and what it gives in the metric.

    The metric is linear: what is left of the gradient after the first loop need not be solved for again.
    """
    rest, found, shares = gradient.copy(), solved.copy(), []
    for pair in reversed(pairs):
        shares.append(np.vdot(pair.step, rest) / pair.product)
        rest -= shares[-1] * pair.change
        found -= shares[-1] * pair.solved
    if pairs:
        last = pairs[-1]
        found *= last.product / np.vdot(last.change, last.solved)
    for pair, share in zip(pairs, reversed(shares), strict=True):
        found += pair.step * (share - np.vdot(pair.change, found) / pair.product)
    return -found


def _search(problem: Problem, here: _Point, direction: Array) -> _Point | None:
    """A point along the direction where the objective is lower by enough; None if there is none."""
    slope = 2.0 * float(np.vdot(here.gradient, direction)) / here.eps.shape[1]
    length = 1.0
    while slope < 0.0 and length > SHORTEST:
        there = _point(problem, here.weights + length * direction)
        rise = there.value - here.value
        if rise <= SUFFICIENT * length * slope:
            return there
        # The least value of the parabola through what is known.
        length *= min(max(-slope * length / (2.0 * (rise - slope * length)), 0.1), 0.5)
    return None


def metric_at(problem: Problem, weights: Array) -> Metric:
    """The metric at some weights."""
    return Metric.at(problem, _point(problem, weights))


def descend(
    problem: Problem, weights: Array, iterations: int, metric: Metric | None = None
) -> tuple[Array, list[float], bool]:
    """Weights after at most so many iterations, the objective after each, and whether it settled.

    The objective falls in every iteration. The metric to begin with is worked out unless it is given.
    """
    eps = alignment(field_at_edges(problem.values, weights), problem.steps, problem.ridge)[0]
    here = _point(problem, balance(problem, weights, eps)[0])
    values, pairs = [here.value], deque[_Pair](maxlen=MEMORY)
    metric = metric or Metric.at(problem, here)
    steepest = metric.solve(here.gradient)
    while len(values) <= iterations:
        if len(values) % RENEWED == 0:
            metric = Metric.at(problem, here)
            steepest = metric.solve(here.gradient)
            pairs = deque((p._replace(solved=metric.solve(p.change)) for p in pairs), maxlen=MEMORY)
        there = _search(problem, here, _direction(pairs, here.gradient, steepest))
        if there is None:
            return here.weights, values, True
        before, steepest = steepest, metric.solve(there.gradient)
        step, change = there.weights - here.weights, there.gradient - here.gradient
        if (product := float(np.vdot(step, change))) > 0.0:
            pairs.append(_Pair(step, change, product, steepest - before))
        here = there
        values.append(here.value)
        if len(values) > WINDOW and values[-1 - WINDOW] - values[-1] <= SETTLED * values[-1]:
            return here.weights, values, True
    return here.weights, values, False
