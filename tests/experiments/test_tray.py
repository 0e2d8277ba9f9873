"""The tray carrier's optimal poses against SciPy's optimiser, finite differences and rotations of its own."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from skillfold.experiments import tray
from skillfold.experiments.tray import LEVEL_WEIGHT, PAPER_WEIGHT
from skillfold.manifold.skill import SkillManifold

WEIGHTS = [PAPER_WEIGHT, LEVEL_WEIGHT]
TILTED = {PAPER_WEIGHT: 0.2, LEVEL_WEIGHT: 0.01}  # rad at most


@pytest.fixture(scope="module", params=WEIGHTS, ids=["paper", "level"])
def weight(request):
    return request.param


@pytest.fixture(scope="module")
def places():
    return tray.workspace(400, np.random.default_rng(0))


@pytest.fixture(scope="module")
def poses(places, weight):
    return tray.optimum(places, weight)


def test_workspace_is_what_it_says(places):
    assert tray.in_workspace(places).all()
    radius = np.hypot(places[:, 0], places[:, 1])
    assert (radius.min() >= 0.35, radius.max() <= 0.70) == (True, True)
    assert np.linalg.norm(places - [0, 0, 0.078 + 0.31], axis=1).max() < 0.70


def test_optimum_reaches_its_position_and_is_stationary(places, poses, weight):
    np.testing.assert_allclose(tray.positions(poses), places, atol=1e-10)
    assert tray.kkt_residual(poses, places, weight).max() < 1e-10


def test_stationarity_by_finite_differences(poses, weight):
    """No first-order change of the cost along any self-motion."""
    step = 1e-5
    for pose in poses[:20]:
        free = np.linalg.svd(tray.arm().jacobian(pose)[:3])[2][3:]
        slope = (tray.cost(pose + step * free, weight) - tray.cost(pose - step * free, weight)) / (2 * step)
        np.testing.assert_allclose(slope, 0.0, atol=1e-8)


def test_optimum_is_a_minimum(poses, weight):
    curvature = tray.reduced_curvature(poses[tray.inside_limits(poses)], weight)
    assert curvature.min() > weight


def test_optimum_is_where_an_optimiser_ends(places, poses, weight):
    rng = np.random.default_rng(1)
    for place, pose in zip(places[:6], poses[:6], strict=True):
        reach = {"type": "eq", "fun": lambda q, place=place: tray.positions(q) - place}
        start = pose + 0.1 * rng.standard_normal(7)
        options = {"maxiter": 500, "ftol": 1e-12}
        scaled = {"fun": lambda q: tray.cost(q, weight) / weight, "x0": start}
        found = minimize(**scaled, constraints=[reach], method="SLSQP", options=options)
        assert tray.cost(pose, weight) <= weight * found.fun + 1e-6
        np.testing.assert_allclose(found.x, pose, atol=1e-2)


def test_one_branch_without_jumps(places, poses, weight):
    clear = tray.inside_limits(poses)
    near = places + 1e-3 * np.random.default_rng(2).standard_normal(places.shape)
    moved = np.linalg.norm(tray.optimum(near, weight) - poses, axis=1) / np.linalg.norm(near - places, axis=1)
    assert moved[clear].max() < 15
    assert (poses[clear, 3] > 0).all()  # elbow up


def test_tilt_is_the_angle_of_the_tool_and_its_square_pitch_and_roll(poses, weight):
    turned = Rotation.from_quat(tray.arm().forward(poses)[:, 3:], scalar_first=True)
    expected = np.arccos(np.clip(turned.apply([0, 0, 1])[:, 2], -1, 1))
    np.testing.assert_allclose(tray.tilt(poses), expected, atol=1e-7)
    _, pitch, roll = turned.as_euler("ZYX").T
    np.testing.assert_allclose(tray.tilt(poses) ** 2, pitch**2 + roll**2, rtol=0.01, atol=1e-12)
    assert tray.tilt(poses).max() < TILTED[weight]


def test_arm_at_zero_carries_level():
    assert tray.tilt(np.zeros((1, 7))) == pytest.approx([0.0])
    assert tray.cost(np.eye(7)[3:4], 0.1) == pytest.approx(0.1 + 1.0)


def test_out_of_reach_is_not_a_number():
    assert np.isnan(tray.optimum(np.array([[1.5, 0, 0.5], [0.5, 0.1, 0.7]]))).all(axis=1).tolist() == [True, False]


def test_demonstrations_are_optimal_clear_of_limits_and_the_same_for_a_seed(weight):
    demos = tray.tray_poses(100, np.random.default_rng(3), weight)
    assert demos.shape == (100, 7)
    assert tray.inside_limits(demos).all()
    assert tray.in_workspace(tray.positions(demos)).all()
    assert tray.kkt_residual(demos, tray.positions(demos), weight).max() < 1e-9
    np.testing.assert_array_equal(demos, tray.tray_poses(100, np.random.default_rng(3), weight))


def test_a_skill_finds_three_dimensions_and_brings_states_back(weight):
    rng = np.random.default_rng(4)
    skill = SkillManifold.fit(tray.tray_poses(100, rng, weight))
    assert skill.dim == 3
    pushed = tray.tray_poses(200, rng, weight) + 0.1 * rng.standard_normal((200, 7))
    brought = skill.project(pushed)
    errors = np.linalg.norm(brought - tray.optimum(tray.positions(brought), weight), axis=1)
    assert np.median(errors) < 2e-3


def test_a_skill_leaves_optimal_poses_where_they_are():
    """Also a little outside of the poses it was shown, where its anchors disagree more than they usually do."""
    skill = SkillManifold.fit(tray.tray_poses(100, np.random.default_rng(5), tray.PAPER_WEIGHT), dim=3, kernels=10)
    asked = tray.tray_poses(2000, np.random.default_rng(105), tray.PAPER_WEIGHT)
    assert (skill.inside(asked) > 1.2).any()
    assert np.linalg.norm(skill.project(asked) - asked, axis=1).max() < 0.1
