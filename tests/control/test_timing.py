"""Paths in time: limits, smoothness, ends."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from skillfold.control.timing import follow, time_path
from skillfold.errors import InputError
from skillfold.motion import Path, Trajectory

VELOCITY, ACCELERATION = np.array([2.0, 1.0, 3.0]), np.array([8.0, 5.0, 12.0])


def sampled(reference, count=3000):
    times = np.linspace(0.0, reference.duration, count)
    return times, np.array([reference.at(time) for time in times])


def largest_change(values):
    return np.abs(np.diff(values, axis=0)).max()


def curved(seed, n=40):
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, n)[:, None]
    return (
        rng.normal(size=3) * t + 0.5 * rng.normal(size=3) * np.sin(4 * t) + 0.2 * rng.normal(size=3) * np.cos(7 * t)
    )


@given(seed=st.integers(0, 10_000), speed=st.sampled_from([0.0, 0.3, 5.0]))
@example(seed=439, speed=5.0)
@example(seed=1004, speed=0.3)
@settings(max_examples=40, deadline=None)
def test_limits_are_kept_and_ends_are_met(seed, speed):
    path = curved(seed)
    reference = time_path(path, VELOCITY, ACCELERATION, speed=speed)
    times, motion = sampled(reference)
    assert (np.abs(motion[:, 1]) <= VELOCITY).all()
    assert (np.abs(motion[:, 2]) <= ACCELERATION).all()
    assert np.allclose(motion[0, 0], path[0]) and np.allclose(motion[-1, 0], path[-1])
    assert np.abs(motion[-1, 1:]).max() < 1e-9
    if not speed:
        assert np.abs(motion[0, 2]).max() < 0.05
    # Velocities are what positions say, and accelerations do not jump: seen four times as often, they change by less.
    assert np.abs(np.gradient(motion[:, 0], times, axis=0) - motion[:, 1])[1:-1].max() < 1e-3
    _, closer = sampled(reference, 4 * len(times))
    assert largest_change(closer[:, 2]) < 0.5 * largest_change(motion[:, 2])


def test_a_straight_path_takes_little_more_than_it_must():
    reference = time_path(np.linspace([0.0], [4.0], 9), [1.0], [4.0], margin=1.0)
    assert 4.0 + 0.25 < reference.duration < 4.0 + 0.25 + 0.3


def test_a_path_stays_on_its_spline():
    path = curved(3, 80)
    reference = time_path(path, VELOCITY, ACCELERATION)
    _, motion = sampled(reference)
    dense = curved(3, 8000)
    away = np.linalg.norm(motion[::50, 0][:, None] - dense[None], axis=2).min(1)
    assert away.max() < 2e-3


def test_a_longer_duration_is_kept_and_a_shorter_one_refused():
    path = curved(1)
    shortest = time_path(path, VELOCITY, ACCELERATION)
    longer = time_path(path, VELOCITY, ACCELERATION, duration=2 * shortest.duration)
    assert longer.duration == pytest.approx(2 * shortest.duration) and longer.pace == pytest.approx(0.5)
    with pytest.raises(InputError, match=r"duration 0.1 s; the limits .* need"):
        time_path(path, VELOCITY, ACCELERATION, duration=0.1)


@pytest.mark.parametrize("size", [1e6, 1e50])
def test_motions_that_would_take_hours_are_a_slip_of_units(size):
    with pytest.raises(InputError, match="Are the units right"):
        time_path(size * curved(1), VELOCITY, ACCELERATION)
    with pytest.raises(InputError, match="10000 at most"):
        time_path(curved(1), VELOCITY, ACCELERATION, duration=size)


@pytest.mark.parametrize("states", [[[1.0, 2.0]], [[1.0, 2.0]] * 5])
def test_a_path_without_length_rests(states):
    reference = time_path(np.array(states))
    assert reference.duration == 0.0
    assert np.array_equal(reference.at(0.3), [[1.0, 2.0], [0.0, 0.0], [0.0, 0.0]])


@pytest.mark.parametrize("count", [2, 3, 4])
def test_few_states_are_enough(count):
    reference = time_path(np.linspace([0.0, 1.0], [1.0, 1.0], count), duration=3.0)
    assert np.allclose(reference.at(1.5)[0], [0.5, 1.0], atol=0.01)
    assert np.allclose(reference.at(99.0)[0], [1.0, 1.0])


def test_states_that_repeat_do_no_harm():
    path = np.repeat(curved(2), 3, axis=0)
    assert time_path(path, VELOCITY, ACCELERATION).duration == pytest.approx(
        time_path(curved(2), VELOCITY, ACCELERATION).duration, rel=1e-6
    )


def test_the_first_velocity_is_as_asked_where_limits_allow():
    path = np.linspace([0.0], [2.0], 9)
    assert time_path(path, [1.0], [4.0], speed=0.5).at(0.0)[1, 0] == pytest.approx(0.5, rel=0.02)
    assert time_path(path, [1.0], [4.0], speed=9.0).at(0.0)[1, 0] <= 1.0


def test_a_trajectory_there_and_back():
    trajectory = time_path(Path(curved(5), ("a", "b", "c")), VELOCITY, ACCELERATION).trajectory()
    assert trajectory.names == ("a", "b", "c")
    again = follow(trajectory)
    for time, state in zip(trajectory.times[::7], trajectory.states[::7], strict=True):
        assert np.allclose(again.at(time)[0], state, atol=1e-5)
    with pytest.raises(InputError, match="six or more"):
        follow(Trajectory(np.arange(3.0), np.zeros((3, 1))))
    for times in (1e300 * np.arange(9.0), 1e-9 * np.arange(9.0)):
        with pytest.raises(InputError, match=r"expected 0\.001 to 10000 s"):
            follow(Trajectory(times, np.zeros((9, 1))))


@pytest.mark.parametrize(
    "arguments",
    [
        {"path": np.zeros((0, 2))},
        {"path": np.array([[np.nan, 0.0]])},
        {"path": np.zeros(3)},
        {"path": np.eye(2), "velocity": [1.0]},
        {"path": np.eye(2), "acceleration": [1.0, -1.0]},
        {"path": np.eye(2), "duration": np.nan},
        {"path": np.eye(2), "duration": -1.0},
        {"path": np.eye(2), "duration": 1e9},
        {"path": "there"},
        {"path": [[1.0], [1.0, 2.0]]},
        {"path": np.eye(2), "velocity": "fast"},
        {"path": np.eye(2), "velocity": [1e-9, 1e-9]},
        {"path": 1e7 * np.eye(2)},
        {"path": np.eye(2), "speed": np.nan},
        {"path": np.eye(2), "margin": 0.0},
    ],
)
def test_what_cannot_be_timed_is_told(arguments):
    with pytest.raises(InputError):
        time_path(**arguments)
