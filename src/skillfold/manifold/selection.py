"""Features of the tangent field, chosen by prediction of edges that were left out."""

from typing import Any

import numpy as np
from joblib import Parallel, delayed

from skillfold.manifold.features import Features
from skillfold.manifold.shapes import Progress, spread_out
from skillfold.manifold.table import Trial
from skillfold.manifold.tangent import train

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

KERNELS = (5, 10, 20, 40, 80)
EDGES = 2000  # that a cross-validation of the field looks at
WINSOR = 0.98  # errors beyond this quantile count as the quantile: edges and folds must not decide
TRIAL_ITERATIONS = 10


def _folds(edges: Indices, groups: Indices | None, seed: int) -> Indices:
    """Fold of each edge, 0 to 2: by whole recordings where there are three or more, else at random."""
    if groups is not None and len(np.unique(groups)) >= 3:
        return groups[edges[:, 0]] % 3
    return np.random.default_rng(seed).integers(0, 3, len(edges))


def _field_error(
    samples: Array,
    edges: Indices,
    frames: Array,
    folds: Indices,
    features: Features,
    ridge: float,
    seed: int,
) -> float:
    """Mean over folds of the rms part of held-out steps that a field trained on the others does not span."""
    squares = []
    for fold in np.unique(folds):
        kept, held = edges[folds != fold], edges[folds == fold]
        field = train(features, samples, kept, frames, ridge, seed, iterations=TRIAL_ITERATIONS, restarts=0)
        a, b = samples[held[:, 0]], samples[held[:, 1]]
        squares.append(field.residual((a + b) / 2, b - a) ** 2)
    errors = np.concatenate(squares)
    return float(np.sqrt(np.minimum(errors, np.quantile(errors, WINSOR)).mean()))


def choose_field(
    samples: Array,
    edges: Indices,
    frames: Array,
    groups: Indices | None,
    kernels: int | None,
    ridge: float,
    seed: int,
    jobs: int,
    progress: Progress,
) -> tuple[Features, list[Trial]]:
    """Features of the tangent field by threefold cross-validation, and all trials.

    Args:
        samples: (N, D), denoised.
        edges: (E, 2).
        frames: (N, D, d), aligned tangents to start training from.
        groups: recording of each sample or None.
        kernels: fixed by the user, or None.
        ridge: λ.
        seed: of folds and centres.
        jobs: workers; joblib's own backends (Dask, Ray) take over where one is set.
        progress: called with the stage and its share done.
    """
    if kernels:
        return Features.place(samples, kernels, seed), []
    placed = [Features.place(samples, k, seed) for k in KERNELS if k <= max(5, len(samples) // 3)]
    looked_at = edges[spread_out(len(edges), EDGES, seed)]
    folds = _folds(looked_at, groups, seed)
    stage = "choosing the tangent field"
    progress(stage, 0.0)
    batches: Any = Parallel(n_jobs=jobs, prefer="threads", return_as="generator")(
        delayed(_field_error)(samples, looked_at, frames, folds, features, ridge, seed) for features in placed
    )
    errors: list[float] = []
    for error in batches:
        errors.append(error)
        progress(stage, len(errors) / len(placed))
    best = int(np.argmin(errors))
    trials = [
        Trial("field", f"{len(f.centres)} kernels", error, "held-out step off the field (smaller)", i == best)
        for i, (f, error) in enumerate(zip(placed, errors, strict=True))
    ]
    return placed[best], trials
