"""The check of a path: each condition alone, its worst place and value, and that it asks nothing else."""

import numpy as np
import pytest

from skillfold.check import JUMP, MOST, OUTSIDE, SAG, check_path
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


# Obstacles


class Ball:
    """A ball of radius 0.1 at a place; knows what a check may ask, and counts the states it is asked about."""

    margin = 0.05

    def __init__(self, centre, resolution=0.01, lower=-np.inf, upper=np.inf):
        self.centre, self.resolution, self.looked = np.array(centre), resolution, 0
        self.bounds = np.full(3, lower), np.full(3, upper)

    def clearance(self, q, /):
        self.looked += len(q)
        return np.linalg.norm(q - self.centre, axis=1) - 0.1

    def nearest(self, q, /):
        assert q.shape == (3,)
        return "the ball"

    def compiled(self):
        raise AssertionError("a check is independent of compiled loops")


def checked(path, ball, tolerance=0.01, space=FLAT, **options):
    return check_path(path, Plane(), tolerance, space, obstacles=ball, **options)


def test_without_obstacles_clearance_is_endless():
    check = check_path(line(), Plane(), 0.01, FLAT)
    assert (check.clearance, check.clearance_at) == (np.inf, 0.0)


def test_the_least_clearance_and_its_place_are_told():
    check = checked(line(), Ball([0.43, 0.15, 0.0]))
    assert check.ok, check.reason
    assert check.clearance == pytest.approx(0.05, abs=1e-6)
    assert check.clearance_at == pytest.approx(4.3)


def test_a_path_is_looked_at_between_its_states():
    """Of two states the ball is as far from as can be."""
    path = line(2)
    check = checked(path, Ball([0.5, 0.0, 0.0]))
    assert not check.ok
    assert check.clearance == pytest.approx(-0.1)
    assert check.clearance_at == pytest.approx(0.5)
    assert check.reason == "State 0.5 is not clear: the ball, -0.1."
    assert check_path(path, Plane(), 0.01, FLAT).ok


@pytest.mark.parametrize("steps", [1, 3, 10, 1000])
def test_places_lie_no_farther_apart_than_the_resolution(steps):
    ball = Ball([0.0, 1.0, 0.0], resolution=1 / steps)
    checked(line(2), ball)
    assert ball.looked == steps + 1
    uneven = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [1.0, 0.0, 0.0]])
    ball = Ball([0.0, 1.0, 0.0], resolution=0.05)
    checked(uneven, ball)
    assert ball.looked == 2 + 18 + 1


def test_places_count_states_where_these_are_uneven():
    """Half-way between states 1 and 2 is place 1.5, wherever that is."""
    uneven = np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [1.0, 0.0, 0.0], [1.1, 0.0, 0.0]])
    check = checked(uneven, Ball([0.6, 0.0, 0.0], resolution=0.05), still=1.0)
    assert check.clearance_at == pytest.approx(1.5)


def test_a_tiny_resolution_is_looked_at_less_closely():
    ball = Ball([0.0, 1.0, 0.0], resolution=1e-12)
    assert checked(line(), ball).ok
    assert MOST <= ball.looked <= MOST + 11


def test_a_path_that_does_not_move_is_looked_at_where_it_is():
    ball = Ball([0.0, 0.05, 0.0])
    check = checked(np.zeros((5, 3)), ball)
    assert ball.looked == 5
    assert (check.clearance, check.clearance_at) == (pytest.approx(-0.05), 0.0)
    assert not check.ok


def test_touching_is_not_clear():
    check = checked(np.zeros((3, 3)), Ball([0.1, 0.0, 0.0]))
    assert not check.ok
    assert check.clearance == 0.0


class Bowl:
    """The paraboloid z = (x² + y²) / 2, its distance told as height."""

    def judge(self, states, /):
        return np.abs(states[:, 2] - (states[:, :2] ** 2).sum(1) / 2), np.zeros(len(states))


FAR = [9.0, 9.0, 9.0]


def over_the_bowl(n):
    x = np.linspace(-1, 1, n)
    return np.column_stack([x, 0 * x, x**2 / 2])


@pytest.mark.parametrize("n", [5, 20])
def test_chords_may_sag_as_much_as_the_path_bends(n):
    """A parabola's chords lie an eighth of the second difference off it: all of that is allowed, and no more."""
    path, tolerance = over_the_bowl(n), 1e-6
    sag = SAG * (2.0 / (n - 1)) ** 2
    check = check_path(path, Bowl(), tolerance, FLAT, obstacles=Ball(FAR, resolution=1e-3))
    assert check.ok, check.reason
    assert 10 * tolerance < check.residual < 1.01 * sag
    path[n // 2, 2] += 2 * tolerance  # at states themselves nothing is allowed for
    check = check_path(path, Bowl(), tolerance, FLAT, obstacles=Ball(FAR, resolution=1e-3))
    assert not check.ok
    assert check.reason.startswith(f"State {n // 2} lies")


@pytest.mark.parametrize("n", [5, 9, 50])
def test_chords_may_sag_more_where_the_path_bends_ever_more(n):
    """A path that bends most at its end: the bend at the states tells too little."""
    x = np.linspace(0.0, 1.0, n)
    path = np.column_stack([x, 0.0 * x, x**4])

    class Gully(Plane):
        def judge(self, states, /):
            return np.abs(states[:, 2] - states[:, 0] ** 4), super().judge(states)[1]

    check = check_path(path, Gully(), 1e-9, FLAT, still=1.0, obstacles=Ball(FAR, resolution=1e-3))
    assert check.ok, check.reason


def test_chords_that_leave_the_surface_where_the_path_is_straight_fail():
    """States on the surface, with a ridge between two of them."""

    class Ridge(Plane):
        def judge(self, states, /):
            ridge = np.maximum(0.0, 0.05 - np.abs(states[:, 0] - 0.25))
            return np.abs(states[:, 2] - ridge), super().judge(states)[1]

    check = check_path(line(6), Ridge(), 0.01, FLAT, obstacles=Ball(FAR, resolution=0.005))
    assert not check.ok
    assert check.residual == pytest.approx(0.05)
    assert check.residual_at == pytest.approx(1.25)
    assert check_path(line(6), Ridge(), 0.01, FLAT).ok


def test_the_worst_place_is_where_the_tolerance_is_exceeded_most():
    """Not where a chord sags most."""
    path = over_the_bowl(9)
    path[4, 2] += 0.005
    check = check_path(path, Bowl(), 0.001, FLAT, obstacles=Ball(FAR, resolution=1e-3))
    assert not check.ok
    assert check.residual_at == 4.0
    assert check.residual == pytest.approx(0.005)


def test_two_states_have_no_bend_to_allow_for():
    path = np.array([[-0.1, 0.0, 0.005], [0.1, 0.0, 0.005]])
    check = check_path(path, Bowl(), 1e-3, FLAT, obstacles=Ball(FAR))
    assert not check.ok
    assert check.residual == pytest.approx(0.005)
    assert check.residual_at == pytest.approx(0.5)


@pytest.mark.parametrize(("lower", "upper", "at"), [(-np.inf, 0.655, 7), (0.145, np.inf, 0), (-np.inf, np.inf, None)])
def test_limits_come_from_the_obstacles_too(lower, upper, at):
    ball = Ball(FAR, resolution=0.02)
    ball.bounds = np.array([lower, -1.0, -1.0]), np.array([upper, 1.0, 1.0])
    check = checked(line(), ball)
    assert check.ok == (at is None)
    assert check_path(line(), Plane(), 0.01, FLAT).ok
    if at == 7:  # the first that was looked at beyond 0.655 on the way from 0.6 to 0.7
        assert check.reason == "State 6.6 breaks the limits of its coordinates."
    elif at == 0:
        assert check.reason == "State 0 breaks the limits of its coordinates."


def test_at_a_limit_to_rounding_is_within():
    ball = Ball(FAR, upper=1.0 - 1e-12)
    assert checked(line(), ball).ok


def test_limits_of_the_space_hold_between_states():
    """Of a bounded coordinate whose states are within."""
    path = np.array([[0.0, 0.0, 0.0], [0.5, 0.5 + 5e-7, 0.0], [1.0, 0.0, 0.0]])
    space = StateSpace.linear(3, -1, [1, 0.5, 1])
    assert checked(path, Ball(FAR), space=space).ok
    path[1, 1] = 0.6
    assert checked(path, Ball(FAR), space=space).reason == "State 0.8354 breaks the limits of its coordinates."


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_broken_path_has_no_clearance(value):
    path = line()
    path[4, 1] = value
    check = checked(path, Ball(FAR))
    assert not check.ok
    assert check.clearance == -np.inf
    assert "not finite" in check.reason


def test_a_clearance_that_is_no_number_is_no_clearance():
    class Broken(Ball):
        def clearance(self, q, /):
            return np.where(q[:, 0] > 0.5, np.nan, 1.0)

    check = checked(line(), Broken(FAR))
    assert not check.ok
    assert "is not clear" in check.reason
