"""Geodesics of curves that recordings spread about: laws of the fading offset, order of strokes, modes, ends."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from manifold.conftest import curves, fit
from skillfold.experiments.leave_one_out import corrected_mean, distance_between, resample
from skillfold.manifold.leading import SHARES, faded, is_led, led_path, return_share
from skillfold.manifold.route import Route


def strokes(count=6, steps=80, bend=0.0, noise=0.0):
    """Recordings of a narrow V, from one tip to the other by way of the corner, each with an offset that fades."""
    rng = np.random.default_rng(3)
    corners = np.array([[-0.15, 1.0], [0.0 + bend, 0.0], [0.15, 1.0]])
    v = resample(corners, steps)
    fade = np.linspace(1.0, 0.0, steps)[:, None]
    return [v + fade * rng.normal(0.0, 0.05, 2) + rng.normal(0.0, noise, v.shape) for _ in range(count)]


@given(st.sampled_from(SHARES.tolist()), st.integers(9, 401))
def test_offsets_fade_as_their_equation_says(share, count):
    first, last = faded(count, share)
    assert (first[0], first[-1], last[0], last[-1]) == (1.0, 0.0, 0.0, 1.0)
    np.testing.assert_array_equal(first, last[::-1])
    assert (np.diff(last) >= 0.0).all()
    # On equal steps h the solutions of e'' = e / ρ² have second differences 2 (cosh(h / ρ) - 1) e.
    bend = 2.0 * (np.cosh(1.0 / (count - 1) / share) - 1.0)
    np.testing.assert_allclose(np.diff(last, 2), bend * last[1:-1], rtol=1e-6, atol=1e-12)


def test_the_longest_share_is_linear_and_the_shortest_is_next_to_nothing():
    np.testing.assert_allclose(faded(101, SHARES[-1])[1], np.linspace(0, 1, 101), atol=2e-3)
    assert faded(101, SHARES[0])[1][:90].max() < 2e-3


def test_offsets_that_last_fade_slowly_and_noise_at_once():
    rng = np.random.default_rng(0)
    lasting = np.linspace(1.0, 0.0, 101)[:, None] * rng.normal(size=(6, 1, 2))
    weights = np.full(6, 1 / 6)
    assert return_share(lasting, weights) == SHARES[-1]
    assert return_share(rng.normal(size=(6, 101, 2)), weights) <= 2 * SHARES[0]
    for share in SHARES:
        own = faded(101, share)[0][:, None] * rng.normal(size=(6, 1, 2))
        assert return_share(own, weights) == share


def test_strokes_are_followed_in_their_order():
    truth, *others = strokes()
    skill = fit(others, 1, 6)
    assert is_led(skill.model, skill.route)
    plan = skill.plan(truth[0], truth[-1], route="geodesic")
    assert plan.success, plan.reason
    assert plan.converged
    assert "led by the recordings" in plan.reason
    tip = plan.path.states[:, 1].min()
    assert tip < 0.1  # no short cut from stroke to stroke
    start, goal = plan.path.states[[0, -1]]
    assert distance_between(plan.path.states, corrected_mean(others, start, goal)) < 0.02


def test_a_plan_backwards_is_the_same_path():
    recordings = strokes()
    route = Route.fit(recordings)
    assert route is not None
    start, goal = recordings[0][[0, -1]]
    there, back = led_path(route, start, goal, 40), led_path(route, goal, start, 40)
    np.testing.assert_allclose(there.states, back.states[::-1], atol=1e-6)


def test_ends_choose_between_several_ways():
    left, right = strokes(4, bend=-0.6), strokes(4, bend=0.6)
    for recordings in (left, right):
        for recording in recordings:
            recording += 0.0 if recordings is left else [0.8, 0.0]
    route = Route.fit([*left[1:], *right])
    assert route is not None
    found = led_path(route, left[0][0], left[0][-1], 50)
    assert found.converged
    assert distance_between(found.states, left[0]) < 0.02


@pytest.mark.parametrize("part", [(0.0, 1.0), (0.2, 0.7), (0.55, 0.95)])
def test_ends_are_kept_and_steps_are_even(part):
    recordings = curves()
    route = Route.fit(recordings)
    assert route is not None
    first, last = (round(p * 59) for p in part)
    start, goal = recordings[2][first], recordings[3][last]
    found = led_path(route, start, goal, 30)
    np.testing.assert_allclose(found.states[[0, -1]], [start, goal], atol=1e-12)
    steps = np.linalg.norm(np.diff(found.states, axis=0), axis=1)
    assert steps.max() < 1.01 * steps.min()


def test_turned_and_scaled_recordings_give_the_turned_and_scaled_path():
    recordings = strokes()
    turn = 3.0 * np.linalg.qr(np.random.default_rng(1).normal(size=(2, 2)))[0]
    plain, turned = Route.fit(recordings), Route.fit([r @ turn + 7.0 for r in recordings])
    assert plain is not None
    assert turned is not None
    start, goal = recordings[1][5], recordings[2][-1]
    one = led_path(plain, start, goal, 25)
    other = led_path(turned, start @ turn + 7.0, goal @ turn + 7.0, 25)
    np.testing.assert_allclose(one.states @ turn + 7.0, other.states, atol=1e-6)
    assert other.spread == pytest.approx(3.0 * one.spread, rel=1e-5)


def test_recordings_of_one_and_the_same_curve_need_no_lead():
    t = [np.linspace(0.0, 1.0, 60) + 0.003 * i for i in range(4)]
    skill = fit([np.column_stack([np.cos(3 * s), np.sin(3 * s)]) for s in t], 1, 6)
    assert not is_led(skill.model, skill.route)
    plan = skill.plan([1.0, 0.0], [np.cos(2), np.sin(2)], route="geodesic")
    assert "led" not in plan.reason
    assert plan.residual < 1e-3


def test_samples_without_order_are_never_led(sphere, cylinder):
    for skill in (sphere, cylinder):
        assert not is_led(skill.model, skill.route)
