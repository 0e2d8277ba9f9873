"""Radial basis features of section III-C: centres by k-means, one width, values that sum to one."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist
from sklearn.cluster import KMeans

Array = np.ndarray[Any, np.dtype[np.float64]]

FEW_ENOUGH = 5000  # samples that k-means looks at; more do not move the centres


@dataclass(frozen=True)
class Features:
    """Normalised radial basis functions.

    Plain ones vanish far from the data and the field with them; normalised, the nearest centre speaks there.

    Attributes:
        centres: (K, D).
        width: σ, twice the mean distance from a centre to its nearest other centre.
    """

    centres: Array
    width: float

    @staticmethod
    def place(samples: Array, kernels: int, seed: int) -> "Features":
        """K centres for samples (N, D)."""
        if len(samples) > FEW_ENOUGH:
            chosen = np.random.default_rng(seed).choice(len(samples), FEW_ENOUGH, replace=False)
            samples = samples[np.sort(chosen)]
        if len(np.unique(samples[:, 0])) < kernels:  # rows take longer to tell apart, and hardly ever matter
            kernels = min(kernels, len(np.unique(samples, axis=0)))
        centres = KMeans(kernels, n_init="auto", random_state=seed).fit(samples).cluster_centers_
        if kernels == 1:
            return Features(centres, 1.0)
        nearest = KDTree(centres).query(centres, 2)[0][:, 1]
        return Features(centres, 2.0 * float(nearest.mean()))

    def __call__(self, x: Array) -> Array:
        """Values (..., K) at x (..., D); the largest exponent is taken off first, so that none underflows."""
        square = np.asarray(cdist(x.reshape(-1, x.shape[-1]), self.centres, "sqeuclidean"), np.float64)
        square -= square.min(1, keepdims=True)
        values = np.exp(square / (-2.0 * self.width**2), out=square)
        values /= values.sum(1, keepdims=True)
        return values.reshape(*x.shape[:-1], -1)
