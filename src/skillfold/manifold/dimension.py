"""The manifold's dimension, from the spectra of local covariances at several scales (paper 000, section III-D).

The paper raises d until the training error flattens. On held-out edges that knee is often missed; the largest
gap in the local spectra is not. What bends off the tangent space may look like one more dimension of a wide
neighbourhood: it is told by how it grows with it.
"""

from typing import Any

import numpy as np

from skillfold.manifold.nearest import nearest, nearest_of_others
from skillfold.manifold.table import Trial

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

CENTRES = 1500  # samples whose surroundings are looked at
SHARE = 6  # of the samples: the largest neighbourhood holds no more than one in so many
THINNER = 4  # times fewer samples, where noise may be wider than they lie apart
FLOOR = 0.05  # of a local extent relative to the largest: smaller ones count as none
MEDIAN_SQUARE = 0.455  # of what is normally distributed, in terms of its mean square
BENT = 1.0  # power of the neighbourhood's size that a relative extent grows with: dimensions keep theirs


def local_extents(samples: Array, chosen: Indices, around: Indices, own: bool) -> Array:
    """Median rms extent of the neighbours (n, k) of chosen samples along each local principal direction; (D,).

    The largest first. Extents are about the neighbours' mean, or about the chosen sample where that is not their
    `own`, but of another recording: a few recordings spread in fewer directions than they are, and it takes one more
    to tell whether it would lie in these.
    """
    near = samples[around]
    means = near.mean(1, keepdims=True)
    values, vectors = np.linalg.eigh(np.swapaxes(near - means, 1, 2) @ (near - means))
    squares = np.median(np.maximum(values, 0.0), axis=0) / near.shape[1]
    if not own:
        away = np.einsum("nab,na->nb", vectors, samples[chosen] - means[:, 0])
        squares = squares + np.median(away**2, axis=0) / MEDIAN_SQUARE
    return np.sqrt(squares[::-1])


def scales(n_samples: int, n_dims: int, doublings: int = 3, finest: bool = False) -> list[int]:
    """Neighbourhood sizes to look at: none larger than a sixth of the samples.

    The finest is hardly larger than what spans the space; it shows dimensions in which the samples spread little.
    """
    wanted = [k for k in (2 ** (i + 1) * n_dims + 2 for i in range(doublings)) if k <= n_samples / SHARE]
    if not wanted:
        return [max(n_dims, min(2 * n_dims + 2, n_samples - 1))]
    return [n_dims + 2, *wanted] if finest else wanted


def choose_dimension(
    samples: Array, groups: Indices | None, seed: int, doublings: int = 3
) -> tuple[int, list[Trial]]:
    """The dimension with the widest gap after it, over all scales, and the gaps.

    Args:
        samples: (N, D).
        groups: (N,) recording of each or None. What recordings differ by shows as a further dimension at some scales:
            of them, the smallest well-supported d is taken.
        seed: of the choice of centres.
        doublings: neighbourhood sizes looked at, each about twice the one before.
    """
    D, few = samples.shape[1], groups is not None
    seen = [samples] if few else thinned(samples, seed, doublings)
    gaps = max((_gaps(some, groups, seed, doublings) for some in seen), key=lambda found: found.max())
    best = 1 + int(gaps.argmax()) if D > 1 else 1
    if few:
        best = 1 + int(np.flatnonzero(gaps >= 0.5 * gaps[best - 1])[0])
    trials = [
        Trial("dimension", f"d = {d}", float(gaps[d - 1]), "gap in local extents (larger)", d == best)
        for d in range(1, D)
    ]
    return best, trials


def thinned(samples: Array, seed: int, doublings: int) -> list[Array]:
    """All samples, a quarter of them, and so on, while each has neighbourhoods of all sizes.

    Where noise is wider than samples lie apart, the nearest of all lie scattered to all sides; of fewer, they follow
    the manifold. Wider neighbourhoods of all would do the same, and take longer.
    """
    order, count = np.random.default_rng(seed).permutation(len(samples)), len(samples)
    found = [samples]
    while (count := count // THINNER) >= SHARE * (2**doublings * samples.shape[1] + 2):
        found.append(samples[np.sort(order[:count])])
    return found


def _gaps(samples: Array, groups: Indices | None, seed: int, doublings: int) -> Array:
    """Gap after each of D - 1 directions, of samples (N, D) and their recordings or None."""
    sizes = scales(len(samples), samples.shape[1], doublings, groups is None)
    chosen = np.sort(np.random.default_rng(seed).choice(len(samples), min(CENTRES, len(samples)), replace=False))
    if groups is None:
        around = nearest(samples, samples[chosen], sizes[-1] + 1)
        extents = np.array([local_extents(samples, chosen, around[:, : k + 1], True) for k in sizes])
    else:
        most = len(samples) - int(np.bincount(groups).max())
        around = nearest_of_others(samples, groups, chosen, min(sizes[-1], most))
        extents = np.array([local_extents(samples, chosen, around[:, :k], False) for k in sizes])
    largest = np.maximum(extents[:, :1], 1e-300)
    return gaps_after(np.maximum(extents / largest, FLOOR), largest, groups is None)


def gaps_after(extents: Array, sizes: Array, bends: bool) -> Array:
    """The gap after each of D - 1 directions, the widest over all scales.

    A gap after what bends counts at the smallest scale alone: a bend is off the tangent space by the square of the
    distance, so relative to that it grows with it, and in wide neighbourhoods hides the gap before it.

    Args:
        extents: (scales, D), relative.
        sizes: (scales, 1) of the neighbourhoods.
        bends: whether to look for them; side by side, few recordings look wider in wide neighbourhoods, too.
    """
    gaps = extents[:, :-1] / extents[:, 1:]
    if len(gaps) == 1 or not bends:
        return gaps.max(0)
    bent = extents[1] / extents[0] >= (sizes[1] / sizes[0]) ** BENT
    return np.where(bent[:-1], gaps[0], gaps.max(0))
