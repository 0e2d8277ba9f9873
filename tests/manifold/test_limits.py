"""Projection of skills whose coordinates have limits."""

from dataclasses import replace

import numpy as np
import pytest

from manifold.conftest import fit
from skillfold import SkillManifold, StateSpace

TOP = 0.5  # limit of the last coordinate
RIDGE = 1.02  # of a surface that no limit of that coordinate meets


@pytest.fixture(scope="module")
def dome():
    """A unit sphere learnt without limits, and the same with one: its cap is out of bounds."""
    x = np.random.default_rng(0).normal(size=(600, 3))
    whole = fit(x / np.linalg.norm(x, axis=1, keepdims=True), dim=2)
    return whole, replace(whole, space=StateSpace.linear(3, upper=[np.inf, np.inf, TOP]))


def states(count=200):
    return np.random.default_rng(1).normal(size=(count, 3)) * 1.5


def test_states_end_on_the_surface_within_the_limits(dome):
    whole, bounded = dome
    on = bounded.project(states())
    assert (whole.project(states())[:, 2] > TOP).sum() > 20
    assert on[:, 2].max() <= TOP
    assert bounded.distance(on).max() < 1e-8
    np.testing.assert_allclose(bounded.project(on), on, atol=1e-8)


def test_where_the_limits_are_kept_nothing_changes(dome):
    whole, bounded = dome
    free = whole.project(states())
    kept = free[:, 2] <= TOP
    np.testing.assert_array_equal(bounded.project(states())[kept], free[kept])


def test_what_is_beyond_ends_at_the_limit_on_its_own_side(dome):
    whole, bounded = dome
    free, on = whole.project(states()), bounded.project(states())
    beyond = free[:, 2] > TOP + 0.01
    np.testing.assert_allclose(on[beyond, 2], TOP, atol=1e-6)
    sides = (on[beyond, :2] * free[beyond, :2]).sum(1)
    assert (sides > 0.95 * np.linalg.norm(on[beyond, :2], axis=1) * np.linalg.norm(free[beyond, :2], axis=1)).all()


def test_tracked_states_keep_the_limits_too(dome):
    _, bounded = dome
    near = bounded.project(states())
    on = bounded.project(near + 0.05, near=near)
    assert on[:, 2].max() <= TOP
    assert bounded.distance(on).max() < 1e-8


def test_ends_of_a_plan_are_brought_within_the_limits(dome):
    _, bounded = dome
    plan = bounded.plan([0.0, 0.6, 1.0], [0.8, 0.0, -0.3])
    assert plan.path.states[0, 2] <= TOP
    assert plan.start_moved > 0.0


def test_where_surface_and_limits_do_not_meet_the_limits_win(dome):
    whole, _ = dome
    apart = replace(whole, space=StateSpace.linear(3, lower=[-np.inf, -np.inf, RIDGE]))
    on = apart.project(states())
    assert on[:, 2].min() >= RIDGE
    assert apart.distance(on).max() < 2.0 * (RIDGE - 1.0)


def test_limits_are_kept_after_saving(dome, tmp_path):
    _, bounded = dome
    bounded.save(tmp_path / "dome.npz")
    again = SkillManifold.load(tmp_path / "dome.npz")
    np.testing.assert_array_equal(again.project(states()), bounded.project(states()))


def _clipped_recordings():
    t, rng = np.linspace(0.0, 1.0, 60), np.random.default_rng(1)
    w = rng.normal(size=(3, 5))
    return [np.clip(np.sin(np.outer(t, [1, 2, 3]) @ w / 2 + 0.1 * rng.normal(size=5)), -0.4, 0.6) for _ in range(5)]


@pytest.mark.parametrize("route", [None, "geodesic"])
def test_plans_between_demonstrated_states_keep_the_limits_that_these_touch(route):
    recordings = _clipped_recordings()
    skill = fit(recordings, 1, space=StateSpace.linear(5, -0.4, 0.6))
    for a, b in ((0, -1), (-1, 0), (5, 40), (9, 9)):
        plan = skill.plan(recordings[0][a], recordings[1][b], route=route)
        assert plan.success, plan.reason
        assert skill.space.contains(plan.path.states, 1e-9).all()
        np.testing.assert_array_equal(plan.path.states[[0, -1]], [recordings[0][a], recordings[1][b]])


def test_geodesics_keep_the_limits_that_noisy_samples_touch():
    """A smooth surface lies beyond some of them."""
    rng = np.random.default_rng(1)
    places = rng.uniform(-1.0, 1.0, (250, 2))
    samples = np.column_stack([places, 0.3 * (places**2).sum(1)]) + 1e-3 * rng.normal(size=(250, 3))
    space = StateSpace.linear(3, samples.min(0), samples.max(0))
    skill = fit(samples, 2, space=space)
    corners = [samples[(samples @ [x, y, 0.5]).argmax()] for x in (-1.0, 1.0) for y in (-1.0, 1.0)]
    touching = [samples[:, i].argmax() for i in range(3)] + [samples[:, i].argmin() for i in range(3)]
    for state in (*corners, *samples[touching]):
        for goal in (corners[0], state):
            plan = skill.plan(state, goal)
            assert plan.success, plan.reason
            assert space.contains(plan.path.states, 1e-9).all()
