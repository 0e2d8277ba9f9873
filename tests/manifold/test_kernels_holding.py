"""Geodesics held within the edge of the demonstrations, against twins on random models."""

import numba
import numpy as np
import pytest

from manifold import twins
from manifold.clouds import bay
from manifold.kernels import evaluated, geodesic, holding, relax, scratch_memory
from manifold.random_models import SHAPES, random_model
from skillfold.manifold.kernels import geodesic as compiled
from skillfold.manifold.kernels.holding import pull_back
from skillfold.manifold.skill import SkillManifold

ALLOWED, STIFFNESS = 0.02, 3.0


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(37, *request.param)


def edge_of(scratch, n):
    return holding.make_edge(ALLOWED, n, 1.0, 1.0, scratch, scratch.bases.shape[1])._replace(stiffness=STIFFNESS)


def test_make_edge(model):
    scratch = scratch_memory.make_scratch(model.table, 4)
    edge = holding.make_edge(ALLOWED, 7, 0.02, 0.5, scratch, 3)
    known = min(12 + 4 * 3, len(model.surface.rows))
    assert edge.allowed == ALLOWED
    assert edge.stiffness == pytest.approx((0.02 / (0.1 * 0.5)) ** 2)
    assert (edge.around.shape, edge.offsets.shape, edge.face.shape) == ((7, known), (known, 3), (3, 3))


def test_pull_back(model):
    """The force as it is, and the stiffness as its slope; anchors are looked up in some iterations alone."""
    path = model.states(12, 0.5)
    scratch = evaluated(model, path)
    n, d = len(path), scratch.bases.shape[1]
    edge, force, stiffness = edge_of(scratch, n), np.zeros((n, d)), np.zeros((n, d, d))
    holding.pull_back(edge, 0, path, scratch.bases, scratch, stiffness, force)
    for i in range(1, n - 1):
        np.testing.assert_array_equal(edge.around[i], twins.anchors_around(model.surface, path[i], d))
        offsets = (model.surface.rows[edge.around[i]] - path[i]) @ scratch.bases[i].T
        expected, slope = twins.pull_and_slope(offsets, ALLOWED, STIFFNESS)
        np.testing.assert_allclose(force[i], expected, atol=1e-7)
        np.testing.assert_allclose(stiffness[i], slope, atol=1e-3)
    kept = edge.around.copy()
    holding.pull_back(edge, 1, path[::-1].copy(), scratch.bases[::-1].copy(), scratch, stiffness, force)
    np.testing.assert_array_equal(edge.around, kept)


def test_directions():
    rng = np.random.default_rng(3)
    points, carrying, face = rng.normal(size=(9, 4)), np.array([5, 2, 7]), np.empty((4, 4))
    points[6] = 2.0 * points[2] - points[5]  # in line with the first two
    assert holding.directions(points, carrying[:1], face) == 0
    for chosen in (carrying, np.array([5, 2, 6, 7])):
        assert holding.directions(points, chosen, face) == 2
        np.testing.assert_allclose(face[:2] @ face[:2].T, np.eye(2), atol=1e-9)
        aside = points[carrying[1:]] - points[5]
        np.testing.assert_allclose(aside @ face[:2].T @ face[:2], aside, atol=1e-6)


def test_leave_free(model):
    """Without an edge nothing is added; with one that allows everything neither."""
    for _ in range(3):
        ends = model.surface.rows[model.rng.choice(len(model.surface.rows), 2, replace=False)]
        free = np.linspace(ends[0], ends[1], 12)
        held, scratch = free.copy(), scratch_memory.make_scratch(model.table, 12)
        settings = 1e-9, 0.3, 100, 1.0, False, 1.0, scratch
        expected = relax(free, *settings)
        assert relax_held(held, *settings, edge_of(scratch, 12)._replace(allowed=1e3)) == expected
        np.testing.assert_array_equal(held, free)


@numba.njit
def relax_held(path, tolerance, cap, limit, share, own, rate, scratch, edge):
    return compiled.relax(path, tolerance, cap, limit, share, own, rate, scratch, pull_back, edge)


def test_hold_geodesic():
    """Between two horns of land the shortest path crosses the bay; one that is held goes along the shore."""
    model = SkillManifold.fit(bay(300, 1), jobs=1).model
    ends = np.array([[-0.8, 0.3, -0.072], [0.8, 0.3, 0.072]])
    path, spacing = np.empty((50, 3)), model.trust.spacing
    settings = 1e-9, 0.3, 100, False, 1.0
    assert geodesic.solve_geodesic(model.table, ends, model.step, path, *settings)[1] < 1e-9
    held = path.copy()
    iterations, moved = holding.hold_geodesic(model.table, held, spacing, *settings)
    assert iterations > 0
    assert moved < 1e-9
    np.testing.assert_allclose(held[[0, -1]], path[[0, -1]], atol=1e-14)
    once = held.copy()
    assert holding.hold_geodesic(model.table, once, 50.0 * spacing, *settings) == (0, 0.0)  # wherever it may go
    np.testing.assert_array_equal(once, held)
    held, path = model.encode(held), model.encode(path)
    far = [max(np.linalg.norm(twins.way_in(model.surface, model.field, x)) for x in p) for p in (path, held)]
    assert far[0] > 5.0 * far[1]
    steps = np.linalg.norm(np.diff(held, axis=0), axis=1)
    assert steps.max() < 1.5 * steps.mean()
    assert np.abs(evaluated(model, held).normals[1:-1]).max() < 1e-6
