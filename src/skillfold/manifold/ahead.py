"""`python -m skillfold.manifold.ahead` compiles projection, on a sheet of a few anchors that need not be learnt."""

import numpy as np

from skillfold.manifold.kernels.judging import nearest_distances
from skillfold.manifold.kernels.projection import bring_onto
from skillfold.manifold.kernels.scratch import evaluator
from skillfold.manifold.kernels.surface import Field, Trust
from skillfold.manifold.kernels.tabled import tabled
from skillfold.manifold.model import as_maps, build_surface
from skillfold.manifold.polynomials import monomials

ANCHORS = 4


def project_onto_a_line() -> None:
    """Call what brings states onto a skill, once."""
    ones = np.ones(ANCHORS)
    maps = as_maps(np.tile(np.eye(2), (ANCHORS, 1, 1)), np.zeros((ANCHORS, 1, 2)), ones)
    points = np.vstack([np.arange(float(ANCHORS)), 0.0 * ones])
    surface = build_surface(points, *maps, ones, monomials(1, 1))
    field = Field(np.zeros((2, 1)), 1.0, np.array([[[1.0], [0.0]]]))
    states = np.ones((1, 2))
    table = tabled(surface, field, np.zeros(2), np.eye(2), 1.0, evaluator())
    bring_onto(table.entries, Trust(1.0, 1.0, 1.0, np.ones(ANCHORS, bool), 1.0), states)
    nearest_distances(table.entries, states)


if __name__ == "__main__":
    project_onto_a_line()
