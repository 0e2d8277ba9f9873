"""Features and ridge of the tangent field, chosen by prediction of edges that were left out."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from skillfold.manifold.descent import Metric, descend, metric_at
from skillfold.manifold.features import Features
from skillfold.manifold.shapes import Progress, spread_out
from skillfold.manifold.table import Trial
from skillfold.manifold.tangent import begin
from skillfold.manifold.threads import in_turn
from skillfold.manifold.training import Problem, alignment, field_at_edges

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

KERNELS = (5, 10, 20, 40, 80)
RIDGES = (1e-6, 1e-5, 1e-4)
PLAIN_RIDGE = 1e-5  # at which the number of kernels is compared
EDGES = 2000  # that a cross-validation of the field looks at
WINSOR = 0.98  # errors beyond this quantile count as the quantile: edges and folds must not decide
FEW_EDGES, FEW_FOLDS = 600, 1  # where only the ridge is asked for
TRIAL_ITERATIONS = 10  # at the plain ridge,
FURTHER_ITERATIONS = 4  # and from there at each
SOLVABLE = 1e-12  # of the field's mean square: a ridge by which columns that depend on each other do no harm
MEASURE = "held-out step off the field (smaller)"

T = TypeVar("T")


def _folds(edges: Indices, groups: Indices | None, seed: int) -> Indices:
    """Fold of each edge, 0 to 2: by whole recordings where there are three or more, else at random."""
    if groups is not None and len(np.unique(groups)) >= 3:
        return groups[edges[:, 0]] % 3
    return np.random.default_rng(seed).integers(0, 3, len(edges))


def _error(squares: Sequence[Array]) -> float:
    """Rms over all folds, winsorised."""
    errors = np.concatenate(squares)
    return float(np.sqrt(np.minimum(errors, np.quantile(errors, WINSOR)).mean()))


class _Trained(NamedTuple):
    """A field trained on all folds but one, and the edges of that one.

    Attributes:
        problem: of the other edges.
        weights: (d, K, D).
        values: (K, n) features at the midpoints of edges held out.
        steps: (D, n) along these.
    """

    problem: Problem
    weights: Array
    values: Array
    steps: Array

    def squares(self) -> Array:
        """Squared part of steps held out that the field does not span; (n,)."""
        field = field_at_edges(self.values, self.weights)
        return (alignment(field, self.steps, SOLVABLE * float((field**2).mean()))[1] ** 2).sum(0)

    def metric(self) -> Metric:
        """The metric for going on from here."""
        return metric_at(self.problem, self.weights)

    def squares_at(self, ridge: float, metric: Metric) -> Array:
        """The same after some more iterations of training, at another ridge."""
        problem = replace(self.problem, ridge=ridge)
        weights = descend(problem, self.weights, FURTHER_ITERATIONS, metric)[0]
        return self._replace(weights=weights).squares()


def _trained(
    samples: Array, edges: Indices, frames: Array, held: Flags, features: Features, ridge: float
) -> _Trained:
    """A field trained for some iterations on all edges but those held out."""
    problem, _, start = begin(features, samples, edges[~held], frames, ridge)
    weights = descend(problem, start, TRIAL_ITERATIONS)[0]
    first, second = samples[edges[held]].swapaxes(0, 1)
    values = np.ascontiguousarray(features((first + second) / 2).T)
    return _Trained(problem, weights, values, np.ascontiguousarray((second - first).T))


class _Comparison(NamedTuple):
    """Cross-validation of fields on some edges, in parallel.

    Attributes:
        samples, edges, frames: as in `choose_field`; edges are those looked at.
        held: (F, E) edges that each fold leaves out.
        jobs: workers.
        progress: called with the share of all trainings done.
    """

    samples: Array
    edges: Indices
    frames: Array
    held: Sequence[Flags]
    jobs: int
    progress: Callable[[float], None]

    def plain(self, placed: Sequence[Features], ridge: float, share: float) -> list[list[_Trained]]:
        """Fields at one ridge, of each features by fold; progress goes up to a share."""
        data = self.samples, self.edges, self.frames
        cases = [(*data, out, features, ridge) for features in placed for out in self.held]
        found = self._told(in_turn(_trained, cases, self.jobs), len(cases), 0.0, share)
        n = len(self.held)
        return [found[i : i + n] for i in range(0, len(found), n)]

    def ridges(self, trained: Sequence[_Trained], ridges: Sequence[float], share: float) -> list[float]:
        """Error at each ridge when training goes on with it; progress goes from a share to one."""
        metrics = list(in_turn(_Trained.metric, [(one,) for one in trained], self.jobs))
        cases = [(one, ridge, metric) for ridge in ridges for one, metric in zip(trained, metrics, strict=True)]
        squares, n = in_turn(_Trained.squares_at, cases, self.jobs), len(trained)
        found = self._told(squares, len(cases), share, 1.0)
        return [_error(found[i : i + n]) for i in range(0, len(found), n)]

    def _told(self, results: Iterator[T], count: int, begin: float, end: float) -> list[T]:
        found: list[T] = []
        for result in results:
            found.append(result)
            self.progress(begin + (end - begin) * len(found) / count)
        return found


def choose_field(
    samples: Array,
    edges: Indices,
    frames: Array,
    groups: Indices | None,
    kernels: int | None,
    ridge: float | None,
    seed: int,
    jobs: int,
    progress: Progress,
) -> tuple[Features, float, list[Trial]]:
    """Features and ridge of the tangent field by threefold cross-validation, and all trials.

    Where the number of kernels is given, one fold of three tells the ridge.

    Args:
        samples: (N, D), denoised.
        edges: (E, 2).
        frames: (N, D, d), aligned tangents to start training from.
        groups: recording of each sample or None.
        kernels, ridge: K and λ as fixed by the user, or None.
        seed: of folds and centres.
        jobs: workers; joblib's own backends (Dask, Ray) take over where one is set.
        progress: called with the stage and its share done.
    """
    counts = [kernels] if kernels else [k for k in KERNELS if k <= max(5, len(samples) // 3)]
    placed = [Features.place(samples, k, seed) for k in counts]
    plain = ridge or PLAIN_RIDGE
    if len(placed) == 1 and ridge:  # nothing to choose: of few samples no more kernels than the fewest are tried
        return placed[0], ridge, []
    # Where K is known, only λ is asked for, which matters little.
    looked_at = edges[spread_out(len(edges), FEW_EDGES if kernels else EDGES, seed)]
    stage = "choosing the tangent field"
    progress(stage, 0.0)
    folds = _folds(looked_at, groups, seed)
    held = [folds == fold for fold in np.unique(folds)[: FEW_FOLDS if kernels else None]]
    workers = 1 if kernels else jobs  # the few short trainings for a ridge are done sooner by one
    compare = _Comparison(samples, looked_at, frames, held, workers, lambda share: progress(stage, share))
    trained = compare.plain(placed, plain, 1.0 if ridge else 0.7)
    errors, best = [], 0
    if len(placed) > 1:
        errors = [_error([one.squares() for one in folds]) for folds in trained]
        best = int(np.argmin(errors))
    candidates = [(features, plain) for features in placed]
    if not ridge:
        others = [value for value in RIDGES if value != plain]
        # All go on from the same field for as long, the plain one too.
        more = compare.ridges(trained[best], [plain, *others], 0.7)
        errors[best : best + 1] = more[:1]
        errors += more[1:]
        candidates += [(placed[best], value) for value in others]
    progress(stage, 1.0)
    taken = int(np.argmin(errors))
    trials = [
        Trial("field", f"{len(f.centres)} kernels, ridge {value:g}", error, MEASURE, i == taken)
        for i, ((f, value), error) in enumerate(zip(candidates, errors, strict=True))
    ]
    return *candidates[taken], trials
