"""Samples nearest to states: by a tree, or by sorting all distances where a tree would visit most samples anyway."""

from typing import Any

import numpy as np
from joblib import effective_n_jobs
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from skillfold.manifold.threads import in_parts

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

SHARE = 0.05  # of the samples asked for, from which on sorting is faster
MOST = 2000  # samples that are sorted
ROWS = 100  # states whose distances are sorted at a time: they stay in fast memory


def nearest(samples: Array, states: Array, k: int, jobs: int = 1) -> Indices:
    """The k samples (N, D) nearest to each of states (n, D), the nearest first; (n, k)."""
    if k < SHARE * len(samples) or len(samples) > MOST:
        found = KDTree(samples).query(states, k, workers=effective_n_jobs(jobs))[1]
        return np.asarray(found).reshape(len(states), k)

    def asked(part: slice) -> Indices:
        some = np.array_split(states[part], range(ROWS, part.stop - part.start, ROWS))
        squares = (np.asarray(cdist(rows, samples, "sqeuclidean"), np.float64) for rows in some)
        return np.concatenate([least(each, k) for each in squares])

    return np.concatenate(in_parts(asked, len(states), jobs))


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
