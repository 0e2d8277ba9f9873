"""Joint positions that reach a pose: they do, they are clear, and they differ."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skillfold as sf
from skillfold.errors import InputError
from skillfold.robots.reaching import reach


@settings(max_examples=25, deadline=None)
@given(name=st.sampled_from(["jaco", "lwr4"]), seed=st.integers(0, 10_000))
def test_poses_of_the_robot_are_reached(robots, name, seed):
    robot = robots[name]
    q = robot.sample(1, seed)[0]
    if robot.self_clearance(q) < 0.02:
        return
    pose = robot.forward(q)
    found = reach(robot, pose, seed=seed)
    assert len(found)
    reached = robot.forward(found)
    assert np.abs(reached[:, :3] - pose[:3]).max() < 1e-5
    assert (np.abs(reached[:, 3:] @ pose[3:]) > 1 - 1e-9).all()
    assert (robot.self_clearance(found) > 0).all() and robot.space.contains(found).all()
    assert np.array_equal(found, reach(robot, pose, seed=seed))


def test_the_jaco_reaches_a_pose_in_several_postures_the_one_with_most_room_first(robots):
    robot = robots["jaco"]
    ball = robot.obstacles([sf.Sphere((0.2, -0.4, 0.5), 0.05)])
    found = reach(robot, [0.4, -0.2, 0.2, 0.0, 1.0, 0.0, 0.0], ball)
    room = ball.clearance(found)
    assert len(found) >= 4 and (np.diff(room) <= 0).all()


def test_what_stands_at_the_pose_leaves_no_answer(robots):
    robot = robots["jaco"]
    wall = robot.obstacles([sf.Sphere((0.4, -0.2, 0.2), 0.05)])
    assert reach(robot, [0.4, -0.2, 0.2, 0.0, 1.0, 0.0, 0.0], wall).shape == (0, 6)


def test_out_of_reach_there_is_none(robots):
    assert reach(robots["jaco"], [5.0, 0.0, 0.0]).shape == (0, 6)


@pytest.mark.parametrize("pose", [np.zeros((2, 7)), [0.0, 0.0], None, [0, 0, 0, 2, 0, 0, 0], [np.nan] * 7, "here"])
def test_what_is_no_pose_is_told(robots, pose):
    with pytest.raises(InputError, match="pose of the tool"):
        reach(robots["jaco"], pose)
