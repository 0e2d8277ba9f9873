"""Pose Gaussians: gates, charts, samples, and what they refuse."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from keyframes.envelopes import moved, moved_poses, near, random_gaussian, random_poses, rotations
from skillfold.errors import InputError
from skillfold.keyframes.charts import LENGTH, PoseChart
from skillfold.keyframes.gaussians import PoseGaussian

MEAN = np.array([0.1, 0.2, 0.3, 1, 0, 0, 0])
COVARIANCE = np.diag([1e-4, 4e-4, 9e-4, 0.01, 0.04, 0.09])
seeds = st.integers(0, 2**32 - 1)


def inside_by_hand(gaussian, poses):
    """Both blocks' d² within their gates."""
    vectors = (
        Rotation.from_quat(gaussian.mean[3:], scalar_first=True).inv()
        * Rotation.from_quat(poses[:, 3:], scalar_first=True)
    ).as_rotvec()
    blocks = (poses[:, :3] - gaussian.mean[:3], gaussian.covariance[:3, :3]), (vectors, gaussian.covariance[3:, 3:])
    squares = [np.einsum("ni,ni->n", v, np.linalg.solve(sigma, v.T).T) for v, sigma in blocks]
    return np.all(np.transpose(squares) <= gaussian.gates, axis=1)


@settings(deadline=None)
@given(seeds)
def test_a_pose_is_inside_if_both_blocks_are_within_their_gates(seed):
    rng = np.random.default_rng(seed)
    gaussian = random_gaussian(rng)
    poses = np.concatenate([near(gaussian.region, 40, rng, 0.05), random_poses(5, rng)])
    np.testing.assert_array_equal(gaussian.contains(poses), inside_by_hand(gaussian, poses))
    projected = gaussian.project(poses)
    assert gaussian.contains(projected).all()
    np.testing.assert_array_equal(gaussian.project(projected), projected)
    np.testing.assert_array_equal(gaussian.distance(poses) == 0, gaussian.contains(poses))
    assert gaussian.contains(gaussian.mean)


@settings(deadline=None)
@given(seeds)
def test_a_rigid_motion_of_everything_changes_nothing(seed):
    rng = np.random.default_rng(seed)
    gaussian = random_gaussian(rng)
    turn, shift = rotations(1, rng)[0], rng.normal(size=3)
    other = moved(gaussian, turn, shift)
    poses = near(gaussian.region, 20, rng)
    found = other.region.membership(moved_poses(poses, turn, shift))[0]
    np.testing.assert_allclose(found, gaussian.region.membership(poses)[0], rtol=1e-7)


def test_samples_fill_the_gates_evenly():
    """The d² of a block is the square of a radius: its cube is uniform in a ball."""
    gaussian = PoseGaussian(MEAN, COVARIANCE, np.array([4.0, 9.0]))
    poses = gaussian.sample(4000, seed=1)
    assert gaussian.contains(poses).all()
    np.testing.assert_array_equal(poses, gaussian.sample(4000, seed=1))
    assert (poses != gaussian.sample(4000, seed=2)).any()
    y = PoseChart(MEAN[3:]).to_chart(poses) - np.append(MEAN[:3], np.zeros(3))
    for block, gate in ((slice(0, 3), 4.0), (slice(3, 6), 9.0)):
        squares = (y[:, block] ** 2 / np.diag(COVARIANCE)[block]).sum(1) / gate
        np.testing.assert_allclose(
            np.mean(squares**1.5 < [[0.25], [0.5], [0.75]], axis=1), [0.25, 0.5, 0.75], atol=0.04
        )


def test_about_carries_the_rotations_over():
    """Samples of the rotation block, written in another chart, have the covariance it tells, to first order."""
    rng = np.random.default_rng(0)
    covariance = COVARIANCE * np.repeat([1, 1e-4], 3)
    mean = np.append(MEAN[:3], Rotation.from_rotvec([0.3, -0.8, 1.2]).as_quat(scalar_first=True))
    gaussian = PoseGaussian(mean, covariance, np.array([2.0, 3.0]))
    chart = PoseChart(Rotation.from_rotvec([-0.5, 0.2, 0.4]).as_quat(scalar_first=True))
    centre, gated = gaussian.about(chart)
    np.testing.assert_allclose(centre, chart.to_chart(mean))
    np.testing.assert_allclose(gated[0], 2 * covariance[:3, :3])
    steps = rng.normal(size=(20000, 3)) @ np.sqrt(covariance[3:, 3:])
    turns = Rotation.from_quat(mean[3:], scalar_first=True) * Rotation.from_rotvec(steps)
    poses = np.concatenate([np.tile(mean[:3], (20000, 1)), turns.as_quat(scalar_first=True)], axis=1)
    wanted = 3 * np.cov(chart.to_chart(poses)[:, 3:].T)
    np.testing.assert_allclose(gated[1], wanted, atol=0.03 * np.abs(wanted).max())
    same = gaussian.about(PoseChart(mean[3:]))[1][1]
    np.testing.assert_allclose(same, 3 * covariance[3:, 3:], atol=1e-18)


def test_the_derivative_of_the_rotation_vector_is_smooth_at_zero():
    for size in (0.0, 1e-8, 1e-5, 1e-3):
        chart = PoseChart(Rotation.from_rotvec([size, 0, 0]).as_quat(scalar_first=True))
        np.testing.assert_allclose(
            PoseGaussian(MEAN, COVARIANCE).about(chart)[1][1], 9.348 * COVARIANCE[3:, 3:], atol=size
        )


def test_distances_are_metres():
    gaussian = PoseGaussian((0, 0, 0), np.eye(6) * 1e-4, np.array([1.0, 1.0]))
    turned = Rotation.from_rotvec([0, 0.51, 0]).as_quat(scalar_first=True)
    poses = [[0.31, 0, 0, 1, 0, 0, 0], [0, 0, 0, *turned], [0.31, 0, 0, *turned]]
    np.testing.assert_allclose(gaussian.distance(poses), [0.3, LENGTH * 0.5, np.hypot(0.3, LENGTH * 0.5)], atol=1e-9)
    np.testing.assert_array_equal(gaussian.contains(poses, 0.1), [False, True, False])


def test_shapes_follow_those_of_poses():
    gaussian = PoseGaussian(MEAN, COVARIANCE)
    poses = np.tile(MEAN, (4, 2, 1))
    assert gaussian.contains(poses).shape == (4, 2)
    assert gaussian.project(poses).shape == (4, 2, 7)
    assert gaussian.distance(MEAN) == 0
    assert gaussian.distance(np.empty((0, 7))).shape == (0,)
    assert gaussian.sample(0).shape == (0, 7)


def test_repr_and_that_it_is_frozen():
    gaussian = PoseGaussian(MEAN, COVARIANCE, count=7)
    words = "PoseGaussian(at (0.1, 0.2, 0.3) m, σ 0.03 × 0.02 × 0.01 m, 0.3 × 0.2 × 0.1 rad, 7 keyframes)"
    assert repr(gaussian) == words
    with pytest.raises(ValueError, match="read-only"):
        gaussian.covariance[0, 0] = 1


TIED = COVARIANCE + 1e-3 * np.eye(6, k=3) + 1e-3 * np.eye(6, k=-3)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: PoseGaussian([np.nan] * 7, COVARIANCE), "mean"),
        (lambda: PoseGaussian([MEAN, MEAN], COVARIANCE), "mean"),
        (lambda: PoseGaussian(np.zeros(7), COVARIANCE), "mean"),
        (lambda: PoseGaussian(MEAN, np.eye(5)), "covariance"),
        (lambda: PoseGaussian(MEAN, "wide"), "covariance"),
        (lambda: PoseGaussian(MEAN, np.full((6, 6), np.inf)), "covariance"),
        (lambda: PoseGaussian(MEAN, np.zeros((6, 6))), "covariance"),
        (lambda: PoseGaussian(MEAN, -COVARIANCE), "covariance"),
        (lambda: PoseGaussian(MEAN, np.diag([1, 1, 0, 1, 1, 1])), "covariance"),
        (lambda: PoseGaussian(MEAN, np.diag([1, 1, 1, 1, 1, 1e-12])), "covariance"),
        (lambda: PoseGaussian(MEAN, COVARIANCE + np.eye(6, k=1)), "covariance"),
        (lambda: PoseGaussian(MEAN, TIED), "covariance"),
        (lambda: PoseGaussian(MEAN, COVARIANCE, np.array([1.0, 0.0])), "gates"),
        (lambda: PoseGaussian(MEAN, COVARIANCE, np.array(3.0)), "gates"),
        (lambda: PoseGaussian(MEAN, COVARIANCE, np.array([np.nan, 1])), "gates"),
        (lambda: PoseGaussian(MEAN, COVARIANCE).sample(2.5), "count"),
        (lambda: PoseGaussian(MEAN, COVARIANCE).sample(-1), "count"),
        (lambda: PoseGaussian(MEAN, COVARIANCE).contains([1, 2]), "poses"),
        (lambda: PoseGaussian(MEAN, COVARIANCE).distance(None), "poses"),
        (lambda: PoseGaussian(MEAN, COVARIANCE).project([[1, 2, 3, np.nan, 0, 0, 0]]), "poses"),
        (lambda: PoseGaussian(MEAN, COVARIANCE).contains([]), "poses"),
    ],
)
def test_what_cannot_be_used_is_named(make, words):
    with pytest.raises(InputError, match=f"^{words}: .*expected") as caught:
        make()
    assert "\n" not in str(caught.value)
