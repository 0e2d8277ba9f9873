"""The arms' tool axes against rotations composed by SciPy, and the samples against what they claim."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from skillfold.experiments.rows import Settings
from skillfold.experiments.upright import JACO, LWR4, measure, tilt, tool_axis, upright_poses

ARMS = [LWR4, JACO]


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_tool_axis_against_composed_rotations(arm):
    poses = arm.uniform(20, np.random.default_rng(0))
    for pose, axis in zip(poses, tool_axis(arm, poses), strict=True):
        turn = Rotation.identity()
        for q, sign, offset, twist in zip(pose, arm.sign, arm.offset, arm.twist, strict=True):
            turn = turn * Rotation.from_euler("z", sign * q + offset) * Rotation.from_euler("x", twist)
        np.testing.assert_allclose(axis, turn.apply([0, 0, 1]), atol=1e-12)


def test_lwr4_stands_straight_up_at_zero_and_bends_at_the_elbow():
    zero = np.zeros(7)
    half = np.eye(7)[3] * np.pi / 2
    assert tilt(LWR4, np.stack([zero, half])) == pytest.approx([np.pi, np.pi / 2])


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_base_yaw_and_last_roll_do_not_matter(arm):
    rng = np.random.default_rng(1)
    poses = arm.uniform(50, rng)
    turned = poses.copy()
    turned[:, [0, -1]] += rng.uniform(-1, 1, (50, 2))
    np.testing.assert_allclose(tilt(arm, turned), tilt(arm, poses), atol=1e-12)


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_samples_are_upright_inside_the_limits_and_spread(arm):
    poses = upright_poses(arm, 800, np.random.default_rng(2))
    assert poses.shape == (800, len(arm.lower))
    assert tilt(arm, poses).max() < np.radians(1.5)
    assert ((poses >= arm.lower) & (poses <= arm.upper)).all()
    spread = np.ptp(poses, axis=0) / (arm.upper - arm.lower)
    assert (spread > 0.7).all()


def test_protocol_counts_states_that_end_upright():
    def fit(samples):
        return SimpleNamespace(dim=5, project=lambda x: np.resize(samples, x.shape))

    rows = measure(Settings(0, fit=fit), counts=(500,), states=100)
    assert [row.measured for row in rows] == [1.0, 1.0]
    lazy = measure(Settings(0, fit=lambda _: SimpleNamespace(dim=5, project=np.copy)), counts=(500,), states=300)
    assert all(row.measured < 0.05 and row.met is False for row in lazy)
