"""A Nao hung from its foot is the whole Nao with its base where the foot puts it."""

import pickle

import numpy as np
import pytest

from skillfold.errors import InputError
from skillfold.robots.robot import Robot
from skillfold.robots.standing import LEGS, SIDES, base_of, standing

FRAMES = ("l_sole", "r_sole", "Torso", "head_top", "l_hand", "RKneePitchLink")


@pytest.fixture(scope="module", params=SIDES)
def robot(request):
    return standing(request.param)


@pytest.fixture(scope="module")
def nao():
    return Robot.load("nao")


@pytest.mark.parametrize("frame", FRAMES)
def test_every_frame_is_where_the_whole_robot_has_it(robot, nao, frame):
    q = robot.sample(20, 1)
    whole = robot.whole(q)
    hung, free = robot.forward(q, frame), nao.forward(whole, frame, base_of(nao, whole, robot.stance))
    np.testing.assert_allclose(hung[:, :3], free[:, :3], atol=1e-12)
    np.testing.assert_allclose(np.abs((hung[:, 3:] * free[:, 3:]).sum(1)), 1.0, atol=1e-12)


def test_mass_and_self_clearance_are_those_of_the_whole_robot(robot, nao):
    q = robot.sample(20, 2)
    whole = robot.whole(q)
    base = base_of(nao, whole, robot.stance)
    np.testing.assert_allclose(robot.center_of_mass(q), nao.center_of_mass(whole, base), atol=1e-12)
    # Arms and head are stiff here: the whole robot knows pairs that this one does not.
    assert (robot.self_clearance(q) >= nao.self_clearance(whole) - 1e-9).all()


def test_the_stance_sole_stays_at_the_origin(robot):
    soles = robot.forward(robot.sample(10, 3), robot.stance)
    np.testing.assert_allclose(soles, np.tile([0, 0, 0, 1.0, 0, 0, 0], (10, 1)), atol=1e-12)


def test_jacobian_by_finite_differences(robot):
    q, step = robot.couple(robot.sample(1, 4)[0]), 1e-6
    for column in range(robot.dof):
        nudge = step * np.eye(robot.dof)[column]
        slope = robot.forward(robot.couple(q + nudge), robot.swing) - robot.forward(
            robot.couple(q - nudge), robot.swing
        )
        np.testing.assert_allclose(robot.jacobian(q, robot.swing)[:3, column], slope[:3] / (2 * step), atol=1e-8)


def test_both_hips_turn_by_one_motor(robot):
    assert robot.couplings == {"RHipYawPitch": "LHipYawPitch"}
    assert sorted(robot.names) == sorted(LEGS)


def test_limits_and_home_are_those_of_the_whole_robot(robot, nao):
    for own, whole in zip((*robot.limits, robot.home), (*nao.limits, nao.home), strict=True):
        np.testing.assert_array_equal(own, robot.legs(whole))


def test_pickled_it_is_the_same(robot):
    again = pickle.loads(pickle.dumps(robot))
    assert (again.side, again.names) == (robot.side, robot.names)


def test_the_base_stands_where_the_ground_is(robot, nao):
    whole, ground = robot.whole(robot.sample(3, 5)), np.array([0.3, -0.2, 0.0])
    soles = nao.forward(whole, robot.stance, base_of(nao, whole, robot.stance, ground))
    np.testing.assert_allclose(soles[:, :3], np.tile(ground, (3, 1)), atol=1e-12)


def test_there_are_two_feet():
    with pytest.raises(InputError, match="possible: left, right"):
        standing("both")
