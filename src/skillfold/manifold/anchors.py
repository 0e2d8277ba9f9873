"""Local surfaces at anchors: weighted polynomials in tangent coordinates, fitted to the samples around.

Paper 000 ties a path to the manifold only by aligning neighbouring tangents (err_M), so errors add up along it.
Anchors tie it to the data: at each, the samples around are written as v(u), displacement along the normals over
position along the tangents. A surface evaluated at its own anchor is the denoised sample.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.manifold.kernels import patches as kernels
from skillfold.manifold.nearest import nearest, nearest_of_others
from skillfold.manifold.polynomials import Monomials, design, monomials, terms_of
from skillfold.manifold.threads import in_parts

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

SAMPLES_A_TERM = 1.5  # that a polynomial is fitted to, at least
TURNS = 2  # of a frame to its own surface's slope
NEARER = 0.25  # of a neighbourhood, among which the centre of a surface is looked for: next to it, on the same sheet
JUDGED_TURNS = 1  # the same, where only heights above it are asked for, not tangents


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


def _principal_frames(samples: Array, centres: Array, neighbours: Indices) -> Array:
    """Principal directions of the weighted neighbours as rows, the widest first; (M, D, D)."""
    vectors = np.linalg.eigh(kernels.scatters(samples, centres, neighbours))[1]
    return np.ascontiguousarray(np.swapaxes(vectors[:, :, ::-1], 1, 2))


def _layout(dim: int, degrees: Sequence[int]) -> tuple[Monomials, int, Indices]:
    """Monomials for fits up to the last degree, how many of them tell a frame's slope, and how many each degree has.

    Quadratic ones tell the slope, or a plane's where nothing else is fitted.
    """
    terms = np.array([terms_of(dim, degree) for degree in degrees])
    return monomials(dim, degrees[-1]), terms_of(dim, min(degrees[-1], 2)), terms


def fit_surfaces(
    samples: Array,
    centres: Array,
    neighbours: Indices,
    dim: int,
    degree: int,
    jobs: int = 1,
    start: Array | None = None,
) -> LocalSurfaces:
    """Local surfaces at centres (M, D) from the samples (N, D) that neighbours (M, k) name.

    Where frames (M, D, D) to start from are given, samples and centres may have further columns: they count for
    the distances that weigh the neighbours, and for nothing else.
    """
    layout = _layout(dim, [degree])
    neighbours = np.ascontiguousarray(neighbours)

    def fit(part: slice) -> LocalSurfaces:
        around = neighbours[part]
        frames = _principal_frames(samples, centres[part], around) if start is None else start[part].copy()
        fits = kernels.fit_patches(samples, centres[part], around, frames, dim, *layout, TURNS)
        return LocalSurfaces(frames, fits[0][0], fits[1])

    parts = in_parts(fit, len(centres), jobs)
    found = zip(*((p.frames, p.coefficients, p.radii) for p in parts), strict=True)
    return LocalSurfaces(*(np.concatenate(arrays) for arrays in found))


def nearest_others(samples: Array, chosen: Indices, k: int, groups: Indices | None, jobs: int = 1) -> Indices:
    """The k nearest samples of each chosen one, its own recording (or itself) left out; (len(chosen), k)."""
    if groups is None:
        return nearest(samples, samples[chosen], k + 1, jobs)[:, 1:]
    return nearest_of_others(samples, groups, chosen, k, jobs)


def _beside(samples: Array, states: Array, others: Indices, tangents: Array) -> Indices:
    """Of the nearer ones of others (n, k), sorted, that which is nearest to each state along its tangents (n, d, D).

    The nearest in all directions shares the state's noise, where that is as wide as samples lie apart: it was chosen
    for that. Its surface would predict the state better than any surface does that was learnt without looking at it.
    """
    nearer = others[:, : max(1, int(NEARER * others.shape[1]))]
    along = np.einsum("ndc,nkc->nkd", tangents, samples[nearer] - states[:, None])
    return nearer[np.arange(len(nearer)), (along**2).sum(2).argmin(1)]


def held_out_residuals(
    samples: Array,
    chosen: Indices,
    others: Indices,
    dim: int,
    degrees: Sequence[int],
    jobs: int = 1,
    ordered: bool = False,
) -> Array:
    """Distance of each chosen sample from the surface of a sample beside it that is not left out with it.

    That surface is fitted to `others` (n, k), sorted by distance, the chosen sample not among them. Judged at its
    own centre a surface would hide the bias that it has where it is used, beside it. Of `ordered` samples, whole
    recordings, it is the nearest: what these differ by is no noise of single samples. Several ascending degrees cost
    hardly more than the highest of them; (len(degrees), n).
    """
    others = np.ascontiguousarray(others)
    # Planes turn to a slope of their own: they are not fitted along with the others.
    together = [part for part in ([g for g in degrees if g == 1], [g for g in degrees if g > 1]) if part]

    def predict(part: slice) -> Array:
        around = others[part]
        principal = _principal_frames(samples, samples[around[:, 0]], around)
        beside = around[:, 0] if ordered else _beside(samples, samples[chosen[part]], around, principal[:, :dim])
        centres = samples[beside]
        rows = []
        for some in together:
            frames, layout = principal.copy(), _layout(dim, some)
            fits, radii = kernels.fit_patches(samples, centres, around, frames, dim, *layout, JUDGED_TURNS)
            local = np.einsum("mij,mj->mi", frames, samples[chosen[part]] - centres)
            values = design(local[:, :dim] / radii[:, None], layout[0])
            rows.append(np.linalg.norm(local[:, dim:] - np.einsum("mp,tmpn->tmn", values, fits), axis=2))
        return np.concatenate(rows)

    return np.concatenate(in_parts(predict, len(chosen), jobs), axis=1)
