"""What the user did not fix, chosen by prediction of what was left out: samples, edges, whole demonstrations."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from joblib import Parallel, delayed
from scipy.spatial import KDTree

from skillfold.manifold.anchors import held_out_residuals, nearest_others
from skillfold.manifold.features import Features
from skillfold.manifold.polynomials import monomials
from skillfold.manifold.table import Trial
from skillfold.manifold.tangent import train

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]
Progress = Callable[[str, float], None]

DEGREES = (1, 2, 3, 4)
MOST_TERMS = 40  # of a polynomial of degree 3 or more
GROWTH = 1.5  # from one neighbourhood size to the next
LARGEST = 600  # neighbourhood tried, for samples that are not many
SCREENED = 100  # samples that every candidate predicts
COMPARED = 1500  # samples that the better candidates predict
BETTER = 1.2  # times the least error: a candidate worth comparing
HOPELESS = 2.0  # times the least error of its degree: larger neighbourhoods only get worse
DOUBTED = 2.0  # standard errors within which a candidate counts as good as the best
BESIDE = 1  # recordings that should be within reach of each sample
ACROSS = 6.0  # times the distance to them that neighbourhoods of recordings span at least
WINSOR = 0.98  # errors beyond this quantile count as the quantile: edges and folds must not decide
KERNELS = (5, 10, 20, 40, 80)
RIDGES = (1e-6, 1e-5, 1e-4)
EDGES = 2000  # that a cross-validation of the field looks at
TRIAL_ITERATIONS = 8
PLAIN_RIDGE = 1e-5  # at which the number of kernels is compared


class Shape(NamedTuple):
    """Degree of the local polynomials and number of neighbours they are fitted to."""

    degree: int
    neighbours: int


def candidate_shapes(n_others: int, dim: int, largest: int, smallest: int = 1) -> list[Shape]:
    """Every degree with neighbourhoods from one and a half samples a coefficient up, none below `smallest`."""
    shapes = []
    for degree in DEGREES:
        terms = len(monomials(dim, degree).parents)
        k = max(int(np.ceil(1.5 * terms)) + 1, smallest)
        if degree > 2 and terms > MOST_TERMS:
            break
        while k <= min(largest, n_others):
            shapes.append(Shape(degree, k))
            k = int(np.ceil(GROWTH * k))
    return shapes or [Shape(1, n_others)]


def neighbours_across(samples: Array, groups: Indices, seed: int) -> int:
    """How many samples a neighbourhood needs to reach across recordings.

    Recordings of one motion run side by side. Neighbourhoods that hold one of them alone would model each as a
    manifold of its own, which left-out recordings do not punish: some recording is always near.
    """
    chosen = _spread_out(len(samples), SCREENED, seed)
    members = np.unique(groups)
    distance = np.array([KDTree(samples[groups == g]).query(samples[chosen])[0] for g in members])
    beside = np.sort(distance, axis=0)[min(BESIDE, len(members) - 1)]
    tree = KDTree(samples)
    counts = [len(tree.query_ball_point(samples[i], ACROSS * r)) for i, r in zip(chosen, beside, strict=True)]
    return int(np.median(counts))


def _squared_errors(
    samples: Array, chosen: Indices, others: Indices, dim: int, shapes: Sequence[Shape], jobs: int
) -> Array:
    """(n_shapes, n_chosen), winsorised."""
    work = (
        delayed(held_out_residuals)(samples, chosen, others[:, : shape.neighbours], dim, shape.degree)
        for shape in shapes
    )
    errors = np.array(Parallel(n_jobs=jobs, prefer="threads")(work)) ** 2
    return np.minimum(errors, np.quantile(errors, WINSOR, axis=1, keepdims=True))


def _spread_out(n: int, count: int, seed: int) -> Indices:
    return np.sort(np.random.default_rng(seed).choice(n, min(n, count), replace=False))


def choose_shape(
    samples: Array, groups: Indices | None, dim: int, largest: int, seed: int, jobs: int, progress: Progress
) -> tuple[Shape, float, list[Trial]]:
    """Shape of the local surfaces, its held-out rms residual, and all trials.

    Among candidates that cannot be told from the best (by the standard error of the paired difference) the one
    with most samples a coefficient is taken: it averages noise best.

    Args:
        samples: (N, D).
        groups: recording of each sample, then recordings are left out whole; None leaves single samples out.
        dim: d.
        largest: neighbourhood.
        seed: of the choice of samples predicted.
        jobs: threads.
        progress: called with the stage and its share done.
    """
    smallest = len(samples) - 1 if groups is None else len(samples) - np.bincount(groups).max()
    across = 1 if groups is None else min(neighbours_across(samples, groups, seed), smallest)
    shapes = candidate_shapes(int(smallest), dim, largest, across)
    progress("choosing the local surfaces", 0.0)
    shapes, first = _screened(samples, groups, dim, shapes, seed, jobs)
    progress("choosing the local surfaces", 0.4)
    good = [s for s, error in zip(shapes, first, strict=True) if error <= BETTER**2 * first.min()]
    chosen = _spread_out(len(samples), COMPARED, seed)
    others = nearest_others(samples, chosen, max(s.neighbours for s in good), groups)
    errors = _squared_errors(samples, chosen, others, dim, good, jobs)
    best = _smoothest_of_best(good, errors, dim)
    means = dict(zip(shapes, first, strict=True)) | dict(zip(good, errors.mean(1), strict=True))
    trials = [
        Trial(
            "surface",
            f"degree {s.degree}, {s.neighbours} neighbours",
            float(np.sqrt(means[s])),
            "held-out residual (smaller)",
            s == best,
        )
        for s in shapes
    ]
    return best, float(np.sqrt(means[best])), trials


def _screened(
    samples: Array, groups: Indices | None, dim: int, shapes: Sequence[Shape], seed: int, jobs: int
) -> tuple[list[Shape], Array]:
    """Shapes worth a look and their mean squared errors at a few samples.

    Of each degree neighbourhoods are tried from small to large, until they are clearly too large.
    """
    chosen = _spread_out(len(samples), SCREENED, seed)
    others = nearest_others(samples, chosen, max(s.neighbours for s in shapes), groups)
    ladders = [[s for s in shapes if s.degree == degree] for degree in sorted({s.degree for s in shapes})]
    climbs: Any = Parallel(n_jobs=jobs, prefer="threads")(
        delayed(_climb)(samples, chosen, others, dim, ladder) for ladder in ladders
    )
    tried = [pair for climb in climbs for pair in climb]
    return [s for s, _ in tried], np.array([error for _, error in tried])


def _climb(
    samples: Array, chosen: Indices, others: Indices, dim: int, ladder: Sequence[Shape]
) -> list[tuple[Shape, float]]:
    tried: list[tuple[Shape, float]] = []
    for shape in ladder:
        tried.append((shape, float(_squared_errors(samples, chosen, others, dim, [shape], 1).mean())))
        if tried[-1][1] > HOPELESS**2 * min(error for _, error in tried):
            break
    return tried


def _smoothest_of_best(shapes: Sequence[Shape], errors: Array, dim: int) -> Shape:
    least = errors[int(errors.mean(1).argmin())]
    difference = errors - least
    doubt = difference.std(1) / np.sqrt(errors.shape[1])
    equal = [s for s, d, e in zip(shapes, difference.mean(1), doubt, strict=True) if d <= DOUBTED * e]
    return max(equal, key=lambda s: s.neighbours / len(monomials(dim, s.degree).parents))


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
        kernels, ridge: fixed by the user, or None.
        seed: of folds and centres.
        jobs: workers; joblib's own backends (Dask, Ray) take over where one is set.
        progress: called with the stage and its share done.
    """
    counts = [kernels] if kernels else [k for k in KERNELS if k <= max(5, len(samples) // 3)]
    ridges = [ridge] if ridge else list(RIDGES)
    placed = {k: Features.place(samples, k, seed) for k in counts}
    if len(counts) == len(ridges) == 1:
        return placed[counts[0]], ridges[0], []
    looked_at = edges[_spread_out(len(edges), EDGES, seed)]
    folds = _folds(looked_at, groups, seed)
    progress("choosing the tangent field", 0.0)

    def errors(pairs: Sequence[tuple[int, float]], begin: float, end: float) -> dict[tuple[int, float], float]:
        batches = Parallel(n_jobs=jobs, prefer="threads", return_as="generator")(
            delayed(_field_error)(samples, looked_at, frames, folds, placed[k], r, seed) for k, r in pairs
        )
        found = {}
        for done, (pair, error) in enumerate(zip(pairs, batches, strict=True), 1):
            found[pair] = error
            progress("choosing the tangent field", begin + (end - begin) * done / len(pairs))
        return found

    # The ridge matters little, so the number of kernels is chosen first.
    plain = ridges[0] if len(ridges) == 1 else PLAIN_RIDGE
    found = errors([(k, plain) for k in counts], 0.0, 0.7)
    best = min(found, key=lambda pair: found[pair])[0]
    found |= errors([(best, r) for r in ridges if (best, r) not in found], 0.7, 1.0)
    taken = min(found, key=lambda pair: found[pair])
    progress("choosing the tangent field", 1.0)
    trials = [
        Trial("field", f"{k} kernels, ridge {r:g}", error, "held-out step off the field (smaller)", (k, r) == taken)
        for (k, r), error in found.items()
    ]
    return placed[taken[0]], taken[1], trials
