"""Noisy samples smoothed more than once: local surfaces fitted to the samples that local surfaces denoised.

Another fit averages the noise over more samples than one alone could without rounding off the folds. Its neighbours
are told by place and tangent: samples are the farther apart the more the surface turns between them. On a flat part
they come from all of it, and along a fold from far along it, but not from beyond.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import KDTree

from skillfold.manifold.anchors import LocalSurfaces, fit_surfaces
from skillfold.manifold.kernels.surface import BLENDED, blend
from skillfold.manifold.nearest import nearest
from skillfold.manifold.polynomials import design, monomials, terms_of
from skillfold.manifold.shapes import DOUBTED, WINSOR, Chosen, Shape, smoothness
from skillfold.manifold.table import Trial

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

AGAIN = 2  # further fits tried
TURNED = 0.7  # rms radii that tangents at right angles are apart: at more, opposite sides of a thin tube would meet
NOISY = 4.0  # samples a coefficient: so many are chosen only where they average noise
LOCAL = 8  # times the usual neighbourhood fit into the samples: another fit to one that is most of them tells nothing
FOLDS = 5  # of the samples, each left out in turn
SURE = 3.0  # standard errors of the difference from which on no further folds are looked at
PREDICTED = 1000  # left-out samples that are enough whatever they tell
MEASURE = "held-out residual (smaller)"


class Serving(NamedTuple):
    """Which shape serves at each of M centres.

    Attributes:
        shapes: of the local surfaces.
        served: (M,) index of the shape.
        dim: d.
        jobs: threads.
    """

    shapes: list[Shape]
    served: Indices
    dim: int
    jobs: int

    @property
    def degree(self) -> int:
        """The highest."""
        return max(s.degree for s in self.shapes)

    @property
    def noisy(self) -> bool:
        """Whether the usual shape averages noise, over neighbourhoods that are small among n samples."""
        usual = self.shapes[int(np.bincount(self.served).argmax())]
        return smoothness(usual, self.dim) >= NOISY and LOCAL * usual.neighbours <= len(self.served)

    def fit(self, samples: Array, centres: Array, start: Array | None = None) -> LocalSurfaces:
        """Surfaces at the centres, each of the shape that serves there; lower degrees are padded with zeros."""
        M, D = centres.shape if start is None else start.shape[:2]
        frames, radii = np.empty((M, D, D)), np.empty(M)
        coefficients = np.zeros((M, terms_of(self.dim, self.degree), D - self.dim))
        for index, shape in enumerate(self.shapes):
            here = np.flatnonzero(self.served == index)
            k = min(shape.neighbours + 1, len(samples))
            if len(here):
                around = nearest(samples, centres[here], k, self.jobs)
                begin = None if start is None else start[here]
                local = fit_surfaces(samples, centres[here], around, self.dim, shape.degree, self.jobs, begin)
                frames[here], radii[here] = local.frames, local.radii
                coefficients[here, : local.coefficients.shape[1]] = local.coefficients
        return LocalSurfaces(frames, coefficients, radii)

    def fits(self, samples: Array, again: int) -> Iterator[tuple[Array, LocalSurfaces]]:
        """The samples and surfaces at them; then, `again` times, the denoised samples and surfaces fitted to them."""
        points, local = samples, self.fit(samples, samples)
        yield points, local
        for _ in range(again):
            points = points + local.shifts
            placed = np.hstack([points, tilts(local.tangents)])
            local = self.fit(placed, placed, local.frames)
            yield points, local


def denoised(
    samples: Array, chosen: Indices, judged: Chosen, dim: int, unordered: bool, seed: int, jobs: int
) -> tuple[Array, LocalSurfaces, list[Trial]]:
    """Anchors (M, D), local surfaces around them, and trials where there was a choice.

    Samples that all become anchors are fitted once, unless more fits predict left-out ones clearly better.
    Recordings are fitted once: what they are off by is how they differ from each other.

    Args:
        samples: (N, D).
        chosen: (M,) those that become anchors.
        judged: the shapes.
        dim: d.
        unordered: whether the samples are no recordings.
        seed: of the folds.
        jobs: threads.
    """
    centres = samples[chosen]
    serving = Serving(judged.shapes, judged.at(samples, centres), dim, jobs)
    if not unordered or len(centres) < len(samples) or not serving.noisy:
        local = serving.fit(samples, centres)
        return centres + local.shifts, local, []
    squares = held_out_squares(serving, samples, seed)
    best, difference = _best_again(squares)
    again = best if difference < -DOUBTED else 0
    *_, (points, local) = serving.fits(samples, again)
    errors = np.sqrt(squares.mean(1))
    trials = [Trial("smoothing", f"{i + 1} ×", float(e), MEASURE, i == again) for i, e in enumerate(errors)]
    return points + local.shifts, local, trials


def tilts(tangents: Array) -> Array:
    """Columns that set tangents (M, D, d) apart: TURNED² Σ sin²θ, squared, over the angles between them; (M, ·)."""
    rows, columns = np.triu_indices(tangents.shape[1])
    weights = TURNED * np.where(rows == columns, np.sqrt(0.5), 1.0)
    return weights * (tangents @ np.swapaxes(tangents, 1, 2))[:, rows, columns]


def held_out_squares(serving: Serving, samples: Array, seed: int) -> Array:
    """Squared distances of left-out samples from the surface after each fit, winsorised; (AGAIN + 1, n).

    Of as many folds as it takes to tell whether one fit is best.
    """
    fold = np.random.default_rng(seed).permutation(len(samples)) % FOLDS
    found, squares = [], np.empty((AGAIN + 1, 0))
    for f in range(FOLDS):
        found.append(_squares(serving, samples, fold == f))
        squares = np.hstack(found)
        squares = np.minimum(squares, np.quantile(squares, WINSOR, axis=1, keepdims=True))
        if abs(_best_again(squares)[1]) > SURE or squares.shape[1] >= PREDICTED:
            break
    return squares


def _squares(serving: Serving, samples: Array, held: Flags) -> Array:
    rest = serving._replace(served=serving.served[~held])
    fits = rest.fits(samples[~held], AGAIN)
    return np.array(
        [(_displacements(points, local, rest.degree, samples[held]) ** 2).sum(1) for points, local in fits]
    )


def _displacements(points: Array, local: LocalSurfaces, degree: int, states: Array) -> Array:
    """From the surface to states (n, D), blended as in a model: one surface alone would seem noisier than it is."""
    anchors = points + local.shifts
    distances, found = KDTree(anchors).query(states, min(BLENDED + 1, len(anchors)))
    squares = np.asarray(distances) ** 2
    weights = np.empty((len(states), squares.shape[1] - 1))
    blend(squares, weights)
    near = np.asarray(found)[:, :-1]
    frames = local.frames[near]
    offsets = np.einsum("ijab,ijb->ija", frames, states[:, None] - points[near])
    along, across = np.split(offsets, [local.dim], axis=2)
    values = design(along / local.radii[near][:, :, None], monomials(local.dim, degree))
    off = across - np.einsum("ijp,ijpn->ijn", values, local.coefficients[near])
    return np.einsum("ij,ijn,ijnc->ic", weights, off, frames[:, :, local.dim :])


def _best_again(squares: Array) -> tuple[int, float]:
    """The row of least mean but for the first, and its difference from that one in standard errors."""
    best = 1 + int(squares[1:].mean(1).argmin())
    difference = squares[best] - squares[0]
    error = max(float(difference.std()) / np.sqrt(difference.size), 1e-300)
    return best, float(difference.mean()) / error
