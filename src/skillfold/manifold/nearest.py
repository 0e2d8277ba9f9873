"""Samples nearest to states: by a tree, or by sorting all distances where a tree would visit most samples anyway."""

from typing import Any

import numpy as np
from joblib import effective_n_jobs
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from skillfold.manifold.threads import in_parts

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

SHARE = 0.1  # of the samples asked for, from which on sorting is faster
MOST = 2000  # samples that are sorted


def nearest(samples: Array, states: Array, k: int, jobs: int = 1) -> Indices:
    """The k samples (N, D) nearest to each of states (n, D), the nearest first; (n, k)."""
    if k < SHARE * len(samples) or len(samples) > MOST:
        found = KDTree(samples).query(states, k, workers=effective_n_jobs(jobs))[1]
        return np.asarray(found).reshape(len(states), k)

    def asked(part: slice) -> Indices:
        distances = cdist(states[part], samples, "sqeuclidean")
        return np.argsort(distances, axis=1)[:, :k]

    return np.concatenate(in_parts(asked, len(states), jobs))
