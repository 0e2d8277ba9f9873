"""Degree and neighbourhood of the local surfaces, chosen by prediction of samples that were left out."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from skillfold.manifold.anchors import SAMPLES_A_TERM, held_out_residuals, nearest_others
from skillfold.manifold.nearest import nearest
from skillfold.manifold.polynomials import terms_of
from skillfold.manifold.table import Trial

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]
Progress = Callable[[str, float], None]

DEGREES = (1, 2, 3, 4)
MOST_TERMS = 40  # of a polynomial of degree 3 or more
GROWTH = 1.5  # from one neighbourhood size to the next
SNAPPED = 1.25  # times the next size: a degree that starts no later starts there
LARGEST = 1000  # neighbourhood tried, for samples that are not many
SCREENED = 100  # samples that every candidate predicts
COMPARED = 1500  # samples that the better candidates predict,
FEWER, WORK = 300, 350_000  # or as many as times the terms squared make so much, but not fewer than that
BETTER = 1.2  # times the least error: a candidate worth comparing,
WORSE = 3.0  # unless that many standard errors tell it from the best already
HOPELESS = 1.5  # times the least error of its degree: larger neighbourhoods only get worse
DOUBTED = 2.0  # standard errors within which a candidate counts as good as the best
SPAN = 6.0  # times the error that neighbourhoods reach: narrower ones show noise, no surface
WIDEST = 0.9  # of the widest span, where none reaches so far
BESIDE = 1  # recordings that should be within reach of each sample
ACROSS = 6.0  # times the distance to them that neighbourhoods of recordings span at least
USUAL = 0.75  # quantile of the errors above which a sample is none of the usual ones
AROUND = 50  # left-out samples around a place that its shape is chosen by
MOST = 0.5  # of the samples: where neighbourhoods of more contend, one shape serves everywhere
ALIKE = 1.25  # times the samples a coefficient: hardly smoother, as the next size of the same degree would be
RARE = 0.05  # share of samples that a high degree must serve: every anchor pays for its terms in every query
WINSOR = 0.98  # errors beyond this quantile count as the quantile: edges and folds must not decide


class Shape(NamedTuple):
    """Degree of the local polynomials and number of neighbours they are fitted to."""

    degree: int
    neighbours: int


def candidate_shapes(n_others: int, dim: int, largest: int, smallest: int = 1) -> list[Shape]:
    """Every degree with neighbourhoods from one and a half samples a coefficient up, none below `smallest`.

    Sizes are shared: fits of several degrees to one neighbourhood cost hardly more than one of them.
    """
    least = {}
    for degree in DEGREES:
        terms = terms_of(dim, degree)
        if degree > 2 and terms > MOST_TERMS:
            break
        least[degree] = max(int(np.ceil(SAMPLES_A_TERM * terms)) + 1, smallest)
    sizes = [min(least.values())]
    while sizes[-1] <= largest:
        k = int(np.ceil(GROWTH * sizes[-1]))
        sizes.append(min((low for low in least.values() if sizes[-1] < low <= SNAPPED * k), default=k))
    most = min(largest, n_others)
    shapes = [Shape(g, k) for g, low in least.items() for k in sizes if low <= k <= most]
    return shapes or [Shape(1, n_others)]


def neighbours_across(samples: Array, groups: Indices, seed: int) -> int:
    """How many samples a neighbourhood needs to reach across recordings.

    Recordings of one motion run side by side. Neighbourhoods that hold one of them alone would model each as a
    manifold of its own, which left-out recordings do not punish: some recording is always near.
    """
    chosen = spread_out(len(samples), SCREENED, seed)
    order = np.argsort(groups, kind="stable")
    distance = np.asarray(cdist(samples[order], samples[chosen]), np.float64)
    apart = np.minimum.reduceat(distance, np.flatnonzero(np.diff(groups[order], prepend=-1)))
    beside = np.sort(apart, axis=0)[min(BESIDE, len(apart) - 1)]
    return int(np.median((distance <= ACROSS * beside).sum(0)))


def spread_out(n: int, count: int, seed: int) -> Indices:
    """At most `count` of n, drawn at random, in order."""
    return np.sort(np.random.default_rng(seed).choice(n, min(n, count), replace=False))


class _Judge(NamedTuple):
    """Predicts left-out samples: chosen (n,), from others (n, k), nearest first."""

    samples: Array
    chosen: Indices
    others: Indices
    dim: int
    jobs: int
    ordered: bool

    def __call__(self, degrees: Sequence[int], neighbours: int) -> Array:
        """Squared errors of ascending degrees, winsorised; (len(degrees), n)."""
        others, options = self.others[:, :neighbours], (self.jobs, self.ordered)
        errors = held_out_residuals(self.samples, self.chosen, others, self.dim, degrees, *options) ** 2
        return np.minimum(errors, np.quantile(errors, WINSOR, axis=1, keepdims=True))


class Chosen(NamedTuple):
    """The shapes taken, each where it predicts left-out samples best.

    Attributes:
        shapes: of the local surfaces.
        taken: (n,) which of them serves around each left-out sample.
        squares: (n,) squared held-out residuals, winsorised.
        left_out: (n,) the samples that they are of.
        nearest: (n,) the sample nearest to each that was not left out with it.
        trials: every candidate looked at; the one that serves most samples is marked.
    """

    shapes: list[Shape]
    taken: Indices
    squares: Array
    left_out: Indices
    nearest: Indices
    trials: list[Trial]

    @property
    def degree(self) -> int:
        """The highest that is taken anywhere."""
        return max(s.degree for s in self.shapes)

    @property
    def residual(self) -> float:
        """Rms of the held-out residuals."""
        return float(np.sqrt(self.squares.mean()))

    def at(self, samples: Array, centres: Array) -> Indices:
        """Which shape serves at centres (M, D): that of the nearest left-out sample."""
        return self.taken[KDTree(samples[self.left_out]).query(centres)[1]]


def choose_shapes(
    samples: Array,
    groups: Indices | None,
    dim: int,
    sizes: tuple[int, int],
    seed: int,
    jobs: int,
    progress: Progress,
) -> Chosen:
    """Shapes of the local surfaces.

    Around each sample, among candidates that cannot be told from the best there (by the standard error of the
    paired difference) the one with most samples a coefficient is taken: it averages noise best. Folds ask for
    smaller neighbourhoods than flat parts. So few samples around would not tell a bias that is everywhere, though:
    candidates smoother than any that predicts the usual sample well are out. Where neighbourhoods of most samples
    contend, one shape is chosen by all errors: it would serve far beyond the few around. Recordings get one shape,
    too: what they are off by is how they differ from each other, not a fold.

    Args:
        samples: (N, D).
        groups: recording of each sample, then recordings are left out whole; None leaves single samples out.
        dim: d.
        sizes: smallest and largest neighbourhood.
        seed: of the choice of samples predicted.
        jobs: threads.
        progress: called with the stage and its share done.
    """
    n_others = int(len(samples) - (1 if groups is None else np.bincount(groups).max()))
    least, most = sizes
    if groups is not None:
        least = max(least, neighbours_across(samples, groups, seed))
    shapes = candidate_shapes(n_others, dim, most, min(least, n_others))

    def judge(count: int, good: Sequence[Shape]) -> _Judge:
        chosen = spread_out(len(samples), count, seed)
        others = nearest_others(samples, chosen, max(s.neighbours for s in good), groups, jobs)
        return _Judge(samples, chosen, others, dim, jobs, groups is not None)

    progress("choosing the local surfaces", 0.0)
    squares = _climb(screened := judge(SCREENED, shapes), shapes)
    progress("choosing the local surfaces", 0.4)
    good = _worth_comparing(_spanning(squares, screened) if groups is None else squares)
    terms = max(terms_of(dim, s.degree) for s in good)
    comparison = judge(min(COMPARED, max(FEWER, WORK // terms**2)), good)
    squares |= _compare(comparison, good)
    limit = _smoothest_usual({s: squares[s] for s in good}, dim)
    smooth = [s for s in good if smoothness(s, dim) <= limit]
    places = samples[comparison.chosen]
    wide = max(s.neighbours for s in smooth) > MOST * len(samples)
    pick = _pick if groups is None and not wide else _pick_one
    picked = pick({s: squares[s] for s in smooth}, places, dim)
    # A high degree that hardly any sample asks for is not worth its terms at every anchor.
    common = np.quantile([s.degree for s in picked], 1.0 - RARE, method="higher")
    if max(s.degree for s in smooth) > common:
        smooth = [s for s in smooth if s.degree <= common]
        picked = pick({s: squares[s] for s in smooth}, places, dim)
    shapes = sorted(set(picked))
    taken = np.array([shapes.index(s) for s in picked])
    own = np.array([squares[s][i] for i, s in enumerate(picked)])
    trials = _trials(squares, shapes[int(np.bincount(taken).argmax())])
    return Chosen(shapes, taken, own, comparison.chosen, comparison.others[:, 0], trials)


def _spanning(squares: dict[Shape, Array], judged: _Judge) -> dict[Shape, Array]:
    """Candidates whose neighbourhoods are much wider than their surfaces are off, or the relatively widest ones.

    Where noise is wider than samples lie apart, the nearest few predict each other well because they were chosen for
    being near in the noise, too.
    """
    here, last = judged.samples[judged.chosen], {s: judged.others[:, s.neighbours - 1] for s in squares}
    reach = {s: float(np.median(np.linalg.norm(judged.samples[last[s]] - here, axis=1))) for s in squares}
    spans = {s: reach[s] / max(float(np.sqrt(e.mean())), 1e-300) for s, e in squares.items()}
    least = min(SPAN, WIDEST * max(spans.values()))
    return {s: e for s, e in squares.items() if spans[s] >= least}


def smoothness(shape: Shape, dim: int) -> float:
    """Samples a coefficient."""
    return shape.neighbours / terms_of(dim, shape.degree)


def _trials(squares: dict[Shape, Array], best: Shape) -> list[Trial]:
    names = {s: f"degree {s.degree}, {s.neighbours} neighbours" for s in sorted(squares)}
    measure = "held-out residual (smaller)"
    return [
        Trial("surface", name, float(np.sqrt(squares[s].mean())), measure, s == best) for s, name in names.items()
    ]


def _climb(judge: _Judge, shapes: Sequence[Shape]) -> dict[Shape, Array]:
    """Squared errors; of each degree sizes are tried from small to large, until they are clearly too large."""
    squares: dict[Shape, Array] = {}
    least = dict.fromkeys({s.degree for s in shapes}, np.inf)
    for k in sorted({s.neighbours for s in shapes}):
        degrees = sorted(s.degree for s in shapes if s.neighbours == k and s.degree in least)
        if not degrees:
            continue
        for degree, errors in zip(degrees, judge(degrees, k), strict=True):
            squares[Shape(degree, k)] = errors
            least[degree] = min(least[degree], errors.mean())
            if errors.mean() > HOPELESS**2 * least[degree]:
                del least[degree]
    return squares


def _compare(judge: _Judge, good: Sequence[Shape]) -> dict[Shape, Array]:
    """Squared errors of each shape, one neighbourhood size at a time."""
    found: dict[Shape, Array] = {}
    for k in {s.neighbours for s in good}:
        degrees = sorted(s.degree for s in good if s.neighbours == k)
        found |= {Shape(g, k): e for g, e in zip(degrees, judge(degrees, k), strict=True)}
    return found


def _as_good(squares: dict[Shape, Array], errors: float) -> list[Shape]:
    """Shapes whose mean is within so many standard errors of the least, of the paired differences."""
    all_of = np.array(list(squares.values()))
    difference = all_of - all_of[all_of.mean(1).argmin()]
    good = difference.mean(1) <= errors * difference.std(1) / np.sqrt(all_of.shape[1])
    return [s for s, one in zip(squares, good, strict=True) if one]


def _worth_comparing(squares: dict[Shape, Array]) -> list[Shape]:
    """Candidates that may be best on average, or for most samples."""
    found = set()
    for errors in (squares, {s: np.minimum(e, np.median(e)) for s, e in squares.items()}):
        means = {s: e.mean() for s, e in errors.items()}
        limit = BETTER**2 * min(means.values())
        found |= {s for s in _as_good(errors, WORSE) if means[s] <= limit}
    return sorted(found)


def _smoothest_usual(squares: dict[Shape, Array], dim: int) -> float:
    """Most samples a coefficient among candidates as good as the best, however badly they do where it does badly."""
    limit = np.quantile(min(squares.values(), key=np.mean), USUAL)
    usual = {s: np.minimum(e, limit) for s, e in squares.items()}
    return max(smoothness(s, dim) for s in _as_good(usual, DOUBTED))


def _pick(squares: dict[Shape, Array], places: Array, dim: int) -> list[Shape]:
    """For each of n places the smoothest candidate that is as good as the best around it.

    Args:
        squares: (n,) squared errors of each candidate.
        places: (n, D) of the samples that the errors are of.
        dim: d.
    """
    around = nearest(places, places, min(AROUND, len(places)))
    shapes, local = list(squares), np.array(list(squares.values()))[:, around]
    difference = local - local[local.mean(2).argmin(0), np.arange(len(around))]
    as_good = difference.mean(2) <= DOUBTED * difference.std(2) / np.sqrt(around.shape[1])
    samples_a_term = np.array([smoothness(s, dim) for s in shapes])
    return [shapes[i] for i in np.where(as_good, samples_a_term[:, None], -1.0).argmax(0)]


def _pick_one(squares: dict[Shape, Array], places: Array, dim: int) -> list[Shape]:
    """The same for all places, by all errors: these tell which predicts best of those that are about as smooth."""
    good = _as_good(squares, DOUBTED)
    limit = max(smoothness(s, dim) for s in good) / ALIKE
    best = min((s for s in good if smoothness(s, dim) >= limit), key=lambda s: float(squares[s].mean()))
    return [best] * len(places)
