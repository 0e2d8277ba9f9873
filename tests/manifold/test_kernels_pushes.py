"""Penalties on clearance and limits against their twins, and as derivatives of what they penalise."""

import numpy as np
import pytest

from manifold import twins_around as twins
from manifold.kernels import pushes
from manifold.random_terrains import TERRAINS, random_terrain


@pytest.fixture(params=TERRAINS, ids=str)
def terrain(request):
    return random_terrain(51, *request.param)


def tangents_of(terrain, count=None):
    """Orthonormal rows (d, D)."""
    d = terrain.dim if count is None else count
    return np.ascontiguousarray(np.linalg.qr(terrain.model.rng.normal(size=(terrain.width, d)))[0].T)


def empty(tangents):
    d = len(tangents)
    return np.zeros((d, d)), np.zeros(d)


def pushed(terrain, state, normal, tangents, margin, steepest):
    stiffness, force = empty(tangents)
    D, m = terrain.width, terrain.compiled.capacity
    room = np.empty(m), np.empty((m, D)), np.empty(D)
    told = pushes.push_off_obstacles(
        terrain.land.chart, terrain.barrier, state, normal, tangents, margin, steepest, *room, stiffness, force
    )
    return stiffness, force, *told


def near_balls(terrain, count=10):
    """States a share of the radius from the surface of a ball's."""
    rng, balls = terrain.model.rng, terrain.land.balls
    at = balls.points[rng.integers(0, len(balls.points), count)]
    off = rng.normal(size=at.shape)
    return at + rng.uniform(0.7, 4.0, (count, 1)) * balls.radius * off / np.linalg.norm(off, axis=1)[:, None]


@pytest.mark.parametrize("steepest", [0.0, 100.0])
def test_push_off_obstacles(terrain, steepest):
    seen = 0
    for state in near_balls(terrain):
        tangents, normal = tangents_of(terrain), 0.1 * terrain.model.rng.normal(size=terrain.width)
        found = pushed(terrain, state, normal, tangents, terrain.margin, steepest)
        chart, balls = terrain.land.chart, terrain.land.balls
        wanted = twins.push_off_obstacles(chart, balls, state, normal, tangents, terrain.margin, steepest)
        for a, b in zip(found, wanted, strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)
        seen += found[1].any()
    assert seen


def test_pushes_are_the_slope_of_a_penalty_on_the_depth(terrain):
    """Of ½ STIFF (depth as a way in coordinates)², by differences."""
    chart, balls, h = terrain.land.chart, terrain.land.balls, 1e-6
    tangents = tangents_of(terrain, terrain.width)

    def penalty(state):
        depths = np.maximum(terrain.margin - balls.within(state, terrain.margin)[0], 0.0) / chart.scale
        return 0.5 * twins.STIFF * (depths**2).sum()

    for state in near_balls(terrain):
        _, force, least, steepest = pushed(terrain, state, np.zeros(terrain.width), tangents, terrain.margin, 0.0)
        ways = h * chart.scale * tangents @ chart.axes
        slope = [(penalty(state + step) - penalty(state - step)) / (2 * h) for step in ways]
        np.testing.assert_allclose(-force, slope, atol=1e-5)
        assert least == pytest.approx(min(balls.clearance(state), twins.SIGHT * terrain.margin))
        assert steepest == pytest.approx(chart.scale) or least == twins.SIGHT * terrain.margin


def test_out_of_sight_nothing_pushes(terrain):
    far = terrain.land.chart.centre + 1e3
    tangents = tangents_of(terrain)
    stiffness, force, least, steepest = pushed(terrain, far, np.zeros(len(far)), tangents, terrain.margin, 0.0)
    assert not stiffness.any()
    assert not force.any()
    assert (least, steepest) == (twins.SIGHT * terrain.margin, 0.0)


def test_push_off_limits(terrain):
    chart, rng = terrain.land.chart, terrain.model.rng
    for share in rng.uniform(-1.1, 1.1, (20, terrain.width)):
        state = chart.centre + share * (chart.upper - chart.centre)
        tangents, normal = tangents_of(terrain), 0.1 * rng.normal(size=terrain.width)
        stiffness, force = empty(tangents)
        pushes.push_off_limits(chart, state, normal, tangents, np.empty(terrain.width), stiffness, force)
        wanted = twins.push_off_limits(chart, state, normal, tangents)
        np.testing.assert_allclose(stiffness, wanted[0], atol=1e-9)
        np.testing.assert_allclose(force, wanted[1], atol=1e-9)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_limits_push_inward_once_they_are_near(terrain, side):
    """By a step of the whole depth, were there no springs: ‖slope‖ of a coordinate is the scale."""
    chart, tangents = terrain.land.chart, np.eye(terrain.width)
    limit = chart.upper if side > 0 else chart.lower
    for beyond, pushes_there in [(0.02, True), (-0.5 * twins.INSET, True), (-2 * twins.INSET, False)]:
        state = chart.centre.copy()
        state[1] = limit[1] + side * beyond * chart.scale
        stiffness, force = empty(tangents)
        pushes.push_off_limits(chart, state, np.zeros(len(state)), tangents, np.empty(len(state)), stiffness, force)
        assert force.any() == pushes_there
        if pushes_there:
            step = np.linalg.lstsq(stiffness, force, rcond=None)[0]
            moved = chart.scale * step @ chart.axes
            wanted = -side * (beyond + twins.INSET) * chart.scale * np.eye(len(state))[1]
            np.testing.assert_allclose(moved, wanted, atol=1e-9)


@pytest.mark.parametrize("steepest", [0.0, 1.0, 1e3])
def test_add_push(terrain, steepest):
    """To what is there; flat gradients are not taken for an infinite depth."""
    rng, D = terrain.model.rng, terrain.width
    tangents = tangents_of(terrain)
    stiffness, force = rng.normal(size=(len(tangents), len(tangents))), rng.normal(size=len(tangents))
    before = stiffness.copy(), force.copy()
    slope, normal = rng.normal(size=D), rng.normal(size=D)
    pushes.add_push(slope, 0.3, steepest, twins.STIFF, normal, tangents, stiffness, force)
    more, pushed_by = twins.push(slope, 0.3, steepest, normal, tangents)
    np.testing.assert_allclose(stiffness, before[0] + more, atol=1e-10)
    np.testing.assert_allclose(force, before[1] + pushed_by, atol=1e-10)


def test_where_there_is_no_slope_there_is_no_push(terrain):
    tangents = tangents_of(terrain)
    stiffness, force = empty(tangents)
    zero = np.zeros(terrain.width)
    pushes.add_push(zero, 0.3, 0.0, twins.STIFF, zero, tangents, stiffness, force)
    np.testing.assert_array_equal(stiffness, 0.0)
    np.testing.assert_array_equal(force, 0.0)


def test_between_an_obstacle_and_a_limit_the_limit_wins(terrain):
    """Where both have the same gradient, a state rests within the limit though the obstacle asks for more room."""
    chart, tangents = terrain.land.chart, np.eye(terrain.width)
    state, zero = chart.centre.copy(), np.zeros(terrain.width)
    rest = chart.upper[1]
    state[1] = rest - twins.INSET * chart.scale  # where the limit begins to push
    outward = chart.scale * chart.axes[:, 1]
    asked = 5.0 * twins.INSET * chart.scale  # by the obstacle, further out
    for _ in range(50):
        stiffness, force = empty(tangents)
        depth = asked - (state[1] - (rest - twins.INSET * chart.scale))
        pushes.add_push(outward, depth, 0.0, twins.STIFF, zero, tangents, stiffness, force)
        pushes.push_off_limits(chart, state, zero, tangents, np.empty(len(state)), stiffness, force)
        state += chart.scale * (np.linalg.lstsq(stiffness, force, rcond=None)[0] @ chart.axes)
    assert rest - twins.INSET * chart.scale < state[1] < rest
