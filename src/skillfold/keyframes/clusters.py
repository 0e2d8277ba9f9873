"""Keyframes of several demonstrations to places in order: which keyframe of which demonstration belongs together.

A place is a Gaussian over poses that each demonstration visits once or leaves out, in the same order; a keyframe that
belongs to no place is an extra one, anywhere. One demonstration after the other is laid along the places that the
others tell, as well as can be (E), and the places follow (M), until nothing changes: each step can only raise the
evidence, with means and covariances integrated out (see `evidence`). Many starts run at once: k-means on pose and
order, single demonstrations, the best places of one number with one more or one less. The number of places is that of
the highest evidence, which BIC approximates where there are many keyframes; here there are seven of each place.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.evidence import SUMS, Prior, next_shown, shown, sums_of
from skillfold.keyframes.kernels.aligning import EXTRA, lay_along

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

SWEEPS = 30  # at most; most starts need five
ORDERS = (0.0, 0.2, 0.5, 2.0)  # [m] weights of the place in the sequence, for k-means
KEPT = 3  # best solutions of each number of places that the next number starts from


class Clusters(NamedTuple):
    """Which keyframe belongs to which place.

    Attributes:
        labels: by demonstration, (m,) place of each keyframe, −1 for extra ones.
        table: (places, evidence) of each number of places tried.
        chosen: the number of places taken.
    """

    labels: tuple[Indices, ...]
    table: tuple[tuple[int, float], ...]
    chosen: int


class Solutions(NamedTuple):
    """Labels (S, D, M) of several solutions, padded by `EXTRA`, and their evidence (S,)."""

    labels: Indices
    evidence: Array


def cluster(demos: Sequence[Array], n_keyframes: int | None = None, seed: int = 0) -> Clusters:
    """Places in order from keyframes, one array (m, 7) of poses for each demonstration.

    Args:
        demos: unit quaternions of any sign.
        n_keyframes: number of places; left out, the one with the highest evidence among those whose places all
            appear in a third of the demonstrations.
        seed: of k-means.
    """
    table = _Table.of(demos)
    numbers = _numbers(table.counts) if n_keyframes is None else range(n_keyframes, n_keyframes + 1)
    with threadpool_limits(1):  # threads cost more than they bring at such sizes
        best = _search(table, numbers, seed)
    tried = tuple((k, float(found.evidence[0])) for k, found in best.items())
    common = [row for row in tried if _all_common(best[row[0]].labels[0], row[0])]
    chosen = max(common or tried, key=lambda row: row[1])[0]
    labels = best[chosen].labels[0]
    by_demo = [np.empty(0, np.int64)] * len(demos)
    for row, place in enumerate(table.order):
        by_demo[place] = labels[row, : table.counts[row]].copy()
    return Clusters(tuple(by_demo), tried, chosen)


def assigned(demos: Sequence[Array], labels: Sequence[Indices], new: Array, places: int) -> Indices:
    """Places (m,) of the keyframes of a further demonstration, under those of labelled ones."""
    table = _Table.of([*demos, new])
    known = [np.full(len(new), EXTRA) if i == len(demos) else labels[i] for i in table.order]
    start = np.full(table.sums.shape[:2], EXTRA)
    for row, values in enumerate(known):
        start[row, : len(values)] = values
    found = _laid(table, start[None], places, [table.order.index(len(demos))])
    return found[0, table.order.index(len(demos)), : len(new)].copy()


@dataclass(frozen=True)
class _Table:
    """Demonstrations in an order of their own, so that the order given does not matter.

    Attributes:
        order: which demonstration each row is.
        counts: (D,) keyframes of each.
        positions, turns: by row, (m, 3) about the mean and (m, 4).
        sums: (D, M, 29), zero where there is none.
        prior: from all keyframes.
    """

    order: list[int]
    counts: list[int]
    positions: list[Array]
    turns: list[Array]
    sums: Array
    prior: Prior

    @classmethod
    def of(cls, demos: Sequence[Array]) -> "_Table":
        order = sorted(range(len(demos)), key=lambda i: _own(demos[i]))
        rows = [demos[i] for i in order]
        centre = np.concatenate(rows)[:, :3].mean(0)
        counts = [len(row) for row in rows]
        positions = [np.ascontiguousarray(row[:, :3] - centre) for row in rows]
        turns = [np.ascontiguousarray(row[:, 3:]) for row in rows]
        sums = np.zeros((len(rows), max(counts), SUMS))
        for row, (p, q) in enumerate(zip(positions, turns, strict=True)):
            sums[row, : len(p)] = sums_of(p, q)
        return cls(order, counts, positions, turns, sums, Prior.of(sums.sum((0, 1))))


def _own(demo: Array) -> tuple[float, ...]:
    """Something of a demonstration that no rigid motion changes but for rounding."""
    steps = np.linalg.norm(np.diff(demo[:, :3], axis=0), axis=1)
    turned = 1 - np.abs((demo[1:, 3:] * demo[:-1, 3:]).sum(1))
    return (len(demo), *np.round(np.concatenate([steps, turned]), 9))


def _all_common(labels: Indices, k: int) -> bool:
    """Whether a third of the demonstrations (D, M) show each place."""
    return all(3 * int((labels == place).any(1).sum()) >= len(labels) for place in range(k))


def _numbers(counts: Sequence[int]) -> range:
    """Numbers of places worth trying."""
    return range(max(1, int(0.6 * np.median(counts))), max(counts) + 2)


def _search(table: _Table, numbers: range, seed: int) -> dict[int, Solutions]:
    """Best solutions of each number: from k-means and single demonstrations, then by adding and dropping places."""
    best: dict[int, Solutions] = {}
    for k in numbers:
        starts = _by_means(table, k, seed) + _by_demonstration(table, k)
        starts += [new for old in best[k - 1].labels for new in _births(table, old, k)] if k - 1 in best else []
        best[k] = _solved(table, starts, k)
    for k in reversed(numbers):
        if k + 1 in best:
            starts = [new for old in best[k + 1].labels for new in _deaths(old, k + 1)]
            best[k] = _better(best[k], _solved(table, starts, k))
    return best


def _by_means(table: _Table, k: int, seed: int) -> list[Indices]:
    """Labels (D, M) from k-means on pose and place in the sequence, places in order of their mean place."""
    from scipy.spatial.transform import Rotation
    from sklearn.cluster import KMeans
    from sklearn.exceptions import ConvergenceWarning

    if k > len(np.concatenate(table.positions)):
        return []
    turns = Rotation.from_quat(np.concatenate(table.turns), scalar_first=True).as_matrix().reshape(-1, 9)
    # Of rotations by an angle θ the matrices lie about √2 θ apart.
    poses = np.hstack([np.concatenate(table.positions), LENGTH / np.sqrt(2) * turns])
    place = np.concatenate([(np.arange(m) + 0.5) / m for m in table.counts])
    settings: Any = {"n_init": 3, "random_state": seed}
    starts = []
    for weight in ORDERS:
        rows = np.column_stack([poses, weight * place])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # fewer keyframes that differ than means: no harm
            found = KMeans(k, **settings).fit_predict(rows)
        means = [place[found == c].mean() if (found == c).any() else 2.0 for c in range(k)]
        starts.append(_padded(table, np.argsort(np.argsort(means))[found]))
    return starts


def _padded(table: _Table, labels: Indices) -> Indices:
    made = np.full(table.sums.shape[:2], EXTRA)
    made[np.arange(table.sums.shape[1]) < np.array(table.counts)[:, None]] = labels
    return made


def _by_demonstration(table: _Table, k: int) -> list[Indices]:
    """Labels that make the keyframes of one demonstration the places, of each that has as many."""
    starts = []
    for row in (row for row, count in enumerate(table.counts) if count == k):
        start = np.full(table.sums.shape[:2], EXTRA)
        start[row, :k] = np.arange(k)
        starts.append(start)
    return starts


def _births(table: _Table, labels: Indices, k: int) -> list[Indices]:
    """Labels with one place more: each extra keyframe a place of its own."""
    starts = []
    for row, count in enumerate(table.counts):
        for i in (i for i in range(count) if labels[row, i] == EXTRA):
            at = labels[row, :i].max(initial=-1) + 1
            start = labels + (labels >= at)
            start[row, i] = at
            starts.append(start)
    return starts


def _deaths(labels: Indices, k: int) -> list[Indices]:
    """Labels with one place less."""
    return [np.where(labels == gone, EXTRA, labels - (labels > gone)) for gone in range(k)]


def _better(first: Solutions, second: Solutions) -> Solutions:
    labels = np.concatenate([first.labels, second.labels])
    evidence = np.concatenate([first.evidence, second.evidence])
    _, distinct = np.unique(labels, axis=0, return_index=True)
    order = sorted(distinct, key=lambda s: -evidence[s])[:KEPT]
    return Solutions(labels[order], evidence[order])


def _solved(table: _Table, starts: list[Indices], k: int) -> Solutions:
    """Demonstrations laid along the places that the others tell, in turn, until nothing changes."""
    labels = np.unique(np.array(starts).reshape(len(starts), *table.sums.shape[:2]), axis=0)
    moving = np.arange(len(labels))
    for _ in range(SWEEPS):
        before = labels[moving].copy()
        labels[moving] = _laid(table, before.copy(), k, range(len(table.counts)))
        moving = moving[(labels[moving] != before).any((1, 2))]
        if not len(moving):
            break
    empty = Solutions(labels[:0], np.empty(0))
    return _better(empty, Solutions(labels, _evidence(table, labels, k)))


def _laid(table: _Table, labels: Indices, k: int, rows: Sequence[int]) -> Indices:
    """Labels (S, D, M) once these rows, one after the other, are laid along the places that all others tell."""
    member = (labels[..., None] == np.arange(k)).astype(np.float64)
    sums = np.einsum("sdmk,dmf->sdkf", member, table.sums)
    whole, scores = sums.sum(1), np.empty((labels.shape[2] + 1, k + 1))
    found = np.empty((len(labels), labels.shape[2]), np.int64)
    for row, count in ((row, table.counts[row]) for row in rows):
        places = table.prior.places(whole - sums[:, row])
        hit, missed = next_shown(places.count, len(table.counts) - 1)
        likely = table.prior.further(places, table.positions[row], table.turns[row]) + hit[:, None]
        lay_along(likely, missed, table.prior.extra, count, scores, found)
        labels[:, row, :count] = found[:, :count]
        member = (found[:, :count, None] == np.arange(k)).astype(np.float64)
        changed = np.einsum("smk,mf->skf", member, table.sums[row, :count])
        whole += changed - sums[:, row]
        sums[:, row] = changed
    return labels


def _evidence(table: _Table, labels: Indices, k: int) -> Array:
    member = (labels[..., None] == np.arange(k)).astype(np.float64)
    places = table.prior.places(np.einsum("sdmk,dmf->skf", member, table.sums))
    extras = sum(table.counts) - places.count.sum(1)
    return table.prior.evidence(places) + shown(places.count, len(table.counts)).sum(1) + extras * table.prior.extra
