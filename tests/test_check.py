"""The check of a path: each condition alone, its worst place and value, and that it asks nothing else."""

import numpy as np
import pytest

from skillfold.check import JUMP, OUTSIDE, check_path
from skillfold.spaces import StateSpace


class Plane:
    """The plane z = 0; demonstrated within one unit of the origin. Asks for batches only."""

    def judge(self, states, /):
        assert states.ndim == 2
        return np.abs(states[:, 2]), np.linalg.norm(states, axis=1)


FLAT = StateSpace.linear(3)


def line(n=11):
    return np.column_stack([np.linspace(0, 1, n), np.zeros(n), np.zeros(n)])


def test_a_good_path_passes_with_its_worst_values():
    path = line()
    path[3, 2] = 0.004
    check = check_path(path, Plane(), 0.01, FLAT)
    assert check.ok
    assert check.reason == ""
    assert (check.residual, check.residual_at) == (0.004, 3)
    assert check.outside == pytest.approx(1.0)
    assert check.outside_at == 10
    assert 1.0 <= check.jump < 1.1


def test_a_path_off_the_surface_fails_with_the_state():
    path = line()
    path[7, 2] = -0.02
    check = check_path(path, Plane(), 0.01, FLAT)
    assert not check.ok
    assert (check.residual, check.residual_at) == (0.02, 7)
    assert check.reason == "State 7 lies 0.02 off the manifold, more than 0.01."


def test_exactly_at_the_tolerance_is_on_the_manifold():
    path = line()
    path[:, 2] = 0.01
    assert check_path(path, Plane(), 0.01, FLAT).ok
    assert not check_path(path, Plane(), np.nextafter(0.01, 0), FLAT).ok


def test_a_path_outside_the_demonstrations_fails():
    bow = np.column_stack([np.cos(np.linspace(0, np.pi, 21)), 6 * np.sin(np.linspace(0, np.pi, 21)), np.zeros(21)])
    check = check_path(bow, Plane(), 0.01, FLAT)
    assert not check.ok
    assert check.outside_at == 10
    assert "outside the demonstrations, 6.0 times" in check.reason


def test_a_path_may_lie_as_far_outside_as_its_ends():
    far = line() + np.array([2 * OUTSIDE, 0.0, 0.0])
    check = check_path(far, Plane(), 0.01, FLAT)
    assert check.ok
    assert check.outside == pytest.approx(2 * OUTSIDE + 1)


def test_a_jump_fails_where_it_starts():
    path = line(40)
    path[25:, 0] += 2.0
    check = check_path(path, Plane(), 0.01, FLAT)
    assert not check.ok
    assert check.jump_at == 24
    assert check.jump > JUMP
    assert "jumps after state 24" in check.reason


def test_short_steps_are_no_jumps():
    """A path that stays where it is but for a step from its given end onto the surface."""
    path = np.zeros((20, 3))
    path[0, 2] = 1e-6
    assert not check_path(path, Plane(), 0.01, FLAT).ok
    assert check_path(path, Plane(), 0.01, FLAT, still=1e-5).ok


def test_a_path_that_does_not_move_passes():
    assert check_path(np.zeros((5, 3)), Plane(), 0.01, FLAT).ok


def test_limits_of_coordinates_hold():
    space = StateSpace.linear(3, [-1, -1, -1], [1, 0.5, 1])
    path = line()
    path[:, 1] = np.linspace(0, 0.6, 11)
    check = check_path(path, Plane(), 0.01, space)
    assert not check.ok
    assert check.reason == "State 9 breaks the limits of its coordinates."
    assert check_path(line(), Plane(), 0.01, space).ok


def test_quaternions_must_have_unit_length():
    space = StateSpace.quaternion()

    class Anything:
        def judge(self, states, /):
            return np.zeros(len(states)), np.zeros(len(states))

    angle = np.linspace(0, 1, 9)
    path = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle, 0 * angle])
    assert check_path(path, Anything(), 0.01, space).ok
    path[4] *= 1.01
    assert check_path(path, Anything(), 0.01, space).reason == "State 4 breaks the limits of its coordinates."


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_not_finite_fail(value):
    path = line()
    path[4, 1] = value
    with np.errstate(invalid="ignore"):
        check = check_path(path, Plane(), 0.01, FLAT)
    assert not check.ok
    assert "not finite" in check.reason


def test_a_distance_that_is_no_number_is_no_distance():
    class Broken(Plane):
        def judge(self, states, /):
            return np.where(states[:, 0] > 0.5, np.nan, 0.0), super().judge(states)[1]

    check = check_path(line(), Broken(), 0.01, FLAT)
    assert not check.ok
    assert "off the manifold" in check.reason


def test_the_path_is_left_as_it_is():
    path = line()
    before = path.copy()
    check_path(path, Plane(), 0.01, FLAT)
    np.testing.assert_array_equal(path, before)
