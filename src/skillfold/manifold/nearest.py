"""Samples nearest to states: by a tree, or by sorting all distances where a tree would visit most samples anyway."""

from collections.abc import Callable
from typing import Any

import numpy as np
from joblib import effective_n_jobs
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from skillfold.manifold.threads import in_parts

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

SHARE = 0.035  # of the samples asked for, from which on sorting is faster
MOST = 2000  # samples that are sorted
ROWS = 100  # states whose distances are sorted at a time: they stay in fast memory


def nearest(samples: Array, states: Array, k: int, jobs: int = 1) -> Indices:
    """The k samples (N, D) nearest to each of states (n, D), the nearest first; (n, k)."""
    if k < SHARE * len(samples) or len(samples) > MOST:
        found = KDTree(samples).query(states, k, workers=effective_n_jobs(jobs))[1]
        return np.asarray(found).reshape(len(states), k)

    def asked(rows: slice) -> Indices:
        return least(_squares(states[rows], samples), k)

    return _few_at_a_time(asked, len(states), jobs)


def nearest_of_others(samples: Array, groups: Indices, chosen: Indices, k: int, jobs: int = 1) -> Indices:
    """The k samples (N, D) nearest to each of the chosen (n,) outside its group, the nearest first; (n, k)."""

    def asked(rows: slice) -> Indices:
        own = chosen[rows]
        squares = _squares(samples[own], samples)
        squares[groups[own][:, None] == groups] = np.inf
        return least(squares, k)

    return _few_at_a_time(asked, len(chosen), jobs)


def _squares(states: Array, samples: Array) -> Array:
    return np.asarray(cdist(states, samples, "sqeuclidean"), np.float64)


def _few_at_a_time(asked: Callable[[slice], Indices], count: int, jobs: int) -> Indices:
    def part(rows: slice) -> Indices:
        begins = range(rows.start, rows.stop, ROWS)
        return np.concatenate([asked(slice(begin, min(begin + ROWS, rows.stop))) for begin in begins])

    return np.concatenate(in_parts(part, count, jobs))


def least(squares: Array, k: int) -> Indices:
    """Columns of the k least numbers of each row (n, N), the least first; (n, k). None is negative; all are used up.

    The column takes the place of each number's last bits, of about a millionth of a millionth of it: sorting numbers
    takes a third of the time of sorting their places. Of equal ones, the first column comes first.
    """
    bits = (1 << (squares.shape[1] - 1).bit_length()) - 1
    packed = squares.view(np.int64)
    packed &= ~bits
    packed |= np.arange(squares.shape[1])
    packed.partition(k - 1, axis=1)
    return np.sort(packed[:, :k], axis=1) & bits
