"""Kernels of references against NumPy, and the laws of splices."""

import numpy as np
import pytest

from control import twins
from skillfold.control.kernels import reference
from skillfold.control.timing import time_path


@pytest.fixture
def rng():
    return np.random.default_rng(0)


@pytest.fixture
def knots(rng):
    return rng.normal(size=(9, 3, 4)) * np.array([1.0, 2.0, 5.0])[:, None]


@pytest.mark.parametrize("time", [-1.0, 0.0, 0.03, 0.1, 0.777, 0.8, 3.0])
def test_evaluate(knots, time):
    out = np.empty((3, 4))
    reference.evaluate(knots, 0.1, time, out)
    assert np.allclose(out, twins.evaluate(knots, 0.1, time), atol=1e-9)


def test_evaluate_meets_the_knots(knots):
    out = np.empty((3, 4))
    for k in range(len(knots)):
        reference.evaluate(knots, 0.1, 0.1 * k, out)
        assert np.allclose(out, knots[k], atol=1e-8)


def test_brake(rng):
    state, out = rng.normal(size=(3, 4)), np.empty((3, 4))
    for time in (0.0, 0.2, 0.5):
        reference.brake(state, 0.5, time, out)
        assert np.allclose(out, twins.brake(state, 0.5, time), atol=1e-9)


def test_excess(rng):
    state, velocity, acceleration = rng.normal(size=(3, 4)), rng.uniform(1, 2, 4), rng.uniform(1, 2, 4)
    assert reference.excess(state, velocity, acceleration) == twins.excess(state, velocity, acceleration)
    assert reference.excess(state, np.full(4, np.inf), np.full(4, np.inf)) == 0.0


def test_overrun(rng):
    knots, limits = rng.normal(size=(6, 3, 4)), (np.full(4, 2.0), np.full(4, 3.0))
    found = reference.overrun(knots, 0.1, *limits, np.empty((3, 4)))
    states = [twins.evaluate(knots, 0.1, 0.0125 * i) for i in range(41)]
    assert found == pytest.approx(max(twins.excess(state, *limits) for state in states), rel=1e-9)


@pytest.mark.parametrize("delay", [0, 3, 9])
def test_mix(knots, rng, delay):
    state, work, out = rng.normal(size=(3, 4)), np.empty((3, 4)), np.empty((3, 4))
    for k in range(6):
        reference.mix(knots, 0.1, state, 0.55, delay, k, work, out)
        assert np.allclose(out, twins.mix(knots, 0.1, state, 0.55, delay, k), atol=1e-8)


def test_worst(knots, rng):
    state, limits = rng.normal(size=(3, 4)), (rng.uniform(1, 2, 4), rng.uniform(1, 2, 4))
    mixed = [twins.mix(knots, 0.1, state, 0.55, 2, k) for k in range(1, 6)]
    wanted = max(twins.excess(knot, *limits) for knot in mixed)
    found = reference.worst(knots, 0.1, state, 0.55, 2, *limits, np.empty((2, 3, 4)))
    assert found == pytest.approx(wanted)


@pytest.mark.parametrize("speed", [0.0, 0.5])
@pytest.mark.parametrize("seed", range(6))
def test_splice(seed, speed):
    """Begins at the state to the second derivative, keeps the limits, and ends on the reference."""
    rng = np.random.default_rng(seed)
    path = np.cumsum(rng.normal(size=(6, 3)), axis=0)
    limits = np.full(3, 2.0), np.full(3, 8.0)
    made = time_path(path, *limits, speed=speed)
    near = 0.2 if speed == 0.0 else 0.01
    start = made.at(0.0) if speed else np.stack([path[0], rng.uniform(-1, 1, 3), rng.uniform(-4, 4, 3)])
    state = start + near * rng.normal(size=3) * [[1], [0], [0]]
    knots, spare = made.knots.copy(), len(made.knots) - 1 - round(made.duration / made.step)
    taken, delay = reference.splice(knots, made.step, state, 0.15, spare, *limits, np.zeros((2, 3, 3)))
    assert np.allclose(knots[0], state)
    after = int(np.ceil(taken / made.step))
    assert np.array_equal(knots[after:], made.knots[after - delay : len(knots) - delay])
    assert np.array_equal(knots[-1], made.knots[-1])
    assert max(reference.excess(knot, *limits) for knot in knots) <= (1.05 if speed else 1.0)
    for k in range(after):
        assert np.allclose(knots[k], twins.mix(made.knots, made.step, state, taken, delay, k), atol=1e-8)


def test_a_splice_that_cannot_keep_the_limits_ends_all_the_same():
    made = time_path(np.linspace([0.0], [1.0], 5), [1.0], [4.0])
    state = np.array([[0.0], [3.0], [0.0]])
    taken, delay = reference.splice(
        made.knots, made.step, state, 0.15, 90, np.ones(1), np.ones(1), np.zeros((2, 3, 1))
    )
    assert 0.15 <= taken <= len(made.knots) * made.step and delay <= 90
    assert np.allclose(made.knots[0], state)
