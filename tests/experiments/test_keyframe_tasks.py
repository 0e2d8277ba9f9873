"""The two tasks of section III of paper 002: what is drawn can be done, and the straight way is blocked."""

import numpy as np
import pytest

from skillfold.experiments.keyframe_tasks import DOWN, tasks
from skillfold.robots.reaching import reach


@pytest.fixture(params=tasks(), ids=lambda task: task.name)
def task(request):
    return request.param


def test_the_straight_way_is_blocked_and_its_ends_are_clear(task):
    """Whatever the posture: of the middle of the straight way from one mean to the other."""
    places = np.array([spread.place for spread in task.keyframes])
    middle = np.append(places.mean(axis=0), DOWN)
    anywhere = reach(task.robot, middle, task.clear[0])
    assert len(anywhere) and len(reach(task.robot, middle, task.clear[1])) == 0
    assert {task.obstacle.name} <= set(task.clear[1].nearest(anywhere[0]).split(" to "))
    for place in places:
        assert len(reach(task.robot, np.append(place, DOWN), task.clear[1]))


def test_demonstrations_are_repeated_by_their_seed_and_are_like_the_truth(task):
    seen = task.demonstrations([3, 1], 3)
    assert seen.shape == (3, 2, 7)
    assert np.array_equal(seen, task.demonstrations([3, 1], 3))
    assert not np.array_equal(seen, task.demonstrations([3, 2], 3))
    for k, spread in enumerate(task.keyframes):
        assert (np.abs(seen[:, k, :3] - spread.place) < 5 * np.array(spread.metres)).all()


def test_a_spread_has_its_deviations(task):
    for spread in task.keyframes:
        poses = spread.draw(4000, np.random.default_rng(0))
        assert np.allclose(poses[:, :3].std(axis=0), spread.metres, rtol=0.1)
        assert np.allclose(np.linalg.norm(poses[:, 3:], axis=1), 1.0)


def test_a_start_is_clear_and_where_it_may_be(task):
    high = task.keyframes[0].place[2]
    q = task.start(0, lambda pose: pose[2] > high)
    pose = task.robot.forward(q)
    assert pose[2] > high and task.clear[1].clearance(q) > 0
    assert np.abs(pose[:3] - task.keyframes[0].place).max() < 0.3


def test_a_start_that_may_be_nowhere_is_told(task):
    with pytest.raises(RuntimeError, match=task.name):
        task.start(0, lambda pose: False)
