"""Plans under any constraint on the tool's pose: of the library's own, and of a user's."""

from dataclasses import dataclass
from itertools import pairwise
from time import sleep

import numpy as np
import pytest

from keyframes.asked import arm, gaussian
from skillfold import Box, Robot
from skillfold.errors import InputError
from skillfold.keyframes.hand_written import AxisUpright, PlaneConstraint, TaskSpaceRegion
from skillfold.keyframes.planning import plan_constrained

SCENE = [Box(pose=(0.32, -0.05, 0.2), size=(0.05, 0.25, 0.4), name="post")]


@dataclass
class Above:
    """A user's own: the tool is no lower than that. Nothing but what the protocol asks for."""

    height: float
    wrong: bool = False

    def distance(self, poses):
        if self.wrong:
            raise RuntimeError("mine")
        return np.maximum(self.height - np.asarray(poses)[..., 2], 0.0)

    def project(self, poses):
        poses = np.array(poses)
        poses[..., 2] = np.maximum(poses[..., 2], self.height)
        return poses


@pytest.fixture(scope="module")
def robot():
    return arm()


def fine(path):
    states = path.states
    shares = np.arange(5)[:, None] / 5
    return np.vstack([a + shares * (b - a) for a, b in pairwise(states)] + [states[-1:]])


@pytest.mark.parametrize("tolerance", [0.3, 0.1])
def test_axis_upright(robot, tolerance):
    """The tool's axis that points up at the start does so all along."""
    start = robot.home
    pose = robot.forward(start)
    w, x, y, z = pose[3:]
    up = np.array([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])  # of the world, in the tool
    constraint = AxisUpright(up, tolerance=tolerance)
    goal = robot.forward(start + np.array([0.7, 0.0, 0.0, 0.0, 0.0, 0.0]))  # turned about the vertical
    plan = plan_constrained(robot, constraint, start, goal, time_limit=20.0)
    assert plan.success and plan.route == "constrained", plan.reason
    assert constraint.distance(robot.forward(fine(plan.path))).max() <= 1e-6
    assert np.linalg.norm(robot.forward(plan.path.states[-1])[:3] - goal[:3]) <= 0.005


def test_joint_positions_as_goal(robot):
    start = robot.home
    goal = start + np.array([0.9, 0.1, 0.1, 0.3, 0.2, -0.2])
    low = float(min(robot.forward(start)[2], robot.forward(goal)[2])) - 0.05
    plan = plan_constrained(robot, Above(low), start, goal, SCENE, time_limit=30.0)
    assert plan.success, plan.reason
    np.testing.assert_allclose(robot.wrap(plan.path.states[-1]), robot.wrap(goal), atol=1e-9)
    states = fine(plan.path)
    assert robot.obstacles(SCENE).clearance(states).min() > 0.0
    assert Above(low).distance(robot.forward(states)).max() <= 0.005


def test_a_constraint_as_goal(robot):
    start = robot.home
    pose = robot.forward(start + np.array([0.4, 0.0, 0.0, 0.0, 0.0, 0.0]))
    goal = gaussian(pose, 0.01, 0.1)
    hold = gaussian(robot.forward(start + np.array([0.2, 0.0, 0.0, 0.0, 0.0, 0.0])), 0.05, 0.3)
    plan = plan_constrained(robot, hold, start, goal, time_limit=20.0)
    assert plan.success, plan.reason
    assert goal.contains(robot.forward(plan.path.states[-1]))
    assert hold.contains(robot.forward(fine(plan.path)), 1e-6).all()


def test_a_plane(robot):
    start = robot.home
    pose = robot.forward(start)
    plane = PlaneConstraint(point=pose[:3], normal=(0.0, 0.0, 1.0), tolerance=0.01)
    goal = robot.forward(start + np.array([-0.6, 0.0, 0.0, 0.0, 0.0, 0.0]))
    plan = plan_constrained(robot, plane, start, goal, time_limit=20.0)
    assert plan.success, plan.reason
    assert np.abs(robot.forward(fine(plan.path))[:, 2] - pose[2]).max() <= 0.01 + 1e-6


@pytest.mark.parametrize("seed", range(4))
def test_a_goal_of_which_little_holds_the_constraint(robot, seed):
    """Of a box of poses those in a plane; of the poses near one beside the plane, those in it."""
    start, shift = robot.home, np.random.default_rng(seed).uniform(-0.06, 0.06, 2)
    pose = robot.forward(start) + np.array([*shift, 0.0, 0.0, 0.0, 0.0, 0.0])
    plane = PlaneConstraint(pose[:3], tolerance=1e-3)
    box = TaskSpaceRegion(pose, [-0.03] * 3 + [-0.2] * 3, [0.03] * 3 + [0.2] * 3)
    beside = pose + np.array([0.0, 0.0, 0.004, 0.0, 0.0, 0.0, 0.0])
    for goal in (box, beside):
        plan = plan_constrained(robot, plane, start, goal, time_limit=20.0, seed=seed)
        assert plan.success, plan.reason
        poses = robot.forward(plan.path.states)
        assert plane.distance(poses).max() <= 2e-6
        end = poses[-1]
        assert box.distance(end) <= 1e-6 if goal is box else np.linalg.norm(end[:3] - beside[:3]) <= 0.005


def test_a_goal_beside_the_constraint_is_told(robot):
    pose = robot.forward(robot.home)
    above = pose + np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
    box = TaskSpaceRegion(above, [-0.03] * 3 + [-0.2] * 3, [0.03] * 3 + [0.2] * 3)
    plan = plan_constrained(robot, PlaneConstraint(pose[:3]), robot.home, box, time_limit=20.0)
    assert not plan.success and "goal lies" in plan.reason


def test_what_cannot_be(robot):
    start = robot.home
    goal = robot.forward(start + np.array([0.4, 0.0, 0.0, 0.0, 0.0, 0.0]))
    high = plan_constrained(robot, Above(2.0), start, goal, time_limit=100.0)
    assert not high.success and "start lies" in high.reason
    below = goal - np.array([0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0])
    off = plan_constrained(robot, Above(0.3), start, below, time_limit=100.0)
    assert not off.success and "goal lies" in off.reason
    far = plan_constrained(robot, Above(0.0), start, [3.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0], time_limit=100.0)
    assert not far.success and "out of reach" in far.reason


def test_a_users_error_is_the_users(robot):
    start = robot.home
    with pytest.raises(RuntimeError, match="mine"):
        plan_constrained(robot, Above(0.0, wrong=True), start, start)


@pytest.mark.parametrize("seed", range(3))
def test_a_goal_is_found_where_nothing_is_outside(robot, seed):
    """All its postures are far from those near it in the workspace."""
    plan = plan_constrained(robot, Above(-5.0), robot.home, far_posture(robot), seed=seed, time_limit=30.0)
    assert plan.success, plan.reason


class Late(Above):
    """Right for a while; then it is slow, or wrong."""

    RIGHT = 150
    calls = 0

    def distance(self, poses):
        self.calls += 1
        if self.calls > self.RIGHT:
            self.late()
        return super().distance(poses)

    def late(self):
        raise RuntimeError("mine, later")


class Slow(Late):
    SLEEP = 0.02

    def late(self):
        sleep(self.SLEEP)


def far_posture(robot):
    """A pose that is reached on ways round only."""
    goal = robot.forward(robot.home)
    return goal + np.array([-0.15, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_a_users_error_ends_the_search_at_once(robot):
    late = Late(0.3)
    with pytest.raises(RuntimeError, match="mine, later"):
        plan_constrained(robot, late, robot.home, far_posture(robot), time_limit=600.0)
    assert late.calls == Late.RIGHT + 1


def test_a_slow_constraint_takes_no_more_than_the_time_given(robot):
    """A batch of targets alone asks it some thousand times."""
    slow = Slow(0.3)
    plan = plan_constrained(robot, slow, robot.home, far_posture(robot), time_limit=0.5)
    assert slow.calls < Slow.RIGHT + 0.5 / Slow.SLEEP + 5
    assert plan.success or "No way" in plan.reason


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("distance", 0.0),
        ("distance", None),
        ("distance", np.array([[0.0]])),
        ("project", None),
        ("project", np.zeros((1, 3))),
        ("project", np.full((32, 7), np.nan)),
        ("sample", np.zeros((3, 7))),
        ("sample", "some"),
    ],
)
def test_wrong_answers_of_a_user_are_told(robot, name, answer):
    constraint = Above(0.3)
    setattr(constraint, name, lambda *given: answer)
    with pytest.raises(InputError, match="constraint: "):
        plan_constrained(robot, constraint, robot.home, far_posture(robot), time_limit=5.0)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"goal": [0.0] * 5}, "goal"),
        ({"goal": "there"}, "goal"),
        ({"goal": Above(0.1)}, "sample"),
        ({"goal_is": "pos"}, "goal_is"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"tolerance": "wide"}, "tolerance"),
        ({"constraint": 3}, "distance"),
        ({"constraint": Above}, "constraint"),
        ({"constraint": type("Odd", (Above,), {"compiled": None})(0.0)}, "compiled"),
        ({"q_start": None}, "joint positions"),
        ({"stop": "never"}, "stop"),
    ],
)
def test_bad_input(robot, asked, words):
    given = {"constraint": Above(0.0), "q_start": robot.home, "goal": robot.forward(robot.home)} | asked
    with pytest.raises(InputError, match=words):
        plan_constrained(robot, **given)


def test_seven_numbers_are_no_guess():
    robot = Robot.load("lwr4")
    with pytest.raises(InputError, match="goal_is"):
        plan_constrained(robot, Above(-2.0), robot.home, robot.home)
    plan = plan_constrained(robot, Above(-2.0), robot.home, robot.home, goal_is="joints", time_limit=10.0)
    assert plan.success and plan.length == pytest.approx(0.0, abs=1e-9)
