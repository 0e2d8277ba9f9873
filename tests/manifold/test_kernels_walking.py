"""Steps that keep clear of obstacles against their twins, on random surfaces among random balls."""

import numpy as np
import pytest

from manifold import twins_around as twins
from manifold.kernels import scratch_memory, walking
from manifold.random_terrains import TERRAINS, random_terrain


@pytest.fixture(params=TERRAINS, ids=str)
def terrain(request):
    return random_terrain(31, *request.param)


def room(terrain):
    return scratch_memory.make_scratch(terrain.model.table, 1)


def row(terrain):
    return np.empty((1, terrain.land.surface.points.shape[0]))


def test_to_state(terrain):
    out = np.empty(terrain.width)
    for z in terrain.states(5):
        walking.to_state(terrain.land.chart, z, out)
        np.testing.assert_allclose(out, twins.to_state(terrain.land.chart, z), atol=1e-13)


def test_to_slope_is_the_derivative_by_coordinates(terrain):
    """Of the clearance, by differences."""
    chart, h, out = terrain.land.chart, 1e-6, np.empty(terrain.width)
    for z in terrain.states(5):
        gradient = terrain.obstacles.clearance_gradient(twins.to_state(chart, z))
        walking.to_slope(chart, gradient, out)
        np.testing.assert_allclose(out, twins.to_slope(chart, gradient), atol=1e-13)
        steps = h * np.eye(terrain.width)
        ahead, behind = (terrain.land.balls.clearance(twins.to_state(chart, z + s)) for s in (steps, -steps))
        np.testing.assert_allclose(out, (ahead - behind) / (2 * h), atol=1e-5)


def test_in_limits(terrain):
    chart = terrain.land.chart
    states = chart.centre + chart.scale * terrain.model.rng.uniform(-1.8, 1.8, (40, terrain.width))
    found = [walking.in_limits(chart, state) for state in (*states, chart.lower, chart.upper)]
    assert found == [twins.in_limits(chart, state) for state in (*states, chart.lower, chart.upper)]
    assert found[-2:] == [True, True]
    assert not walking.in_limits(chart, np.nextafter(chart.upper, np.inf))
    assert not walking.in_limits(chart, np.full(terrain.width, np.nan))


@pytest.mark.parametrize("spread", [0.02, 0.2, 1.0])
def test_settle(terrain, spread):
    scratch, land, answers = room(terrain), terrain.land, set()
    for z in terrain.states(15, spread):
        found = z.copy()
        good = walking.settle(land.support, found, row(terrain), scratch)
        expected, basis, wanted = twins.settle(land, z)
        assert good == wanted
        answers.add(good)
        if wanted:
            np.testing.assert_allclose(found, expected, atol=1e-9)
            np.testing.assert_allclose(scratch.bases[0], basis, atol=1e-9)
            kept = land.surface.points.shape[0]
            np.testing.assert_array_equal(found[kept:], z[kept:])  # what is free stays
    assert spread > 0.5 or True in answers


def test_settle_does_not_believe_what_is_far_or_in_doubt(terrain):
    land, z = terrain.land, terrain.on_surface(1)[0]
    for support in (land.support._replace(farthest=0.0), land.support._replace(doubt=0.0)):
        assert not walking.settle(support, z.copy(), row(terrain), room(terrain))


@pytest.mark.parametrize("margin", [0.0, 0.5, 1.0])
def test_edge_is_clear(terrain, margin):
    land, margin, work = terrain.land, margin * terrain.margin, np.empty((2, terrain.width))
    ends = np.vstack([terrain.states(20, 0.3), terrain.ball_centres()])
    found, wanted = [], []
    for a, b in zip(terrain.states(len(ends), 0.3), ends, strict=True):
        found.append(walking.edge_is_clear(land.chart, terrain.barrier, a, b, margin, work))
        wanted.append(twins.edge_is_clear(land, a, b, margin))
    assert found == wanted
    assert set(found) == {False, True}


@pytest.mark.parametrize(("step", "limit"), [(0.1, 60), (0.25, 60), (0.1, 2), (50.0, 3)])
def test_walk(terrain, step, limit):
    margin, answers = 0.3 * terrain.margin, set()
    starts, targets = terrain.on_surface(12), np.vstack([terrain.on_surface(8), terrain.states(4, 0.2)])
    for start, target in zip(starts, targets, strict=True):
        out = np.empty((limit, terrain.width))
        count, arrived = walking.walk(*terrain.arguments[1:], start, target, step, margin, out, room(terrain))
        expected, wanted = twins.walk(terrain.land, start, target, step, margin, limit)
        assert (count, arrived) == (len(expected), wanted)
        answers.add(arrived)
        if expected:
            np.testing.assert_allclose(out[:count], expected, atol=1e-9)
    assert True in answers or limit == 2


def test_walks_stay_on_the_surface_clear_and_within_limits(terrain):
    """By what they should hold, with no twin."""
    margin, seen = 0.3 * terrain.margin, 0
    for start, target in zip(terrain.on_surface(10), terrain.on_surface(10), strict=True):
        out = np.empty((60, terrain.width))
        count, arrived = walking.walk(*terrain.arguments[1:], start, target, 0.1, margin, out, room(terrain))
        whole = np.vstack([start, out[:count]])
        normals, _ = twins.frames(terrain.land, whole)
        assert np.abs(normals).max() < 1e-7
        shares = np.linspace(0, 1, 50)[:, None, None]
        dense = twins.to_state(terrain.land.chart, whole[:-1] + shares * np.diff(whole, axis=0)).reshape(
            -1, len(start)
        )
        if count:
            assert terrain.land.balls.clearance(dense).min() >= margin * (1 - 1e-6)
            assert (dense >= terrain.land.chart.lower - 1e-9).all()
            assert (dense <= terrain.land.chart.upper + 1e-9).all()
        assert not arrived or np.linalg.norm(whole[-1] - target) <= 0.1
        seen += count
    assert seen > 10


def test_a_walk_does_not_start_off_the_surface(terrain):
    start, target = terrain.on_surface(2)
    far = start + 50.0 * np.arange(1.0, terrain.width + 1)
    out = np.empty((10, terrain.width))
    assert walking.walk(*terrain.arguments[1:], far, target, 0.1, 0.0, out, room(terrain)) == (0, False)


def test_seems_clear(terrain):
    """Where edges cost no more than states it looks at the edge, elsewhere at its end alone."""
    chart, work = terrain.land.chart, np.empty((2, terrain.width))
    chart = chart._replace(lower=np.full(terrain.width, -np.inf), upper=np.full(terrain.width, np.inf))
    ball, far = terrain.ball_centres()[0], np.zeros(terrain.width)
    far[-1] = 50.0
    for exact in (True, False):
        barrier = terrain.barrier._replace(exact=exact)
        assert walking.seems_clear(chart, barrier, ball - far, ball + far, 0.0, work) is not exact
        assert not walking.seems_clear(chart, barrier, ball - far, ball, 0.0, work)
        narrow = chart._replace(upper=np.full(terrain.width, -1e9))
        assert not walking.seems_clear(narrow, barrier, ball - far, ball + far, 0.0, work)
