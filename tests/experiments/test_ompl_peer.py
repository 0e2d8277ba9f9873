"""The learnt constraint against the skill itself, and OMPL on it where OMPL is installed."""

import importlib.util

import numpy as np
import pytest

from manifold.kernels import evaluated
from skillfold.errors import InputError, MissingExtraError
from skillfold.experiments import tray, tray_cases, upright
from skillfold.experiments.learnt_constraint import LearntConstraint
from skillfold.experiments.ompl_peer import SPACES, OmplPeer
from skillfold.manifold.kernels.judging import displacements
from skillfold.manifold.skill import SkillManifold

INSTALLED = importlib.util.find_spec("ompl") is not None


@pytest.fixture(scope="module")
def skill():
    return SkillManifold.fit(tray.tray_poses(200, np.random.default_rng(0), tray.LEVEL_WEIGHT), dim=3, kernels=40)


@pytest.fixture(scope="module")
def skills(skill):
    """Without directions that are free everywhere, and with them."""
    poses = upright.upright_poses(upright.LWR4, 500, np.random.default_rng(0))
    level = SkillManifold.fit(poses, kernels=20)
    assert level.model.free.shape[1] > 0
    return [skill, level]


@pytest.fixture(scope="module")
def states():
    rng = np.random.default_rng(1)
    return tray.tray_poses(40, rng, tray.LEVEL_WEIGHT) + 0.05 * rng.standard_normal((40, 7))


def test_the_function_is_the_displacement_and_the_jacobian_spans_the_normals(skills, states):
    for skill in skills:
        learnt, model = LearntConstraint(skill), skill.model
        assert learnt.codim == 7 - skill.dim
        for x in states:
            off = displacements(model.table, x[None], np.inf)[0][0]
            jacobian = learnt.jacobian(x).copy()
            np.testing.assert_allclose(jacobian @ jacobian.T, np.eye(learnt.codim), atol=1e-12)
            along = model.kept @ evaluated(model, model.encode(x[None])).bases[0].T
            np.testing.assert_allclose(jacobian @ along, 0.0, atol=1e-10)
            np.testing.assert_allclose(jacobian @ model.free, 0.0, atol=1e-10)
            assert np.linalg.norm(learnt.value(x)) == pytest.approx(off, rel=1e-10, abs=1e-12)


def test_newton_steps_with_it_end_on_the_manifold(skill, states):
    learnt = LearntConstraint(skill)
    for x in states:
        for _ in range(30):
            x = x - learnt.jacobian(x).T @ learnt.value(x)
        assert skill.distance(x) < 1e-9


def test_nearby_states_are_supported_and_far_ones_are_not(skill, states):
    learnt = LearntConstraint(skill)
    assert all(learnt.supported(x) for x in tray.tray_poses(20, np.random.default_rng(2), tray.LEVEL_WEIGHT))
    assert not learnt.supported(states[0] + 3.0)


def test_unknown_space(skill):
    with pytest.raises(InputError, match="projected, atlas"):
        OmplPeer(skill, None, "tangent bundle")


@pytest.mark.skipif(INSTALLED, reason="OMPL is installed")
def test_without_ompl_the_extra_is_named(skill):
    with pytest.raises(MissingExtraError, match="peers"):
        OmplPeer(skill, None, "atlas")


@pytest.mark.skipif(not INSTALLED, reason="OMPL is not installed")
@pytest.mark.parametrize("space", SPACES)
def test_ompl_holds_the_manifold_and_keeps_clear(skill, space):
    for case in tray_cases.past_boxes(3, np.random.default_rng(3)):
        obstacles = tray.arm().obstacles(case.scene)
        plan = OmplPeer(skill, obstacles, space).plan(case.start, case.goal, time_limit=30.0)
        assert plan.solved
        assert 0 < plan.first_seconds <= plan.seconds
        np.testing.assert_allclose(plan.states[[0, -1]], [case.start, case.goal], atol=0.02)
        assert skill.distance(plan.states).max() < 2e-4
        assert obstacles.clearance(plan.states).min() > -0.04  # OMPL looks at steps, not between them
        assert plan.length > 0.9 * np.linalg.norm(case.goal - case.start)


@pytest.mark.skipif(not INSTALLED, reason="OMPL is not installed")
def test_no_way_is_no_error(skill):
    case = tray_cases.past_boxes(1, np.random.default_rng(4))[0]
    blocked = OmplPeer(skill, tray.arm().obstacles([tray_box(case.goal)]), "atlas")
    plan = blocked.plan(case.start, case.goal, time_limit=0.2)
    assert (plan.solved, plan.length, len(plan.states)) == (False, float("inf"), 0)


def tray_box(goal):
    from skillfold import Box

    return Box(pose=tray.positions(goal[None])[0], size=(0.2, 0.2, 0.2))
