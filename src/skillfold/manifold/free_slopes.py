"""Free directions made exact: turned until the surface has no slope along them any more.

States may lie far off along a free direction, and a projection keeps how far: an angle of a fiftieth between what
was found and what is free takes a state a fiftieth of that way off the constraint. Normals of local planes tell the
angle no better. But samples near each other in the kept directions lie scattered along the free ones, so the slope of
the surface along these can be read with a long lever. So can whether it bends with them: then they are not free.
"""

from typing import Any

import numpy as np
from scipy.spatial import KDTree

from skillfold.manifold.anchors import LocalSurfaces, fit_surfaces
from skillfold.manifold.polynomials import design, monomials, terms_of
from skillfold.manifold.samples import SAME

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

DEGREE = 2  # of the local surfaces beneath
PER_TERM = 3  # samples a coefficient
EXACT = 1e-12  # of the heights' mean square: what is left of a surface without noise is rounding
TURNS = 4  # each leaves a quarter of the angle or so, in what normals rarely touch a half


def without_slope(
    samples: Array, kept: Array, free: Array, dim: int, chosen: Indices, jobs: int
) -> tuple[Array, Array]:
    """Kept and free directions (D, D - f), (D, f) turned so that the surface has no slope along the free ones.

    Args:
        samples: (N, D).
        kept, free: orthonormal columns, nearly right.
        dim: of the manifold within the kept directions.
        chosen: (M,) samples around which slopes are looked at.
        jobs: threads.
    """
    f = free.shape[1]
    for _ in range(TURNS):
        slope = common_slope(samples @ kept, samples @ free, dim, chosen, jobs)
        turned = np.linalg.qr(np.hstack([free + kept @ slope, kept]))[0]
        kept, free = np.ascontiguousarray(turned[:, f:]), np.ascontiguousarray(turned[:, :f])
    return kept, free


def common_slope(inner: Array, free: Array, dim: int, chosen: Indices, jobs: int) -> Array:
    """The shift of inner coordinates with each free one that best explains the surface's slopes; (D - f, f).

    Around each chosen sample the others' heights n·(x − c) are a polynomial of their place along the surface, plus
    n·S·z where z are their free coordinates: one S for all, by least squares. What z has in common with the
    polynomial is taken off first (Frisch and Waugh), as off the heights.

    Args:
        inner: (N, D - f) kept coordinates.
        free: (N, f).
        dim, chosen, jobs: as in `without_slope`.
    """
    k = min(PER_TERM * terms_of(dim, DEGREE) + 1, len(inner))
    around, local, offsets = _surfaces(inner, dim, chosen, k, jobs)
    heights, levers = _apart(local, offsets, offsets[:, :, dim:], free[around])
    normals = local.frames[:, dim:]
    projectors = np.einsum("mna,mnb->mab", normals, normals)
    spreads = np.einsum("mki,mkj->mij", levers, levers)
    size = inner.shape[1] * free.shape[1]
    equations = np.einsum("mab,mij->aibj", projectors, spreads).reshape(size, size)
    right = np.einsum("mna,mkn,mki->ai", normals, heights, levers)
    # Inner coordinates that no normal touches are left alone: the shortest solution.
    return np.linalg.lstsq(equations, right.ravel(), rcond=1e-9)[0].reshape(right.shape)


def bending(inner: Array, free: Array, dim: int, chosen: Indices, jobs: int) -> float:
    """How much of heights above local surfaces a polynomial of the free coordinates explains, over what chance would.

    The ratio of mean squares of an F test, of all neighbourhoods together: about one where nothing depends on what
    is free; infinite where there are too few samples to tell.

    Args:
        inner: (N, D - f) kept coordinates.
        free: (N, f).
        dim, chosen, jobs: as in `without_slope`.
    """
    along, aside = terms_of(dim, DEGREE), terms_of(free.shape[1], DEGREE) - 1
    k = min(PER_TERM * (along + aside) + 1, len(inner))
    if k <= along + aside + 1:
        return np.inf
    around, local, offsets = _surfaces(inner, dim, chosen, k, jobs)
    levers = free[around] - free[around].mean(1, keepdims=True)
    levers /= max(float(np.abs(levers).max()), 1e-300)
    terms = _terms(offsets[:, :, :dim] / local.radii[:, None, None]), _terms(levers)[:, :, 1:]
    heights = offsets[:, :, dim:]
    parts = np.swapaxes(np.linalg.qr(np.concatenate(terms, 2))[0], 1, 2) @ heights
    total, explained, by_free = ((part**2).sum((1, 2)) for part in (heights, parts, parts[:, along:]))
    rounding = k * SAME**2 * float(inner.var(0).sum()) + 1e-300
    rest = np.maximum(total - explained, EXACT * total + rounding)
    share = float((by_free / (by_free + rest)).mean())
    return share / (1.0 - share) * (k - along - aside) / aside


def _surfaces(inner: Array, dim: int, chosen: Indices, k: int, jobs: int) -> tuple[Indices, LocalSurfaces, Array]:
    """The k samples (M, k) around each chosen one, the surface fitted to them, their offsets in its frame."""
    around = np.asarray(KDTree(inner).query(inner[chosen], k)[1])
    local = fit_surfaces(inner, inner[chosen], around, dim, DEGREE, jobs)
    return around, local, np.einsum("mij,mkj->mki", local.frames, inner[around] - inner[chosen][:, None])


def _terms(u: Array) -> Array:
    """All monomials of u (M, k, d) up to the degree; (M, k, P)."""
    return design(u.reshape(-1, u.shape[2]), monomials(u.shape[2], DEGREE)).reshape(*u.shape[:2], -1)


def _apart(local: LocalSurfaces, offsets: Array, *values: Array) -> list[Array]:
    """Values (M, k, m), weighted, less what polynomials of the offsets (M, k, D - f) along the surface explain."""
    r = np.linalg.norm(offsets, axis=2) / local.radii[:, None]
    root = np.sqrt((1.0 - r) ** 4 * (4.0 * r + 1.0))[:, :, None]
    basis = np.linalg.qr(root * _terms(offsets[:, :, : local.dim] / local.radii[:, None, None]))[0]
    weighted = [root * v for v in values]
    return [v - basis @ (np.swapaxes(basis, 1, 2) @ v) for v in weighted]
