"""Geodesic kernels against their twins on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import geodesic, projection, scratch_memory
from manifold.random_models import SHAPES, random_model
from skillfold.manifold.kernels.scratch import evaluator
from skillfold.manifold.kernels.tabled import tabled


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(23, *request.param)


@pytest.fixture(scope="module")
def ends(model):
    """Pairs of states on the surface, far from each other."""
    anchors = model.surface.points.T
    pairs = []
    for i in model.rng.choice(len(anchors), 5, replace=False):
        far = np.linalg.norm(anchors - anchors[i], axis=1).argsort()[-3]
        on, _ = projection.project_states(model.table, model.trust, anchors[[i, far]])
        pairs.append((on[0], on[1]))
    return pairs


def relax_free(path, *settings):
    return geodesic.relax(path, *settings, geodesic.leave_free, None)


def test_leave_free(model):
    scratch, force, stiffness = room(model, 3), np.ones((3, 2)), np.ones((3, 2, 2))
    geodesic.leave_free(None, 0, model.states(3), scratch.bases, scratch, stiffness, force)
    assert (force == 1.0).all()
    assert (stiffness == 1.0).all()


def room(model, n):
    return scratch_memory.make_scratch(model.table, n)


@pytest.mark.parametrize(("step", "limit"), [(0.1, 200), (0.3, 200), (0.05, 6), (10.0, 4)])
def test_grow_path(model, ends, step, limit):
    for start, goal in ends:
        grown = np.empty((limit, len(start)))
        count = geodesic.grow_path(start, goal, step, grown, room(model, 1))
        expected = twins.grow_path(model.surface, model.field, start, goal, step, limit)
        assert count == (0 if expected is None else len(expected))
        if expected is not None:
            np.testing.assert_allclose(grown[:count], expected, atol=1e-10)


@pytest.mark.parametrize("count", [2, 3, 17, 100])
def test_resample(count):
    rng = np.random.default_rng(count)
    path = rng.normal(size=(12, 3)).cumsum(0)
    path[4] = path[3]  # a pause
    out = np.empty((count, 3))
    geodesic.resample(path, out)
    np.testing.assert_allclose(out, twins.resample(path, count), atol=1e-12)
    np.testing.assert_array_equal(out[[0, -1]], path[[0, -1]])


def test_resample_of_a_path_without_length():
    out = np.empty((5, 2))
    geodesic.resample(np.ones((3, 2)), out)
    np.testing.assert_array_equal(out, np.ones((5, 2)))


def bent(start, goal, n, rng):
    """A first path beside the straight line, its ends as given."""
    share = np.linspace(0.0, 1.0, n)[:, None]
    return start + share * (goal - start) + 0.05 * np.sin(np.pi * share) * rng.normal(size=start.shape)


def found_at(model, path):
    scratch = room(model, len(path))
    scratch_memory.evaluate(path, scratch)
    scratch.normals[[0, -1]] = 0.0
    return scratch.normals, scratch.bases


@pytest.mark.parametrize("n", [3, 4, 12])
def test_newton_steps(model, ends, n):
    for start, goal in ends:
        path = bent(start, goal, n, model.rng)
        normals, bases = found_at(model, path)
        d = bases.shape[1]
        steps = np.zeros_like(path)
        roots, force = model.rng.normal(size=(n, d, d)), model.rng.normal(size=(n, d))
        for stiffness, pushes in [(0.0 * roots, 0.0 * force), (roots @ roots.swapaxes(1, 2), force)]:
            geodesic.newton_steps(path, normals, bases, stiffness, pushes, np.empty((n, d, d + 1)), steps)
            expected = twins.newton_steps(path, normals, bases, stiffness, pushes)
            np.testing.assert_allclose(steps, expected, atol=1e-10)


@pytest.mark.parametrize(("m", "n"), [(4, 9), (13, 50), (13, 26)])
def test_refine(m, n):
    coarse = np.random.default_rng(m).normal(size=(m, 3)).cumsum(0)
    path = np.empty((n, 3))
    geodesic.refine(coarse, path)
    np.testing.assert_allclose(path, twins.refine(coarse, n), atol=1e-12)
    np.testing.assert_array_equal(path[[0, -1]], coarse[[0, -1]])


@pytest.mark.parametrize(("n", "cap"), [(3, 0.3), (4, 0.3), (12, 0.3), (12, 0.01)])
def test_one_step_of_relax(model, ends, n, cap):
    for start, goal in ends:
        path = bent(start, goal, n, model.rng)
        steps = twins.newton_steps(path, *found_at(model, path))
        lengths = np.linalg.norm(steps, axis=1, keepdims=True)
        expected = path + steps * np.minimum(1.0, cap / np.maximum(lengths, 1e-300))
        found = relax_free(path, 0.0, cap, 1, 0.5, False, 1.0, room(model, len(path)))
        assert found == pytest.approx((1, 0.5 * lengths.max(), 0.5), abs=1e-10)
        np.testing.assert_allclose(path, expected, atol=1e-10)


def test_relax_until_it_settles(model, ends):
    for start, goal in ends:
        path = bent(start, goal, 10, model.rng)
        expected, iterations, _, _ = twins.relax(model.surface, model.field, path, 1e-9, 0.3, 60, 1.0)
        found = relax_free(path, 1e-9, 0.3, 60, 1.0, False, 1.0, room(model, len(path)))
        assert abs(found[0] - iterations) <= 2  # rounding in least squares of steps that are nearly alike
        assert max(found[0], iterations) < 60
        np.testing.assert_allclose(path, expected, atol=1e-8)


def test_relax_ends_where_the_plain_steps_vanish(model, ends):
    for start, goal in ends:
        path = bent(start, goal, 10, model.rng)
        relax_free(path, 1e-10, 0.3, 100, 1.0, False, 1.0, room(model, len(path)))
        assert np.abs(twins.newton_steps(path, *found_at(model, path))).max() < 1e-8


@pytest.mark.parametrize("points", [8, 40])
@pytest.mark.parametrize("step", [0.1, 0.3])
def test_solve_geodesic(model, ends, step, points):
    """With few states, and with many, of which few are relaxed first."""
    for start, goal in ends:
        path = np.empty((points, len(start)))
        found = geodesic.solve_geodesic(model.table, np.stack([start, goal]), step, path, 1e-9, 0.3, 100, False, 1.0)
        grown = twins.grow_path(model.surface, model.field, start, goal, step, geodesic.GROWN)
        if grown is None:
            assert found == (0, np.inf)
            continue
        assert 0 < found[0] < 100
        assert found[1] < 1e-9
        np.testing.assert_array_equal(path[[0, -1]], [start, goal])
        assert np.abs(twins.newton_steps(path, *found_at(model, path))).max() < 1e-7


def test_solve_geodesic_says_where_ends_do_not_meet(model, ends):
    first = np.stack(ends[0])
    path = np.full((5, first.shape[1]), 7.0)
    tiny = np.linalg.norm(first[1] - first[0]) / 1e5  # more steps than a first path may have
    assert geodesic.solve_geodesic(model.table, first, tiny, path, 1e-9, 0.3, 30, False, 1.0) == (0, np.inf)
    np.testing.assert_array_equal(path, 7.0)


def test_solve_geodesic_from_a_first_path(model, ends):
    """It is relaxed as it is, with all its states."""
    for start, goal in ends:
        first = bent(start, goal, 7, model.rng)
        path, expected = np.empty((40, len(start))), np.empty((40, len(start)))
        found = geodesic.solve_geodesic(model.table, first, 0.1, path, 1e-9, 0.3, 100, False, 1.0)
        geodesic.resample(first, expected)
        assert relax_free(expected, 1e-9, 0.3, 100, 1.0, False, 1.0, room(model, len(expected)))[0] == found[0]
        np.testing.assert_allclose(path, expected, atol=1e-8)


def test_solve_inner_is_solve_geodesic_in_other_coordinates(model, ends):
    """Of states with one coordinate more, which is free."""
    D = len(ends[0][0])
    rng = np.random.default_rng(5)
    kept, centre = np.linalg.qr(rng.normal(size=(D + 1, D)))[0], rng.normal(size=D + 1)
    table = tabled(model.surface, model.field, centre, kept, 2.5, evaluator())
    for start, goal in ends:
        first = bent(start, goal, 7, model.rng)
        inner, path = np.empty((30, D)), np.empty((30, D + 1))
        settings = 1e-9, 0.3, 100, False, 1.0
        found = geodesic.solve_inner(first, 0.1, inner, *settings, room(model, 30))
        states = centre + 2.5 * first @ kept.T
        assert geodesic.solve_geodesic(table.entries, states, 0.1, path, *settings)[0] == found[0]
        np.testing.assert_allclose(path, centre + 2.5 * inner @ kept.T, atol=1e-8)
