"""Keyframes from full recordings."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from keyframes.skills import any_motion, moved
from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.extraction import developed, extract

CORNERS = np.array([[0.0, 0, 0], [0.4, 0, 0], [0.4, 0.3, 0], [0.4, 0.3, 0.3]])


def along(corners, samples=100, pause=0, smooth=True):
    """Poses (n, 7) from corner to corner, stopping at each where `smooth`, and resting there."""
    phase = np.linspace(0.0, 1.0, samples, endpoint=False)
    phase = phase**2 * (3 - 2 * phase) if smooth else phase
    parts = []
    for a, b in pairwise(corners):
        parts += [a + phase[:, None] * (b - a), np.tile(b, (pause + 1, 1))]
    rows = np.concatenate(parts)
    return np.hstack([rows, np.tile([1.0, 0, 0, 0], (len(rows), 1))])


def near_corners(poses, rows, corners=CORNERS, reach=0.02):
    assert len(rows) == len(corners)
    np.testing.assert_allclose(poses[rows, :3], corners, atol=reach)


@pytest.mark.parametrize(("pause", "smooth"), [(20, True), (0, True), (0, False)])
def test_corners_are_keyframes(pause, smooth):
    poses = along(CORNERS, pause=pause, smooth=smooth)
    near_corners(poses, extract(poses))


def test_a_rest_on_a_straight_line_is_a_keyframe():
    line = np.array([[0.0, 0, 0], [0.2, 0, 0], [0.5, 0, 0]])
    poses = along(line, pause=15)
    near_corners(poses, extract(poses), line)


def test_times_tell_what_is_slow():
    """Evenly spaced states whose clock stops halfway."""
    poses = along(np.array([[0.0, 0, 0], [1.0, 0, 0]]), smooth=False)
    times = np.concatenate([np.arange(50), 49 + 40.0 * np.arange(1, 6), 300 + np.arange(len(poses) - 55)])
    assert len(extract(poses)) == 2
    rows = extract(poses, times)
    assert len(rows) == 3 and 47 <= rows[1] <= 57


def test_turning_on_the_spot_counts_as_motion():
    angle = np.concatenate([np.linspace(0, 2, 60), np.full(20, 2.0), np.linspace(2, 0.5, 60)])
    turns = Rotation.from_rotvec(angle[:, None] * [0.0, 0, 1]).as_quat(scalar_first=True)
    rows = extract(np.hstack([np.zeros((140, 3)), turns]))
    assert len(rows) == 3 and 55 <= rows[1] <= 85


def test_gripper_events():
    poses = along(CORNERS, smooth=False)
    gripper = np.full(len(poses), 0.08)
    gripper[90:210] = 0.02
    gripper += 0.002 * np.sin(np.arange(len(poses)))  # noise crosses no middle
    np.testing.assert_array_equal(extract(poses, None, gripper), [0, 90, 210, len(poses) - 1])


def test_a_gripper_that_never_moves_leaves_the_ends():
    poses = along(CORNERS)
    np.testing.assert_array_equal(extract(poses, None, np.zeros(len(poses))), [0, len(poses) - 1])


def test_events_close_together_are_one():
    poses = along(CORNERS, smooth=False)
    gripper = np.zeros(len(poses))
    gripper[100:104] = 1.0
    np.testing.assert_array_equal(extract(poses, None, gripper), [0, 100, len(poses) - 1])


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_short_and_still_recordings(count):
    still = np.tile([1.0, 2, 3, 1, 0, 0, 0], (count, 1))
    np.testing.assert_array_equal(extract(still), np.unique([0, count - 1]))
    moving = still + np.arange(count)[:, None] * [1.0, 0, 0, 0, 0, 0, 0]
    rows = extract(moving)
    assert rows[0] == 0 and rows[-1] == count - 1 and (np.diff(rows) > 0).all()


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_rigid_motion_changes_nothing(seed):
    rng = np.random.default_rng(seed)
    poses = along(np.cumsum(rng.normal(0, 0.3, (5, 3)), axis=0), samples=40, pause=4)
    poses[:, 3:] = Rotation.from_rotvec(np.cumsum(rng.normal(0, 0.02, (len(poses), 3)), 0)).as_quat(scalar_first=True)
    other = moved(poses, *any_motion(seed))
    np.testing.assert_allclose(
        np.linalg.norm(np.diff(developed(poses), axis=0), axis=1),
        np.linalg.norm(np.diff(developed(other), axis=0), axis=1),
        atol=1e-9,
    )
    rows = extract(poses)
    assert rows[0] == 0 and rows[-1] == len(poses) - 1 and (np.diff(rows) > 0).all()
    assert np.abs(len(rows) - len(extract(other))) <= 1  # rounding may part a tie


def test_a_curve_unrolls_rotations():
    """Three full turns about one axis are as long as they are."""
    turns = Rotation.from_rotvec(np.linspace(0, 6 * np.pi, 200)[:, None] * [0.0, 1, 0]).as_quat(scalar_first=True)
    curve = developed(np.hstack([np.zeros((200, 3)), turns]))
    np.testing.assert_allclose(curve[-1], [0, 0, 0, 0, LENGTH * 6 * np.pi, 0], atol=1e-9)
