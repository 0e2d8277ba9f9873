"""Constraints written by hand: laws they share with envelopes, and what they refuse."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from keyframes.envelopes import moved_poses, random_poses, rotations
from skillfold.errors import InputError
from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.hand_written import AxisUpright, PlaneConstraint, TaskSpaceRegion

HERE = (0, 0, 0, 1, 0, 0, 0)


@st.composite
def constraints(draw):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    tolerance = draw(st.sampled_from([1e-9, 1e-3, 0.3]))
    kind = draw(st.sampled_from([AxisUpright, PlaneConstraint, TaskSpaceRegion]))
    if kind is TaskSpaceRegion:
        lower = rng.normal(size=6)
        upper = lower + rng.uniform(0, 1, 6) * draw(st.sampled_from([0.0, 0.1, 2 * np.pi]))
        return TaskSpaceRegion(*random_poses(1, rng), lower, upper, *random_poses(1, rng), tolerance), rng
    return kind(rng.normal(size=3), rng.normal(size=3), tolerance), rng


@settings(deadline=None)
@given(constraints())
def test_laws(case):
    constraint, rng = case
    poses = random_poses(20, rng)
    inside = constraint.project(poses)
    assert constraint.contains(inside).all()
    np.testing.assert_array_equal(constraint.project(inside), inside)
    distances = constraint.distance(poses)
    np.testing.assert_array_equal(distances == 0, constraint.contains(poses))
    assert constraint.contains(poses, distances.max()).all()
    flipped = poses * np.repeat([1, -1], [3, 4])
    np.testing.assert_allclose(constraint.distance(flipped), distances, atol=1e-12)
    assert constraint.distance(poses[0]) == distances[0]
    np.testing.assert_array_equal(constraint.project(poses[0]), inside[0])


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_region_moves_with_its_frame(seed):
    rng = np.random.default_rng(seed)
    turn, shift = rotations(1, rng)[0], rng.normal(size=3)
    frame, offset, *poses = random_poses(12, rng)
    lower = rng.normal(size=6)
    region = TaskSpaceRegion(frame, lower, lower + 0.2, offset)
    moved = TaskSpaceRegion(moved_poses(frame, turn, shift), lower, lower + 0.2, offset)
    found = moved.distance(moved_poses(np.array(poses), turn, shift))
    np.testing.assert_allclose(found, region.distance(poses), atol=1e-9)


def test_samples_of_a_region_are_inside_and_fill_it():
    lower, upper = np.array([-0.1, 0, 0.2, -0.3, 0, -3]), np.array([0.1, 0, 0.3, 0.3, 0.1, 3])
    region = TaskSpaceRegion((1, 2, 3, 0, 1, 0, 0), lower, upper, (0, 0, 0.1, 0, 0, 1, 0))
    poses = region.sample(2000, seed=3)
    assert region.contains(poses).all()
    np.testing.assert_array_equal(poses, region.sample(2000, seed=3))
    assert region.sample(0).shape == (0, 7)
    frame = Rotation.from_quat((0, 1, 0, 0), scalar_first=True)
    offset = Rotation.from_quat((0, 0, 1, 0), scalar_first=True)
    turns = Rotation.from_quat(poses[:, 3:], scalar_first=True) * offset.inv()
    numbers = (frame.inv() * turns).as_euler("xyz")
    positions = frame.inv().apply(poses[:, :3] - turns.apply([0, 0, 0.1]) - [1, 2, 3])
    six = np.concatenate([positions, numbers], axis=1)
    np.testing.assert_allclose(six.min(0), lower, atol=0.02)
    np.testing.assert_allclose(six.max(0), upper, atol=0.02)


def test_what_they_mean():
    cup = AxisUpright(tolerance=0.1)
    tilted = [0, 0, 0, *Rotation.from_rotvec([0.3, 0, 0]).as_quat(scalar_first=True)]
    assert cup.distance(tilted) == pytest.approx(LENGTH * 0.2)
    assert cup.contains(tilted, 0.031)
    assert not cup.contains(tilted)
    board = PlaneConstraint((0, 0, 0.5), (0, 0, 2), 0.01)
    assert board.distance((3, 4, 0.6)) == pytest.approx(0.09)
    np.testing.assert_allclose(board.project((3, 4, 0.6))[:3], (3, 4, 0.5))
    free = TaskSpaceRegion(HERE, [-1, -1, 0, 0, 0, -np.pi], [1, 1, 0, 0, 0, np.pi], tolerance=0.001)
    yaw = [0.5, -0.5, 0, *Rotation.from_rotvec([0, 0, 2.5]).as_quat(scalar_first=True)]
    assert free.contains(yaw)
    assert free.distance(tilted) == pytest.approx(LENGTH * 0.3 - 0.001)


NAN = float("nan")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: AxisUpright((0, 0, 0)), "axis"),
        (lambda: AxisUpright((1e300, 0, 1e300)), "axis"),
        (lambda: AxisUpright((0, 0, NAN)), "axis"),
        (lambda: AxisUpright(up=(1, 0)), "up"),
        (lambda: AxisUpright(tolerance=0), "tolerance"),
        (lambda: AxisUpright(tolerance="much"), "tolerance"),
        (lambda: PlaneConstraint(None), "point"),
        (lambda: PlaneConstraint((0, 0, 0), (0, 0, 1e-300)), "normal"),
        (lambda: PlaneConstraint((0, 0, 0), tolerance=NAN), "tolerance"),
        (lambda: PlaneConstraint((0, 0, 0), tolerance=-1), "tolerance"),
        (lambda: TaskSpaceRegion(np.zeros(7), [0] * 6, [1] * 6), "frame"),
        (lambda: TaskSpaceRegion([HERE, HERE], [0] * 6, [1] * 6), "frame"),
        (lambda: TaskSpaceRegion(HERE, [0] * 5, [1] * 6), "lower"),
        (lambda: TaskSpaceRegion(HERE, [0] * 6, [-1] * 6), "lower"),
        (lambda: TaskSpaceRegion(HERE, [0] * 6, [np.inf] * 6), "upper"),
        (lambda: TaskSpaceRegion(HERE, [0] * 6, [1] * 5 + [7]), "upper"),
        (lambda: TaskSpaceRegion(HERE, [0] * 6, [1] * 6, "there"), "offset"),
        (lambda: TaskSpaceRegion(HERE, [0] * 6, [1] * 6).sample(-1), "count"),
        (lambda: AxisUpright().distance(np.zeros((2, 5))), "poses"),
        (lambda: AxisUpright().project([NAN] * 7), "poses"),
    ],
)
def test_what_cannot_be_used_is_named(make, words):
    with pytest.raises(InputError, match=f"^{words}: .*expected") as caught:
        make()
    assert "\n" not in str(caught.value)
