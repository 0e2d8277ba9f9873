"""Small random surfaces and tangent fields for the kernels: bent sheets with anchors, smooth fields along them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skillfold.manifold.kernels.scratch import evaluator
from skillfold.manifold.kernels.surface import Field, Surface, Trust
from skillfold.manifold.kernels.tabled import tabled
from skillfold.manifold.model import as_maps, build_surface
from skillfold.manifold.polynomials import monomials

# D, d, M, K, degree; the last but one has anchors enough for lists of neighbours, the last too few for a full blend.
SHAPES = [
    (2, 1, 30, 3, 2),
    (3, 1, 12, 5, 3),
    (3, 2, 40, 8, 2),
    (4, 2, 25, 4, 4),
    (5, 3, 300, 6, 1),
    (3, 2, 5, 2, 1),
]


@dataclass
class RandomModel:
    surface: Surface
    field: Field
    trust: Trust
    rng: np.random.Generator

    @cached_property
    def _table(self):
        D = len(self.surface.points)
        return tabled(self.surface, self.field, np.zeros(D), np.eye(D), 1.0, evaluator())

    @property
    def table(self):
        return self._table.entries

    scale = 1.0  # inner coordinates are the states themselves

    def encode(self, states):
        return states

    def moved(self, states, inner):
        return inner

    def states(self, count, spread=0.1):
        """States around the anchors."""
        anchors = self.surface.points.T
        chosen = anchors[self.rng.integers(0, len(anchors), count)]
        return chosen + spread * self.rng.normal(size=chosen.shape)


def random_model(seed, D, d, M, K, degree):
    """M anchors on a sheet x = A u + 0.2 sin(B u), its frames turned a little, K kernels."""
    rng = np.random.default_rng(seed)
    A, B = np.linalg.qr(rng.normal(size=(D, d)))[0], rng.normal(size=(D, d))

    def slopes(u):
        return A + 0.2 * np.cos(u @ B.T)[..., None] * B

    u = rng.uniform(-1, 1, (M, d))
    tilted = slopes(u) + 0.02 * rng.normal(size=(M, D, d))
    frames = np.swapaxes(np.linalg.qr(np.concatenate([tilted, rng.normal(size=(M, D, D - d))], 2))[0], 1, 2)
    table = monomials(d, degree)
    coefficients = 0.05 * rng.normal(size=(M, D - d, len(table.parents)))
    coefficients[:, :, 0] = 0.0
    centres = rng.uniform(-1, 1, (K, d))
    points = np.ascontiguousarray((u @ A.T + 0.2 * np.sin(u @ B.T)).T)
    radii = rng.uniform(0.4, 0.9, M)
    surface = build_surface(points, *as_maps(frames, coefficients, radii), radii, table)
    field = Field(
        np.ascontiguousarray((centres @ A.T + 0.2 * np.sin(centres @ B.T)).T),
        1.0 / (2.0 * 0.8**2),
        np.ascontiguousarray(np.transpose(slopes(centres), (2, 1, 0))),
    )
    return RandomModel(surface, field, Trust(0.5, 0.2, 0.4, rng.random(M) < 0.7, 2.0), rng)
