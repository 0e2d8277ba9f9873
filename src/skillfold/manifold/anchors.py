"""Local surfaces at anchors: weighted polynomials in tangent coordinates, fitted to the samples around.

Paper 000 ties a path to the manifold only by aligning neighbouring tangents (err_M), so errors add up along it.
Anchors tie it to the data: at each, the samples around are written as v(u), displacement along the normals over
position along the tangents. A surface evaluated at its own anchor is the denoised sample.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from skillfold.manifold.polynomials import design, monomials

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

CHUNK = 2_000_000  # numbers that one batch of local fits may hold
RIDGE = 1e-9  # relative; keeps a fit to too few or aligned neighbours solvable
FRAME_ROUNDS = 2  # times a frame is turned to its own surface's slope


@dataclass(frozen=True)
class LocalSurfaces:
    """Polynomials v(u / radius) in the frames of M centres.

    Attributes:
        frames: (M, D, D) orthonormal rows; the first d are tangents.
        coefficients: (M, P, D - d).
        radii: (M,).
    """

    frames: Array
    coefficients: Array
    radii: Array

    @property
    def dim(self) -> int:
        """The manifold's dimension d."""
        return self.frames.shape[1] - self.coefficients.shape[2]

    @property
    def shifts(self) -> Array:
        """From each centre to the surface, along the normals; (M, D)."""
        return np.einsum("mn,mnc->mc", self.coefficients[:, 0], self.frames[:, self.dim :])

    @property
    def tangents(self) -> Array:
        """(M, D, d) orthonormal columns."""
        return np.swapaxes(self.frames[:, : self.dim], 1, 2)


def wendland(r: Array) -> Array:
    """Wendland's C² weight (1 − r)⁴(4r + 1), zero beyond r = 1."""
    r = np.minimum(r, 1.0)
    return (1.0 - r) ** 4 * (4.0 * r + 1.0)


def _principal_frames(offsets: Array, weights: Array) -> Array:
    mean = (weights[..., None] * offsets).sum(1) / weights.sum(1)[:, None]
    centred = offsets - mean[:, None]
    scatter = np.swapaxes(centred * weights[..., None], 1, 2) @ centred
    return np.swapaxes(np.linalg.eigh(scatter)[1][:, :, ::-1], 1, 2)


def _solve(offsets: Array, weights: Array, frames: Array, radii: Array, dim: int, degree: int) -> Array:
    """Coefficients of the weighted least squares polynomials; (M, P, D - d)."""
    local = offsets @ np.swapaxes(frames, 1, 2)
    root = np.sqrt(weights)[..., None]
    rows = design(local[..., :dim] / radii[:, None, None], monomials(dim, degree)) * root
    turned = np.swapaxes(rows, 1, 2)
    gram = turned @ rows
    P = gram.shape[1]
    ridge = RIDGE * np.trace(gram, axis1=1, axis2=2) / P + 1e-300
    gram[:, np.arange(P), np.arange(P)] += ridge[:, None]
    return np.asarray(np.linalg.solve(gram, turned @ (local[..., dim:] * root)), dtype=np.float64)


def _turned(frames: Array, coefficients: Array, radii: Array, dim: int) -> Array:
    """Frames whose tangents have the slope that the polynomials have at their centres."""
    slopes = coefficients[:, 1 : 1 + dim] / radii[:, None, None]
    tangents = frames[:, :dim] + slopes @ frames[:, dim:]
    basis = np.linalg.qr(np.swapaxes(tangents, 1, 2), mode="complete")[0]
    return np.swapaxes(basis, 1, 2)


def fit_offsets(offsets: Array, dim: int, degree: int) -> LocalSurfaces:
    """Fit to neighbours given relative to their centres, offsets (M, k, D)."""
    distances = np.linalg.norm(offsets, axis=2)
    radii = np.maximum(1.05 * distances.max(1), 1e-300)
    weights = wendland(distances / radii[:, None])
    frames = _principal_frames(offsets, weights)
    for _ in range(FRAME_ROUNDS):
        frames = _turned(frames, _solve(offsets, weights, frames, radii, dim, degree), radii, dim)
    coefficients = _solve(offsets, weights, frames, radii, dim, degree)
    return LocalSurfaces(np.ascontiguousarray(frames), coefficients, radii)


def _chunks(count: int, k: int, dim: int, degree: int) -> Iterator[slice]:
    size = max(1, CHUNK // (k * len(monomials(dim, degree).parents)))
    for start in range(0, count, size):
        yield slice(start, min(start + size, count))


def fit_surfaces(samples: Array, centres: Array, neighbours: Indices, dim: int, degree: int) -> LocalSurfaces:
    """Local surfaces at centres (M, D) from the samples (N, D) that neighbours (M, k) name."""
    parts = [
        fit_offsets(samples[neighbours[part]] - centres[part, None], dim, degree)
        for part in _chunks(len(centres), neighbours.shape[1], dim, degree)
    ]
    return LocalSurfaces(
        np.concatenate([p.frames for p in parts]),
        np.concatenate([p.coefficients for p in parts]),
        np.concatenate([p.radii for p in parts]),
    )


def nearest_others(samples: Array, chosen: Indices, k: int, groups: Indices | None) -> Indices:
    """The k nearest samples of each chosen one, its own recording (or itself) left out; (len(chosen), k)."""
    if groups is None:
        return np.asarray(KDTree(samples).query(samples[chosen], k + 1)[1])[:, 1:]
    found = np.empty((len(chosen), k), dtype=np.int64)
    for group in np.unique(groups[chosen]):
        others = np.flatnonzero(groups != group)
        asked = np.flatnonzero(groups[chosen] == group)
        found[asked] = others[KDTree(samples[others]).query(samples[chosen[asked]], k)[1]].reshape(-1, k)
    return found


def held_out_residuals(samples: Array, chosen: Indices, others: Indices, dim: int, degree: int) -> Array:
    """Distance of each chosen sample from the surface of the nearest sample that is not left out with it.

    That surface is fitted to `others` (n, k), sorted by distance, the chosen sample not among them. Judged at its
    own centre a surface would hide the bias that it has where it is used, beside it.
    """
    centres = samples[others[:, 0]]
    surfaces = fit_surfaces(samples, centres, others, dim, degree)
    local = np.einsum("mij,mj->mi", surfaces.frames, samples[chosen] - centres)
    values = design(local[:, :dim] / surfaces.radii[:, None], monomials(dim, degree))
    return np.linalg.norm(local[:, dim:] - np.einsum("mp,mpn->mn", values, surfaces.coefficients), axis=1)
