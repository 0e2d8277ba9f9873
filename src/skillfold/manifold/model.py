"""The fitted model as plain arrays, and the way from states to its coordinates and back.

Inside, states are centred, divided by the rms radius of the samples, and stripped of directions that are free
everywhere; outside, they are as the user gave them.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.manifold.kernels.surface import Field, Surface, Trust

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]


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
        step: ℓ, median edge length, inner.
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
        return np.ascontiguousarray((states - self.centre) @ self.kept / self.scale)

    def moved(self, states: Array, inner: Array) -> Array:
        """States (..., D) with their inner coordinates replaced; what is free stays."""
        return states + (inner - self.encode(states)) @ self.kept.T * self.scale
