"""Plans anew after obstacles moved."""

from itertools import pairwise

import numpy as np
import pytest

from keyframes.asked import arm, gaussian
from skillfold import Box, Robot
from skillfold.errors import InputError
from skillfold.keyframes import replanning
from skillfold.keyframes.skill import KeyframeSkill

BALL = Box(pose=(0.0, 0.0, 3.0), size=(0.06, 0.06, 0.06), name="box")


@pytest.fixture(scope="module")
def robot():
    return arm()


@pytest.fixture(scope="module")
def skill(robot):
    """From the home pose a quarter turn about the vertical, by way of one between."""
    places = [robot.forward(robot.home + angle * np.eye(6)[0]) for angle in (0.0, 0.5, 1.0)]
    gaussians = tuple(gaussian(pose, 0.03, 0.15) for pose in places)
    return KeyframeSkill(gaussians, (), (), ())


@pytest.fixture(scope="module")
def obstacles(robot):
    return robot.obstacles([BALL], movable=["box"])


@pytest.fixture(scope="module")
def plan(robot, skill, obstacles):
    plan = skill.plan(robot, robot.home, obstacles, time_limit=20.0)
    assert plan.success, plan.reason
    return plan


def test_what_is_clear_is_kept(robot, skill, obstacles, plan):
    half = len(plan.path) // 2
    for at in (0, 3, half, len(plan.path) - 1):
        again = skill.replan(plan, robot, obstacles, plan.path.states[at])
        assert again.success and again.stats["kept"]
        np.testing.assert_allclose(again.path.states, plan.path.states[at:], atol=1e-9)
        rows = again.stats["pairs"]
        assert rows[0]["from"] == 0 and rows[-1]["pair"] == 1
        assert all(0 <= row["from"] < len(again.path) for row in rows)
    assert skill.replan(plan, robot, obstacles).stats["kept"]


def test_what_is_blocked_is_planned_afresh(robot, skill, obstacles, plan):
    """A box on the second half, from a third of the way on: around it, and inside."""
    third = len(plan.path) // 3
    here = plan.path.states[third]
    hand = robot.forward(plan.path.states[2 * third])[:3]
    for shift in (0.0, 0.05, -0.05):
        moved = obstacles.move("box", hand + np.array([0.0, 0.0, shift]))
        if not moved.clearance(here) > 0.0:
            continue
        again = skill.replan(plan, robot, moved, here, time_limit=5.0)
        assert not again.stats["kept"]
        np.testing.assert_array_equal(again.path.states[0], here)
        if again.success:
            assert moved.clearance(again.path.states).min() > 0.0
        else:
            assert again.reason


def test_a_thin_obstacle_between_states_is_seen(robot, skill, obstacles, plan):
    """Edges are followed, not sampled."""
    thin = Box(
        pose=(*robot.forward(plan.path.states[len(plan.path) // 2])[:3], 1.0, 0.0, 0.0, 0.0), size=(0.001,) * 3
    )
    assert not skill.replan(plan, robot, [thin]).stats["kept"]


def test_off_the_path_is_planned_afresh(robot, skill, obstacles, plan):
    here = plan.path.states[5] + 0.03 * np.eye(6)[4]
    again = skill.replan(plan, robot, obstacles, here, time_limit=10.0)
    assert not again.stats["kept"]
    np.testing.assert_array_equal(again.path.states[0], here)


def test_a_start_in_collision_is_told(robot, skill, obstacles, plan):
    hand = robot.forward(plan.path.states[0])[:3]
    again = skill.replan(plan, robot, obstacles.move("box", hand), time_limit=100.0)
    assert not again.success and "in collision" in again.reason and not again.stats["kept"]


def test_corners():
    rng = np.random.default_rng(0)
    bends = rng.normal(size=(5, 3))
    states = np.vstack([bends[:1]] + [np.linspace(a, b, 9)[1:] for a, b in pairwise(bends)])
    np.testing.assert_allclose(replanning.corners(states), bends, atol=1e-9)
    np.testing.assert_array_equal(replanning.corners(bends[:2]), bends[:2])


def test_nearest_state_counts_turns(robot):
    states = np.tile(robot.home, (4, 1)) + np.arange(4)[:, None] * 0.1 * np.eye(6)[0]
    at, off = replanning.nearest_state(states, states[2] + 2 * np.pi * np.eye(6)[0], robot)
    assert at == 2 and off == pytest.approx(0.0, abs=1e-9)


def test_bad_input(robot, skill, obstacles, plan):
    with pytest.raises(InputError, match="expected a Plan"):
        skill.replan(plan.path, robot, obstacles)
    with pytest.raises(InputError, match="joint positions"):
        skill.replan(plan, robot, obstacles, [0.0])
    lwr4 = Robot.load("lwr4")
    with pytest.raises(InputError, match="7 joints"):
        skill.replan(plan, lwr4, None)
