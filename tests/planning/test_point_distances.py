"""The compiled loops over obstacle points, against their twins and against dense sampling."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from manifold.kernels import callable_of
from planning import twins
from skillfold.planning import point_distances
from skillfold.tables import table_of

loops = callable_of(point_distances)
LAWS = settings(max_examples=40, deadline=None)
RADIUS = 0.3


def table(points, radius=RADIUS):
    arrays = {
        loops.POINTS: np.ascontiguousarray(points.T),
        loops.RADIUS: np.array([radius]),
        loops.SQUARES: np.zeros(len(points)),
    }
    return table_of(arrays, loops.SLOTS)


@pytest.fixture(params=[(1, 1), (1, 3), (40, 2), (25, 7)], ids=str)
def cloud(request):
    rng = np.random.default_rng(request.param[0])
    points = rng.normal(size=request.param)
    return points, table(points), rng


def test_measure(cloud):
    points, made, rng = cloud
    q = rng.normal(size=points.shape[1])
    loops.measure(q, made.entries)
    np.testing.assert_allclose(made.arrays[loops.SQUARES], ((points - q) ** 2).sum(1), rtol=1e-14)


def test_away_from(cloud):
    points, made, rng = cloud
    q, out = rng.normal(size=points.shape[1]), np.full(points.shape[1], 7.0)
    loops.away_from(0, q, float(np.linalg.norm(q - points[0])), made.entries, out)
    np.testing.assert_allclose(out, twins.gradient(points[:1], q), atol=1e-14)
    loops.away_from(0, points[0], 0.0, made.entries, out)
    np.testing.assert_array_equal(out, 0.0)


def test_clearance(cloud):
    points, made, rng = cloud
    for q in 2 * rng.normal(size=(20, points.shape[1])):
        gradient = np.full(len(q), 7.0)
        assert loops.clearance(q, gradient, made.entries) == pytest.approx(twins.clearance(points, RADIUS, q))
        assert loops.clearance(q, np.empty(0), made.entries) == pytest.approx(twins.clearance(points, RADIUS, q))
        np.testing.assert_allclose(gradient, twins.gradient(points, q), atol=1e-12)


def test_clearances(cloud):
    points, made, rng = cloud
    states = rng.normal(size=(15, points.shape[1]))
    for gradients in (np.empty(states.shape), np.empty((0, points.shape[1]))):
        out = np.empty(15)
        loops.clearances(states, made.entries, out, gradients)
        np.testing.assert_allclose(out, twins.clearance(points, RADIUS, states), atol=1e-14)
        for q, gradient in zip(states, gradients, strict=False):
            np.testing.assert_allclose(gradient, twins.gradient(points, q), atol=1e-12)


@pytest.mark.parametrize("reach", [-0.1, 0.0, 0.5, 3.0, 100.0])
def test_within(cloud, reach):
    points, made, rng = cloud
    room = np.empty(len(points)), np.empty(points.shape)
    for q in (*rng.normal(size=(10, points.shape[1])), points[0]):
        count = loops.within(q, reach, *room, made.entries)
        distances, gradients = twins.within(points, RADIUS, q, reach)
        assert count == len(distances)
        np.testing.assert_allclose(room[0][:count], distances, atol=1e-14)
        np.testing.assert_allclose(room[1][:count], gradients, atol=1e-12)


def test_within_finds_no_more_than_there_is_room_for(cloud):
    points, made, _ = cloud
    room = np.empty(2), np.empty((2, points.shape[1]))
    assert loops.within(points[0], 1e6, *room, made.entries) == min(2, len(points))


@pytest.mark.parametrize("margin", [0.0, 0.05, 0.5])
def test_edge(cloud, margin):
    points, made, rng = cloud
    for start, end in 3 * rng.normal(size=(30, 2, points.shape[1])):
        found = loops.edge(start, end, margin, made.entries)
        assert found == pytest.approx(twins.share(points, RADIUS, start, end, margin), abs=1e-9)


@given(seed=st.integers(0, 2**32 - 1), D=st.integers(1, 6), log_size=st.floats(-6, 6), margin=st.floats(0, 1))
@LAWS
def test_the_clear_share_of_an_edge_is_exact(seed, D, log_size, margin):
    """Up to it dense samples keep the margin, at it the clearance is the margin; whatever the unit."""
    rng, size = np.random.default_rng(seed), 10.0**log_size
    points = size * rng.normal(size=(8, D))
    start, end = size * 3 * rng.normal(size=(2, D))
    radius, margin = 0.3 * size, margin * size
    share = loops.edge(start, end, margin, table(points, radius).entries)
    assert 0 <= share <= 1
    if share == 0:
        assert twins.clearance(points, radius, start) <= margin + 1e-9 * size
        return
    states = start + np.linspace(0, share, 2000)[:, None] * (end - start)
    clear = twins.clearance(points, radius, states)
    assert (clear >= margin - 1e-9 * size).all()
    if share < 1:
        assert clear[-1] == pytest.approx(margin, abs=1e-9 * size)


def test_an_edge_without_length_is_clear_where_its_state_is():
    made = table(np.zeros((1, 2)))
    for x, clear in [(0.29, 0.0), (0.31, 1.0)]:
        q = np.array([x, 0.0])
        assert loops.edge(q, q, 0.0, made.entries) == clear


def test_an_edge_loses_no_digits_where_a_small_ball_is_far():
    """A ball of 1e-3 at a distance of 100, met in the middle of an edge twice as long."""
    made = table(np.array([[100.0, 0.0]]), 1e-3)
    share = loops.edge(np.zeros(2), np.array([200.0, 0.0]), 0.0, made.entries)
    assert share * 200 == pytest.approx(100 - 1e-3, abs=1e-9)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_states_that_are_not_finite_are_told(cloud, value):
    points, made, _ = cloud
    q, fine = np.zeros(points.shape[1]), np.full(points.shape[1], 9.0)
    q[-1] = value
    room = np.empty(len(points)), np.empty(points.shape)
    assert np.isnan(loops.clearance(q, np.empty(0), made.entries))
    assert loops.within(q, 1.0, *room, made.entries) == -1
    assert loops.edge(q, fine, 0.0, made.entries) == 0.0
    assert loops.edge(fine, q, 0.0, made.entries) == 0.0
