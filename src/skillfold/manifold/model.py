"""The fitted model as plain arrays, and the way from states to its coordinates and back.

Inside, states are centred, divided by the rms radius of the samples, and stripped of directions that are free
everywhere; outside, they are as the user gave them.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skillfold.lanes import padded
from skillfold.manifold.kernels.projection import GHOST
from skillfold.manifold.kernels.scratch import evaluator
from skillfold.manifold.kernels.surface import Field, Surface, Trust
from skillfold.manifold.kernels.tabled import tabled
from skillfold.manifold.nearest import nearest
from skillfold.manifold.polynomials import Monomials
from skillfold.tables import Table

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

LISTED = 48  # neighbours that each anchor knows
MANY = 192  # anchors from which on it is faster to ask them than to ask all
APART = 0.2  # of the spacing: anchors that disagree by less speak of one sheet


@dataclass(frozen=True)
class Model:
    """A learnt manifold of dimension d in D coordinates; M anchors, K kernels, f free directions.

    Attributes:
        surface: the anchors' local polynomials, in D - f inner coordinates.
        field: the tangent field H, in the same.
        centre: (D,) mean of the samples.
        scale: rms radius of the samples; inner coordinates are divided by it.
        kept: (D, D - f) orthonormal columns, the directions that are modelled.
        free: (D, f) orthonormal columns, the directions along which everything is allowed.
        free_extent: (f,) largest distance of a sample from the centre along each free direction.
        edges: (E, 2) neighbouring anchors.
        step: ℓ, usual distance between neighbouring anchors, inner.
        tolerance: 95 % quantile of held-out residuals, inner: nearer states count as on the manifold.
        trust: how far the surface is believed, inner.
    """

    surface: Surface
    field: Field
    centre: Array
    scale: float
    kept: Array
    free: Array
    free_extent: Array
    edges: Indices
    step: float
    tolerance: float
    trust: Trust

    @property
    def table(self) -> Indices:
        """The model as compiled loops take it from Python."""
        return self._table.entries

    @property
    def arrays(self) -> Mapping[int, np.ndarray[Any, Any]]:
        """What the table points to, by slot, for tables that hold more than a model."""
        return self._table.arrays

    @cached_property
    def _table(self) -> Table:
        return tabled(self.surface, self.field, self.centre, self.kept, self.scale, evaluator())

    @cached_property
    def _outward(self) -> Array:
        """(D - f, D) from inner coordinates to offsets from the centre."""
        return self.scale * self.kept.T

    def __getstate__(self) -> dict[str, Any]:
        """For another process, where the table's addresses mean nothing."""
        return {name: value for name, value in self.__dict__.items() if name != "_table"}

    @property
    def n_dims(self) -> int:
        """D."""
        return len(self.centre)

    @property
    def dim(self) -> int:
        """d, free directions included."""
        return self.field.weights.shape[0] + self.free.shape[1]

    @property
    def anchors(self) -> Array:
        """(M, D - f), inner."""
        return self.surface.points.T

    def encode(self, states: Array) -> Array:
        """Inner coordinates (..., D - f) of states (..., D)."""
        return ((states - self.centre) @ self.kept) / self.scale

    def path(self, start: Array, goal: Array, inner: Array) -> Array:
        """States (n, D) with inner coordinates (n, D - f); what is free goes straight from start to goal."""
        states = inner @ self._outward
        states += self.centre
        if self.free.shape[1]:
            first, last = (start - self.centre) @ self.free, (goal - self.centre) @ self.free
            share = np.linspace(0.0, 1.0, len(inner))[:, None]
            states += (first + share * (last - first)) @ self.free.T
        return states

    def moved(self, states: Array, inner: Array) -> Array:
        """States (..., D) with their inner coordinates replaced; what is free stays."""
        return states + (inner - self.encode(states)) @ self.kept.T * self.scale


def build_surface(
    points: Array, tangents: Array, bends: Array, radii: Array, table: Monomials, jobs: int = 1
) -> Surface:
    """The surface of anchors (D, M) with all that its loops look up.

    Args:
        points: (D, M).
        tangents: (M, d, D), divided by the radii.
        bends: (M, D, P).
        radii: (M,).
        table: of the monomials.
        jobs: threads.
    """
    rows = np.ascontiguousarray(points.T)
    neighbours, reach = np.empty((len(rows), 0), dtype=np.int64), np.zeros(len(rows))
    if len(rows) >= MANY:
        neighbours = nearest(rows, rows, LISTED, jobs)
        reach = np.sqrt(((rows[neighbours[:, -1]] - rows) ** 2).sum(1))
    # Of anchors that coincide, another one may be named first.
    order = np.argsort(neighbours != np.arange(len(rows))[:, None], axis=1, kind="stable")
    neighbours = np.take_along_axis(neighbours, order, 1)
    (M, d, D), P = tangents.shape, bends.shape[2]
    charts, maps = np.zeros((M, 1 + D, padded(d))), np.zeros((M, 1 + P, padded(D)))
    charts[:, 0, :d] = -np.einsum("mac,mc->ma", tangents, rows)
    charts[:, 1:, :d] = np.swapaxes(tangents, 1, 2)
    maps[:, 0, :D] = rows
    maps[:, 1:, :D] = np.swapaxes(bends, 1, 2)
    return Surface(points, rows, charts, maps, neighbours, reach, radii, *table)


def trust_in(spacing: float, doubt: float, cap: float, sure: Any) -> Trust:
    """How far a surface is believed; see `Trust` for the arguments.

    The blend of two sheets h apart, which disagree by δ, lies about δ²/h beside the nearer one. No sheets can be told
    apart that are nearer each other than samples are: while δ is a small share of the spacing, the blend is off by
    the square of that share at most. With next to no noise a usual doubt says little of sheets, but much of how
    steady the surface is at its anchors.
    """
    return Trust(spacing, doubt, cap, sure, max(GHOST * doubt, APART * spacing))


def as_maps(frames: Array, coefficients: Array, radii: Array) -> tuple[Array, Array]:
    """Local polynomials as `build_surface` wants them: tangents (M, d, D) and bends (M, D, P).

    Args:
        frames: (M, D, D) orthonormal rows, the first d tangent.
        coefficients: (M, D - d, P) of v(u / radius) along the others.
        radii: (M,).
    """
    dim = frames.shape[1] - coefficients.shape[1]
    tangents, normals = frames[:, :dim], frames[:, dim:]
    bends = np.einsum("mnp,mnc->mcp", coefficients, normals)
    bends[:, :, 1 : 1 + dim] += np.swapaxes(tangents, 1, 2) * radii[:, None, None]
    return np.ascontiguousarray(tangents / radii[:, None, None]), np.ascontiguousarray(bends)
