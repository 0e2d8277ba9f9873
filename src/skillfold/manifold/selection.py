"""Features and ridge of the tangent field, chosen by prediction of edges that were left out."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from joblib import Parallel, delayed

from skillfold.manifold.features import Features
from skillfold.manifold.shapes import Progress, spread_out
from skillfold.manifold.table import Trial
from skillfold.manifold.tangent import train

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

KERNELS = (5, 10, 20, 40, 80)
RIDGES = (1e-6, 1e-5, 1e-4)
PLAIN_RIDGE = 1e-5  # at which the number of kernels is compared
EDGES = 2000  # that a cross-validation of the field looks at
WINSOR = 0.98  # errors beyond this quantile count as the quantile: edges and folds must not decide
FEW_EDGES = 600  # where only the ridge is asked for
TRIAL_ITERATIONS = 10
MEASURE = "held-out step off the field (smaller)"

Candidate = tuple[Features, float]  # features and ridge


def _folds(edges: Indices, groups: Indices | None, seed: int) -> Indices:
    """Fold of each edge, 0 to 2: by whole recordings where there are three or more, else at random."""
    if groups is not None and len(np.unique(groups)) >= 3:
        return groups[edges[:, 0]] % 3
    return np.random.default_rng(seed).integers(0, 3, len(edges))


def _held_out(
    samples: Array, edges: Indices, frames: Array, held: Flags, features: Features, ridge: float, seed: int
) -> Array:
    """Squared part of held-out steps that a field trained on the other edges does not span; (held.sum(),)."""
    field = train(features, samples, edges[~held], frames, ridge, seed, iterations=TRIAL_ITERATIONS, restarts=0)
    a, b = samples[edges[held, 0]], samples[edges[held, 1]]
    return field.residual((a + b) / 2, b - a) ** 2


def _error(squares: Sequence[Array]) -> float:
    """Rms over all folds, winsorised."""
    errors = np.concatenate(squares)
    return float(np.sqrt(np.minimum(errors, np.quantile(errors, WINSOR)).mean()))


class _Comparison(NamedTuple):
    """Threefold cross-validation of fields on some edges, in parallel.

    Attributes:
        samples, edges, frames: as in `choose_field`; edges are those looked at.
        folds: (E,) fold of each edge.
        seed: of the trainings.
        jobs: workers.
        progress: called with the share of all candidates done.
    """

    samples: Array
    edges: Indices
    frames: Array
    folds: Indices
    seed: int
    jobs: int
    progress: Callable[[float], None]

    def errors(self, candidates: Sequence[Candidate], begin: float, end: float) -> list[float]:
        """Held-out error of each candidate; progress goes from `begin` to `end`."""
        folds = np.unique(self.folds)
        trainings: Any = Parallel(n_jobs=self.jobs, prefer="threads", return_as="generator")(
            delayed(_held_out)(self.samples, self.edges, self.frames, self.folds == fold, *candidate, self.seed)
            for candidate in candidates
            for fold in folds
        )
        found: list[Array] = []
        for squares in trainings:
            found.append(squares)
            self.progress(begin + (end - begin) * len(found) / (len(folds) * len(candidates)))
        return [_error(found[i : i + len(folds)]) for i in range(0, len(found), len(folds))]


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
    compare = _Comparison(
        samples, looked_at, frames, _folds(looked_at, groups, seed), seed, jobs, lambda share: progress(stage, share)
    )
    ridges = [] if ridge else [value for value in RIDGES if value != plain]
    candidates, errors = [(features, plain) for features in placed], list[float]()
    if len(placed) > 1:
        errors = compare.errors(candidates, 0.0, 0.7)
        placed = [placed[int(np.argmin(errors))]]
    candidates += [(placed[0], value) for value in ridges]
    if ridges:
        errors += compare.errors(candidates[len(errors) :], 0.7 if errors else 0.0, 1.0)
    progress(stage, 1.0)
    taken = int(np.argmin(errors))
    trials = [
        Trial("field", f"{len(f.centres)} kernels, ridge {value:g}", error, MEASURE, i == taken)
        for i, ((f, value), error) in enumerate(zip(candidates, errors, strict=True))
    ]
    return *candidates[taken], trials
