"""Quaternions in three coordinates, against SciPy's rotation vectors; recorded poses are no surface of all poses."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from skillfold import SkillManifold, StateSpace
from skillfold.manifold.unrolled import unrolled

COLUMNS = np.array([[1, 2, 3, 4]])


def scalar_first(rotations):
    return rotations.as_quat()[..., [3, 0, 1, 2]]


def test_turns_about_the_mean_are_half_rotation_vectors():
    rng = np.random.default_rng(0)
    half = rng.normal(size=(200, 3)) * 0.3
    half = np.vstack([half, -half])  # so that the mean is known
    turned = Rotation.from_rotvec([0.4, -1.0, 0.2]) * Rotation.from_rotvec(2.0 * half)
    quaternions = scalar_first(turned)
    first = scalar_first(Rotation.from_rotvec([0.4, -1.0, 0.2]))
    quaternions *= np.sign(quaternions @ first)[:, None]
    states = np.column_stack([np.arange(400.0), quaternions, np.ones(400)])
    for sign in (1.0, -1.0):
        found = unrolled(states * [1, sign, sign, sign, sign, 1], COLUMNS)
        np.testing.assert_array_equal(found[:, 0], states[:, 0])
        np.testing.assert_array_equal(found[:, 1], 1.0)
        np.testing.assert_allclose(found[:, 2:], half, atol=1e-9)


def test_neighbours_keep_their_distances():
    rng = np.random.default_rng(1)
    turned = Rotation.from_rotvec(rng.normal(size=(100, 3)) * 0.2)
    near = Rotation.from_rotvec(rng.normal(size=(100, 3)) * 1e-4) * turned
    one, other = (scalar_first(r) for r in (turned, near))
    lengths = np.linalg.norm(one - other, axis=1)
    both = unrolled(np.vstack([one, other]), np.array([[0, 1, 2, 3]]))
    np.testing.assert_allclose(np.linalg.norm(both[:100] - both[100:], axis=1), lengths, rtol=0.1)


def test_without_quaternions_states_stay_as_they_are():
    states = np.random.default_rng(2).normal(size=(10, 3))
    np.testing.assert_array_equal(unrolled(states, np.empty((0, 4), dtype=np.intp)), states)


@pytest.mark.parametrize("count", [5, 40])
def test_recorded_poses_that_spread_little_are_of_a_curve(count):
    """The unit length of their quaternions is no reason to take all poses for the skill."""
    rng = np.random.default_rng(count)
    t = np.linspace(0.0, 1.0, 100)[:, None]
    ways = np.hstack([1 - t, t, np.sin(np.pi * t)])

    def recorded():
        place = np.hstack([t, 0.3 * np.sin(3 * t), 0.2 * t**2]) + 0.004 * ways @ rng.normal(size=(3, 3))
        turn = np.hstack([t, -0.5 * t, 0.3 * np.sin(2 * t)]) + 0.01 * ways @ rng.normal(size=(3, 3))
        return np.hstack([place, scalar_first(Rotation.from_rotvec(turn))])

    recordings = [recorded() for _ in range(count)]
    skill = SkillManifold.fit(recordings, space=StateSpace.pose(), kernels=10, ridge=1e-5, jobs=1)
    assert skill.dim == 1
    starts = [recorded() for _ in range(4)]
    plans = [skill.plan(states[0], states[-1], route="geodesic") for states in starts]
    assert all(plan.success for plan in plans), [plan.reason for plan in plans]


def test_ends_that_are_moved_onto_the_manifold_are_poses():
    """A mean of orientations that lie far apart is shorter than they are."""
    rng = np.random.default_rng(3)
    t = np.linspace(0.0, 1.0, 100)[:, None]
    ways = np.hstack([1 - t, t, np.sin(np.pi * t)])

    def recorded():
        turn = np.hstack([t, -0.5 * t, 0.3 * np.sin(2 * t)]) + 0.15 * ways @ rng.normal(size=(3, 3))
        return np.hstack([t, t**2, 0.0 * t, scalar_first(Rotation.from_rotvec(turn))])

    skill = SkillManifold.fit(
        [recorded() for _ in range(8)], space=StateSpace.pose(), dim=1, kernels=10, ridge=1e-5, jobs=1
    )
    plans = [skill.plan(states[0], states[-1], route="geodesic") for states in (recorded() for _ in range(12))]
    assert any(plan.start_moved > 0.0 or plan.goal_moved > 0.0 for plan in plans)
    for plan in plans:
        np.testing.assert_allclose(np.linalg.norm(plan.path.states[:, 3:], axis=1), 1.0, atol=1e-9)
