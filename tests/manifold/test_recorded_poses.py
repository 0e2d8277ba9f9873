"""Pose skills learnt from real recordings (RoboTasks): skipped where they are not beside the repository."""

import numpy as np
import pytest

from skillfold import Demonstrations, SkillManifold, StateSpace
from support import shared

TASKS = ["bottle2shelf", "openbox", "platestandingtolying", "pouring"]
NAMES = ["x", "y", "z", "qw", "qx", "qy", "qz"]


@pytest.fixture(scope="module", params=TASKS)
def task(request):
    """Four demonstrations to learn from, one to try, and the skill; positions from centimetres to metres."""
    poses = np.load(shared(f"data/robotasks/{request.param}.npy"), allow_pickle=False)
    poses = poses[:5] * np.r_[np.full(3, 0.01), np.ones(4)]
    demos = Demonstrations(list(poses), names=NAMES).resample(60)
    skill = SkillManifold.fit(demos.leave_out(4), dim=1, kernels=10, ridge=1e-5, jobs=1)
    return demos, skill


def lengths(states):
    return np.linalg.norm(states[..., 3:], axis=-1)


def test_names_make_the_pose(task):
    _, skill = task
    assert skill.space == StateSpace.pose()
    assert skill.names == tuple(NAMES)
    assert (skill.n_dims, skill.dim) == (7, 1)


def test_demonstrations_are_planned_again(task):
    """Whole plans between each demonstration's own ends: exact there, unit quaternions, near what was shown."""
    demos, skill = task
    for i, demo in enumerate(demos):
        plan = skill.plan(demo.states[0], demo.states[-1])
        states = plan.path.states
        np.testing.assert_allclose(lengths(states), 1.0, atol=1e-9)
        for row, end in ((0, 0), (-1, -1)):
            np.testing.assert_allclose(skill.space.difference(states[row], demo.states[end]), 0.0, atol=1e-9)
        off = np.linalg.norm(states[:, None, :3] - demo.states[:, :3], axis=2).min(1)
        straight = demo.states[0] + np.linspace(0, 1, 60)[:, None] * (demo.states[-1] - demo.states[0])
        line = np.linalg.norm(straight[:, None, :3] - demo.states[:, :3], axis=2).min(1)
        assert np.isfinite(states).all()
        assert plan.route == "demonstrated"
        if i < 4:  # what it has learnt from
            assert plan.success, plan.reason
            assert off.mean() < line.mean()


def test_the_same_orientation_written_with_the_other_sign_is_the_same_state(task):
    demos, skill = task
    states = demos[4].states[::10]
    flipped = states * np.r_[np.ones(3), -np.ones(4)]
    np.testing.assert_allclose(skill.distance(flipped), skill.distance(states), atol=1e-12)
    np.testing.assert_allclose(skill.project(flipped), skill.project(states), atol=1e-9)
    one = skill.plan(states[0], states[-1]).path.states
    np.testing.assert_allclose(skill.plan(flipped[0], flipped[-1]).path.states, one, atol=1e-9)


def test_projections_and_samples_are_poses(task):
    demos, skill = task
    rng = np.random.default_rng(0)
    pushed = demos[4].states + 0.02 * rng.normal(size=(60, 7))
    np.testing.assert_allclose(lengths(skill.project(pushed)), 1.0, atol=1e-9)
    np.testing.assert_allclose(lengths(skill.sample(20)), 1.0, atol=1e-9)


def test_geodesics_between_demonstrated_states_are_poses(task):
    demos, skill = task
    states = demos[0].states
    plan = skill.plan(states[5], states[40], route="geodesic")
    np.testing.assert_allclose(lengths(plan.path.states), 1.0, atol=1e-9)
    assert plan.route == "geodesic"
    assert plan.length > 0


def test_demonstrated_states_are_on_the_manifold_and_inside(task):
    demos, skill = task
    known = np.concatenate([demo.states for demo in list(demos)[:4]])
    assert skill.contains(known).mean() > 0.9
    assert np.median(skill.inside(known)) < 1.0
    away = known[::20] + np.r_[1.0, 1.0, 1.0, np.zeros(4)]
    assert not skill.contains(away).any()
    assert skill.inside(away).min() > 1.0


def test_saved_and_loaded_it_answers_the_same(task, tmp_path):
    demos, skill = task
    skill.save(tmp_path / "pose.npz")
    back = SkillManifold.load(tmp_path / "pose.npz")
    states = demos[4].states
    np.testing.assert_array_equal(back.distance(states), skill.distance(states))
    np.testing.assert_array_equal(
        back.plan(states[0], states[-1]).path.states, skill.plan(states[0], states[-1]).path.states
    )
