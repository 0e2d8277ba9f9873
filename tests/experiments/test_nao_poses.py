"""Nao's optimal poses against finite differences, another optimiser, and what the robot's kinematics say."""

import json

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from skillfold.experiments.nao_poses import ANGLE, CENTRE, LENGTH, POSTURE, Optimiser, axes
from skillfold.robots.robot import Robot
from skillfold.robots.standing import SIDES, base_of
from support import shared

FOOT = np.array([0.04, 0.09, 0.03])  # from a left swing foot's stance; mirrored for a right one


@pytest.fixture(scope="module", params=SIDES)
def optimiser(request):
    return Optimiser(request.param)


def foot(optimiser):
    return FOOT * [1.0, -optimiser.mirror, 1.0]


def test_axes_are_the_rows_of_a_rotation():
    turned = Rotation.random(random_state=0)
    np.testing.assert_allclose(axes(turned.as_quat(scalar_first=True)), turned.as_matrix().T, atol=1e-12)


def test_derivative_by_finite_differences(optimiser):
    asked, robot, step = optimiser.over_foot(foot(optimiser)), optimiser.robot, 1e-6
    for q in robot.sample(4, 1):
        slopes = []
        for column in optimiser.free:
            nudge = step * np.eye(robot.dof)[column]
            ends = [optimiser.residuals(robot.couple(q + sign * nudge), asked) for sign in (1, -1)]
            slopes.append((ends[0] - ends[1]) / (2 * step))
        np.testing.assert_allclose(optimiser.derivative(robot.couple(q)), np.array(slopes).T, atol=1e-6)


def test_optimum_does_what_was_asked_by_the_whole_robots_kinematics(optimiser):
    found = optimiser.optimise(optimiser.over_foot(foot(optimiser)))
    robot, nao = optimiser.robot, Robot.load("nao")
    whole = robot.whole(found.pose)
    base = base_of(nao, whole, robot.stance)
    swing, torso = nao.forward(whole, robot.swing, base), nao.forward(whole, "Torso", base)
    assert found.reached
    np.testing.assert_allclose(swing[:3], foot(optimiser), atol=1e-3)
    np.testing.assert_allclose(torso[:2], CENTRE * [1.0, optimiser.mirror], atol=1e-3)
    for pose in (swing, torso):
        assert Rotation.from_quat(pose[3:], scalar_first=True).magnitude() < 0.01
    assert whole[nao.names.index("RHipYawPitch")] == whole[nao.names.index("LHipYawPitch")]


def test_optimum_is_where_another_optimiser_ends(optimiser):
    asked = optimiser.over_foot(foot(optimiser))
    best = optimiser.optimise(asked)

    def cost(z):
        q = np.zeros(optimiser.robot.dof)
        q[optimiser.free] = z
        return float(np.sum(optimiser.residuals(optimiser.robot.couple(q), asked) ** 2))

    start = best.pose[optimiser.free] + 0.05 * np.random.default_rng(0).standard_normal(11)
    bounds = list(zip(*(side[optimiser.free] for side in optimiser.robot.limits), strict=True))
    options = {"maxiter": 2000, "maxfun": 60000, "ftol": 1e-14, "gtol": 1e-9}
    found = minimize(cost, np.clip(start, *np.array(bounds).T), method="L-BFGS-B", bounds=bounds, options=options)
    assert best.cost <= found.fun + 1e-7
    assert cost(best.pose[optimiser.free]) == pytest.approx(best.cost)
    np.testing.assert_allclose(found.x, best.pose[optimiser.free], atol=0.05)


def test_from_elsewhere_and_without_derivatives_it_is_the_same(optimiser):
    asked = optimiser.over_foot(foot(optimiser))
    best = optimiser.optimise(asked).pose
    again = optimiser.optimise(asked, first=best + 0.2)
    blind = optimiser.optimise(asked, analytic=False)
    np.testing.assert_allclose(again.pose, best, atol=1e-3)
    np.testing.assert_allclose(blind.pose, best, atol=1e-3)


def test_out_of_reach_is_told_and_within_limits(optimiser):
    found = optimiser.optimise(optimiser.over_foot(np.array([0.3, -0.3 * optimiser.mirror, 0.0])))
    lower, upper = optimiser.robot.limits
    assert not found.reached
    assert ((found.pose >= lower) & (found.pose <= upper)).all()


def test_both_legs_are_mirror_images():
    """All but a few thousandths of a radian of the ankles' limits."""
    left, right = Optimiser("left"), Optimiser("right")
    poses = {
        o.side: dict(zip(o.robot.names, o.optimise(o.over_foot(foot(o))).pose, strict=True)) for o in (left, right)
    }
    for name, value in poses["left"].items():
        other = ("R" if name[0] == "L" else "L") + name[1:]
        sign = -1.0 if "Roll" in name else 1.0
        assert value == pytest.approx(sign * poses["right"][other], abs=1e-3)


def test_costs_are_weighed_in_their_units(optimiser):
    asked = optimiser.over_foot(foot(optimiser))
    q = optimiser.robot.home
    found = optimiser.residuals(q, asked)
    swing = optimiser.robot.forward(q, optimiser.robot.swing)
    np.testing.assert_allclose(found[:3], (swing[:3] - asked.foot) / LENGTH)
    np.testing.assert_allclose(found[-11:], 0.0, atol=1e-12)
    nudged = q + POSTURE
    assert np.sum(optimiser.residuals(nudged, asked)[-11:] ** 2) == pytest.approx(11 * POSTURE**4)
    turned = q.copy()
    turned[optimiser.robot.names.index(("R" if optimiser.side == "left" else "L") + "AnklePitch")] += 0.1
    assert np.hypot(*(optimiser.residuals(turned, asked) - found)[3:5]) == pytest.approx(np.sin(0.1) / ANGLE)


def test_the_sole_is_that_of_the_published_sensors():
    """The right foot mirrors the left but for six tenths of a millimetre at its heel."""
    facts = json.loads(shared("facts/nao_h25.json").read_text())
    for side in SIDES:
        published = np.array(facts[f"fsr_in_ankle_roll_frame_{side}"])[:, :2]
        ours = Optimiser(side).polygon
        np.testing.assert_allclose(ours[np.lexsort(ours.T)], published[np.lexsort(published.T)], atol=7e-4)
        np.testing.assert_allclose(Optimiser(side).centre, published.mean(0), atol=5e-4)
