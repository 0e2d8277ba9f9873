"""Directions that are free everywhere: they lie in every tangent space, so the manifold does not depend on them.

An upright tool does not care for the base's yaw, nor for the last joint's roll. With them, few samples are spread
over many dimensions; without them the same samples lie close together. Found by the average of the local normal
projectors: a direction that no normal touches is free. Neighbourhoods and normals are refined in turns, measuring
distance the less along a direction, the less normals touch it. What was found is made exact in `free_slopes`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from skillfold.manifold.anchors import held_out_residuals, nearest_others
from skillfold.manifold.dimension import choose_dimension
from skillfold.manifold.free_slopes import bending, without_slope
from skillfold.manifold.samples import SPARE, distinct
from skillfold.manifold.shapes import spread_out
from skillfold.manifold.table import Trial
from skillfold.manifold.threads import in_parts

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

ROUNDS = 6
STEADY = 0.01  # change of every share, at which further rounds would only repeat the last
CENTRES = 800
METRIC_FLOOR = 0.03  # of the scale that a direction keeps in the metric
TOUCHED = 0.05  # share of a direction that normals may touch if it is to count as free
MOST_NORMALS = 4
CLEAR = 0.5  # of the gap after d with all directions: what is truly free leaves as clear a one
WORSE = 1.3  # times the held-out residual without dropping: above it nothing is dropped
BENT = 1.5  # times what chance explains of heights by the free coordinates: above it they are none
JUDGED = 150  # samples that judge it


@dataclass(frozen=True)
class Split:
    """Directions of the state space, orthonormal columns.

    Attributes:
        kept: (D, D - f), which the manifold bends in.
        free: (D, f), along which everything is allowed.
        dim: dimension of the manifold within the kept ones, d - f.
    """

    kept: Array
    free: Array
    dim: int


def _normals(samples: Array, metric: Array, codim: int, chosen: Indices, jobs: int) -> Array:
    """Orthonormal normals (n, D, codim) at chosen samples, from neighbourhoods in the metric."""
    scaled = samples @ metric
    tree, k = KDTree(scaled), min(2 * samples.shape[1] + 3, len(samples))

    def normals(part: slice) -> Array:
        around = scaled[tree.query(scaled[chosen[part]], k)[1]]
        centred = around - around.mean(1, keepdims=True)
        vectors = np.linalg.eigh(np.swapaxes(centred, 1, 2) @ centred)[1]
        return np.linalg.qr(metric @ vectors[:, :, :codim])[0]

    return np.concatenate(in_parts(normals, len(chosen), jobs))


def normal_spectrum(samples: Array, codim: int, seed: int, jobs: int = 1) -> tuple[Array, Array]:
    """How much normals touch each of D orthonormal directions (ascending, 0 to 1), and these as columns."""
    D = samples.shape[1]
    chosen = spread_out(len(samples), CENTRES, seed)
    metric, touched, directions = np.eye(D), np.ones(D), np.eye(D)
    for _ in range(ROUNDS):
        normals = _normals(samples, metric, codim, chosen, jobs)
        before = touched
        touched, directions = np.linalg.eigh(np.einsum("nac,nbc->ab", normals, normals) / len(chosen))
        if np.abs(touched - before).max() < STEADY:
            break
        metric = directions * np.sqrt(np.maximum(touched, 0.0) / touched[-1] + METRIC_FLOOR**2)
    return touched, directions


def split_directions(
    samples: Array,
    groups: Indices | None,
    dim: int | None,
    seed: int,
    jobs: int = 1,
    unrolled: Array | None = None,
) -> tuple[Split, list[Trial]]:
    """Kept and free directions and the inner dimension, with the trials.

    For each number of normals: free directions under it, as many as may be, and what the samples without them say
    of the dimension. Only where both agree is the split a candidate, and only if it predicts left-out samples as
    well, and nothing bends with what is free.

    Args:
        samples: (N, D).
        groups: recording of each sample or None.
        dim: d as the user fixed it, or None.
        seed: of the choice of samples looked at.
        jobs: threads.
        unrolled: (N, ...) the samples without constraints that are known, to tell the dimension from.
    """
    D = samples.shape[1]
    plain, trials = (dim, []) if dim else choose_dimension(samples if unrolled is None else unrolled, groups, seed)
    best, best_gap = Split(np.eye(D), np.empty((D, 0)), plain), 0.0
    # The plain rule may overlook normals where samples are sparse; it does not make any up.
    counts = [D - plain] if dim else range(D - plain, max(D - plain, min(MOST_NORMALS, D - 2)) + 1)
    # What is free leaves a dimension at least: of a curve nothing is.
    for codim in (count for count in counts if count < D - 1):
        touched, directions = normal_spectrum(samples, codim, seed, jobs)
        for f in range(min(int((touched < TOUCHED).sum()), D - codim - 1), 0, -1):
            split = Split(directions[:, f:], directions[:, :f], D - codim - f)
            if not _holds(samples, groups, split, seed):  # asked first, as it costs the least
                continue
            found, gap = _dimension_without(samples, groups, split, touched, seed)
            agreed = dim or (found == split.dim and gap >= CLEAR * trials[D - codim - 1].score)
            if not agreed or gap <= best_gap:
                continue
            split = _turned(samples, split, seed, jobs)
            if _tells(samples, split) and not _bends(samples, split, seed, jobs):
                best, best_gap = split, gap
                break
    trials = [Trial(t.choice, t.setting, t.score, t.measure, t.setting == f"d = {plain}") for t in trials]
    return best, trials + _split_trials(best, best_gap, D)


def _dimension_without(
    samples: Array, groups: Indices | None, split: Split, touched: Array, seed: int
) -> tuple[int, float]:
    """What samples without the free directions say of the dimension, and by how wide a gap."""
    weights = np.sqrt(np.maximum(touched[split.free.shape[1] :], 0.0) / touched[-1] + METRIC_FLOOR**2)
    # Without the free directions samples lie close together: noise hides the gap unless more are taken in.
    found, gaps = choose_dimension(samples @ (split.kept * weights), groups, seed, doublings=7)
    return found, next((t.score for t in gaps if t.chosen), 0.0)


def _turned(samples: Array, split: Split, seed: int, jobs: int) -> Split:
    """The same split made exact, unless that would take it to directions that do not count as free."""
    chosen = spread_out(len(samples), CENTRES, seed)
    kept, free = without_slope(samples, split.kept, split.free, split.dim, chosen, jobs)
    off = np.linalg.norm(split.kept.T @ free, axis=0)
    return Split(kept, free, split.dim) if (off**2 < TOUCHED).all() else split


def _tells(samples: Array, split: Split) -> bool:
    """Whether enough samples are left, those counted once that differ in free directions only."""
    left = samples @ split.kept
    return len(distinct(left)) >= left.shape[1] + SPARE


def _bends(samples: Array, split: Split, seed: int, jobs: int) -> bool:
    """Whether the surface without the free directions depends on where along them a sample lies."""
    chosen = spread_out(len(samples), CENTRES, seed)
    return bending(samples @ split.kept, samples @ split.free, split.dim, chosen, jobs) > BENT


def _split_trials(split: Split, gap: float, D: int) -> list[Trial]:
    f = split.free.shape[1]
    setting = f"{f} of {D} free, d = {split.dim + f}"
    return [Trial("free directions", setting, gap, "gap in local extents without them", True)] if f else []


def _holds(samples: Array, groups: Indices | None, split: Split, seed: int) -> bool:
    """Whether samples are predicted without the free directions as well as with them, over the same distances.

    Without them all samples lie closer together: judged by its nearest few, any split would look good.
    """
    chosen = spread_out(len(samples), JUDGED, seed)
    whole = split.dim + split.free.shape[1]
    k = min(3 * (whole + 1), len(samples) // 2)
    others = nearest_others(samples, chosen, k, groups)
    reach = np.linalg.norm(samples[others] - samples[chosen, None], axis=2).max(1)
    inner = samples @ split.kept
    around = _within(inner, chosen, reach * np.sqrt(inner.shape[1] / samples.shape[1]), k, groups, seed)
    residuals = [
        float(np.median(held_out_residuals(samples, chosen, others, whole, [1]))),
        float(np.median(held_out_residuals(inner, chosen, around, split.dim, [1]))),
    ]
    return residuals[1] <= WORSE * residuals[0]


def _within(inner: Array, chosen: Indices, reach: Array, k: int, groups: Indices | None, seed: int) -> Indices:
    """Draw k samples among those within reach of each chosen one, nearest first; (n, k)."""
    rng = np.random.default_rng(seed)
    tree = KDTree(inner)
    found = np.empty((len(chosen), k), dtype=np.int64)
    for row, (i, radius) in enumerate(zip(chosen, reach, strict=True)):
        near = np.array(tree.query_ball_point(inner[i], radius), dtype=np.int64)
        near = near[near != i] if groups is None else near[groups[near] != groups[i]]
        if len(near) < k:
            near = nearest_others(inner, np.array([i]), k, groups)[0]
        picked = rng.choice(near, k, replace=False)
        found[row] = picked[np.argsort(((inner[picked] - inner[i]) ** 2).sum(1))]
    return found
