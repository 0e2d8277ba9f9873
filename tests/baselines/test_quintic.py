"""Laws of the quintic: it meets its ends, its derivatives are derivatives, it is the smoothest."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from skillfold.baselines.quintic import Quintic, rest_to_rest, timed
from skillfold.errors import InputError

ENDS = arrays(np.float64, (6, 3), elements=st.floats(-10, 10))
DURATIONS = st.floats(0.05, 20)


def made(ends, duration):
    return Quintic.between(
        ends[0], ends[1], duration, velocities=(ends[2], ends[3]), accelerations=(ends[4], ends[5])
    )


@given(ENDS, DURATIONS)
def test_ends_are_met(ends, duration):
    motion = made(ends, duration)
    size = 1 + np.abs(ends).max() * (1 + duration) ** 2 / min(duration, 1) ** 2
    for found, wanted in [
        (motion.position, ends[0:2]),
        (motion.velocity, ends[2:4]),
        (motion.acceleration, ends[4:6]),
    ]:
        np.testing.assert_allclose(found([0.0, duration]), wanted, atol=1e-12 * size)


@given(ENDS, st.floats(0.5, 5))
def test_derivatives_are_derivatives(ends, duration):
    motion = made(ends, duration)
    inner = np.linspace(0.1, 0.9, 7) * duration
    step = 1e-5 * duration
    for value, slope in [(motion.position, motion.velocity), (motion.velocity, motion.acceleration)]:
        numeric = (value(inner + step) - value(inner - step)) / (2 * step)
        np.testing.assert_allclose(slope(inner), numeric, atol=1e-4 * (1 + np.abs(numeric).max()))


@given(ENDS, DURATIONS)
def test_backwards_is_the_same_motion_mirrored_in_time(ends, duration):
    there = made(ends, duration)
    back = made(ends[[1, 0, 3, 2, 5, 4]] * np.array([1, 1, -1, -1, 1, 1])[:, None], duration)
    times = np.linspace(0, duration, 9)
    size = 1 + np.abs(there.position(times)).max()
    np.testing.assert_allclose(there.position(times), back.position(duration - times), atol=1e-9 * size)


def test_rest_to_rest_is_craigs():
    shares = np.linspace(0, 1, 11)
    motion = Quintic.between([1.0, 0.0], [3.0, -1.0], 2.0)
    expected = np.array([1.0, 0.0]) + rest_to_rest(shares)[:, None] * np.array([2.0, -1.0])
    np.testing.assert_allclose(motion.position(2 * shares), expected, atol=1e-12)
    assert rest_to_rest(np.array([0, 0.5, 1])) == pytest.approx([0, 0.5, 1])


def test_one_time_and_many():
    motion = Quintic.between(np.zeros(3), np.ones(3))
    assert motion.position(0.5).shape == (3,)
    assert motion.position(np.full((2, 4), 0.5)).shape == (2, 4, 3)
    trajectory = motion.trajectory(21)
    assert (trajectory.states.shape, trajectory.times[-1]) == ((21, 3), 1.0)


def test_a_straight_path_timed_alike_is_the_quintic():
    shares = np.linspace(0, 1, 33)
    ends = np.array([[0.0, 1.0], [2.0, -1.0]])
    path = ends[0] + np.array([0, 0.1, 0.5, 0.6, 1.0])[:, None] * (ends[1] - ends[0])
    np.testing.assert_allclose(timed(path, shares), Quintic.between(*ends).position(shares), atol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0.0], [1.0, 2.0]), "same shape"),
        (([0.0], [np.nan]), "goal"),
        (([[0.0]], [1.0]), "start"),
        (([0.0], [1.0], 0.0), "duration"),
        (([0.0], [1.0], np.inf), "duration"),
    ],
)
def test_what_cannot_be_used_is_told(arguments, message):
    with pytest.raises(InputError, match=message):
        Quintic.between(*arguments)


def test_velocities_and_times_are_checked():
    with pytest.raises(InputError, match="velocity"):
        Quintic.between([0.0, 0.0], [1.0, 1.0], velocities=([1.0, 2.0, 3.0], 0.0))
    with pytest.raises(InputError, match="times"):
        Quintic.between([0.0], [1.0]).position([1.1])
