"""The edge of the demonstrations, against its twins on random points and models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import edges, evaluated, scratch_memory
from manifold.random_models import SHAPES, random_model

ENOUGH = 1e-3


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(13, *request.param)


def in_hull(points):
    found, carrying = np.empty(points.shape[1]), np.empty(points.shape[1] + 2, np.int64)
    count = edges.nearest_in_hull(points, ENOUGH, found, carrying)
    assert len(set(carrying[:count])) == count
    assert np.ptp(points[carrying[:count]] @ found) <= 1e-6 or np.linalg.norm(found) <= ENOUGH  # a face lies across
    return found


@pytest.mark.parametrize("dim", [1, 2, 3, 4, 7])
@pytest.mark.parametrize("aside", [0.0, 1.0, 4.0])
def test_nearest_in_hull(dim, aside):
    """Amid the points, at their edge and far from them."""
    rng = np.random.default_rng(dim)
    for _ in range(20):
        points = rng.normal(size=(12 + 4 * dim, dim))
        points[:, 0] += aside
        expected, found = twins.nearest_in_hull(points), in_hull(points)
        if np.linalg.norm(expected) > ENOUGH:
            np.testing.assert_allclose(found, expected, atol=1e-8)
        else:
            assert np.linalg.norm(found) <= ENOUGH


def test_nearest_in_hull_of_points_that_coincide_or_are_aligned():
    rng = np.random.default_rng(0)
    for points in (np.ones((5, 3)), np.outer(np.arange(1.0, 7.0), [1.0, 2.0]), rng.integers(1, 4, (20, 3)) * 1.0):
        np.testing.assert_allclose(in_hull(points), twins.nearest_in_hull(points), atol=1e-6)


def test_smallest_product():
    rng = np.random.default_rng(1)
    points, direction = rng.normal(size=(9, 4)), rng.normal(size=4)
    assert edges.smallest_product(points, direction) == (points @ direction).argmin()


def test_nearest_in_plane():
    """The shortest vector whose differences to the points lie in their plane."""
    rng = np.random.default_rng(2)
    points, carrying = rng.normal(size=(9, 3)), np.array([4, 2, 7, 0, 0])
    shares, gram = np.empty((6, 1)), np.empty((6, 6))
    for count in (1, 2, 3):
        edges.nearest_in_plane(points, carrying, count, gram, shares)
        chosen = points[carrying[:count]]
        found = shares[:count, 0] @ chosen
        assert shares[:count].sum() == pytest.approx(1.0)
        np.testing.assert_allclose((chosen - found) @ found, 0.0, atol=1e-8)


def test_look_around(model):
    n = model.surface.points.shape[1]
    distances, around, squares = np.empty(n), np.empty(5, np.int64), np.empty(5)
    for state in model.states(5, 0.5):
        edges.look_around(model.surface.points, state, distances, around, squares)
        expected = ((model.surface.rows - state) ** 2).sum(1)
        np.testing.assert_array_equal(around, np.argsort(expected, kind="stable")[:5])
        np.testing.assert_allclose(squares, np.sort(expected)[:5], atol=1e-12)


@pytest.mark.parametrize("short", [1e-3, 10.0])
def test_is_amid(model, short):
    around, basis = np.array([3, 0, 1]), np.linalg.qr(model.rng.normal(size=model.surface.points.shape))[0][:, :1].T
    look = edges.Look(around, np.empty(3), np.empty((5, 1)), np.empty(1), np.empty(3, np.int64))
    for state in model.states(10, 0.5):
        amid = edges.is_amid(model.surface.rows, around, state, basis, short, look)
        way = twins.nearest_in_hull((model.surface.rows[around] - state) @ basis.T)
        assert amid == (abs(way[0]) <= short)
        if not amid:
            np.testing.assert_allclose(look.inward, way, atol=1e-8)


def test_offset_by(model):
    around, basis = np.array([3, 0, 1]), model.rng.normal(size=(2, len(model.surface.points)))
    offsets, state = np.empty((3, 2)), model.states(1)[0]
    edges.offset_by(model.surface.rows, around, state, basis, offsets)
    np.testing.assert_allclose(offsets, (model.surface.rows[around] - state) @ basis.T, atol=1e-12)


def test_is_within(model):
    states, short = model.states(12, 0.5), 0.01
    scratch = evaluated(model, states)
    look = edges.make_look(scratch, scratch.bases.shape[1])
    for i, state in enumerate(states):
        way = twins.way_in(model.surface, model.field, state)
        within = edges.is_within(state, i, short, scratch, look)
        assert within == (np.linalg.norm(way) <= 1.001 * short)
        if not within:
            np.testing.assert_allclose(look.inward, way, atol=1e-8)


def test_mean_step():
    path = np.random.default_rng(0).normal(size=(7, 3))
    assert edges.mean_step(path) == pytest.approx(np.linalg.norm(np.diff(path, axis=0), axis=1).mean())


@pytest.mark.parametrize("spread", [0.0, 0.3, 1.0])
def test_beyond_edge(model, spread):
    """Paths among the anchors and outside; each state is looked at where they are a spacing apart."""
    for _ in range(5):
        path = model.states(9, spread)
        spacing = 0.5 * edges.mean_step(path)
        far = np.linalg.norm([twins.way_in(model.surface, model.field, x) for x in path[1:-1]], axis=1)
        # The ends are seen along the tangents at the states beside them.
        ends = [twins.way_in(model.surface, model.field, path[i], path[j]) for i, j in ((0, 1), (-1, -2))]
        allowed = max(0.02 * spacing, *(1.5 * np.linalg.norm(ends, axis=1)))
        found = edges.beyond_edge(path, spacing, evaluated(model, path[1:-1].copy()))
        assert found == pytest.approx(allowed if far.max() > 1.001 * allowed else 0.0, abs=1e-8)


def test_draw_in(model):
    """Feet of states around the anchors, some of them beyond the last; one that is on no surface is left alone."""
    feet = [twins.step_back(model.surface, model.field, x, 1e-10) for x in model.states(12, 0.6)]
    points, on = np.array([p for p, _ in feet]), np.array([met for _, met in feet])
    given = points.copy()
    flags = on.copy()
    edges.draw_in(model.trust.spacing, points, 1e-10, scratch_memory.make_scratch(model.table, 12), flags)
    for start, met, point, still in zip(given, on, points, flags, strict=True):
        expected = twins.draw_in(model.surface, model.field, model.trust.spacing, start) if met else (start, False)
        assert still == expected[1]
        np.testing.assert_allclose(point, expected[0], atol=1e-8)
