"""The manifold's dimension, from the spectra of local covariances at several scales (paper 000, section III-D).

The paper raises d until the training error flattens. On held-out edges that knee is often missed; the largest
gap in the local spectra is not.
"""

from typing import Any

import numpy as np
from scipy.spatial import KDTree

from skillfold.manifold.table import Trial

Array = np.ndarray[Any, np.dtype[np.float64]]

CENTRES = 1500  # samples whose surroundings are looked at
FLOOR = 0.05  # of a local extent relative to the largest: smaller ones count as none


def local_extents(samples: Array, k: int, seed: int) -> Array:
    """Median extent along each local principal direction at k neighbours, relative to the largest; (D,)."""
    count = min(CENTRES, len(samples))
    chosen = np.random.default_rng(seed).choice(len(samples), count, replace=False)
    around = samples[KDTree(samples).query(samples[np.sort(chosen)], k + 1)[1]]
    centred = around - around.mean(1, keepdims=True)
    values = np.linalg.eigvalsh(np.swapaxes(centred, 1, 2) @ centred)[:, ::-1]
    typical = np.sqrt(np.maximum(np.median(values, axis=0), 0.0))
    return np.maximum(typical / max(float(typical[0]), 1e-300), FLOOR)


def scales(n_samples: int, n_dims: int, doublings: int = 3) -> list[int]:
    """Neighbourhood sizes to look at: none larger than a sixth of the samples."""
    wanted = [k for k in (2 ** (i + 1) * n_dims + 2 for i in range(doublings)) if k <= n_samples / 6]
    return wanted or [max(n_dims, min(2 * n_dims + 2, n_samples - 1))]


def choose_dimension(samples: Array, few_recordings: bool, seed: int, doublings: int = 3) -> tuple[int, list[Trial]]:
    """D with the widest gap after it, over all scales, and the gaps.

    Args:
        samples: (N, D).
        few_recordings: whether they come from a handful of recordings: then what the recordings differ by shows
            as a further dimension at some scales, and the smallest well-supported d is taken.
        seed: of the choice of centres.
        doublings: neighbourhood sizes looked at, each about twice the one before.
    """
    D = samples.shape[1]
    gaps = np.zeros(D)
    for k in scales(len(samples), D, doublings):
        extents = local_extents(samples, min(k, len(samples) - 1), seed)
        gaps[1:] = np.maximum(gaps[1:], extents[:-1] / extents[1:])
    best = 1 + int(gaps[1:].argmax()) if D > 1 else 1
    if few_recordings:
        best = 1 + int(np.flatnonzero(gaps[1:] >= 0.5 * gaps[best])[0])
    trials = [
        Trial("dimension", f"d = {d}", float(gaps[d]), "gap in local extents (larger)", d == best)
        for d in range(1, D)
    ]
    return best, trials
