"""Descents of poses against plain twins, on the Jaco."""

import numpy as np
import pytest

from keyframes import planner_twins as twins
from keyframes.asked import UNITS, asked
from manifold.kernels import callable_of
from skillfold.keyframes.kernels import descent as _descent
from skillfold.keyframes.kernels import problem as _problem

descent, problem = callable_of(_descent), callable_of(_problem)
AXES = np.random.default_rng(0).normal(size=(8, 2, 6)) * 0.3


@pytest.fixture(scope="module", params=[100.0, 60.0])
def world(request):
    return asked(request.param)


@pytest.fixture(scope="module")
def work():
    return problem.make_work(6)


def targets(world, count, seed=0):
    return world.leg.targets.inside(count, seed)


def test_turned():
    angles = np.random.default_rng(0).uniform(-20, 20, 50)
    found = np.array([descent.turned(a) for a in angles])
    np.testing.assert_allclose(np.exp(1j * found), np.exp(1j * angles), atol=1e-12)
    assert (np.abs(found) <= np.pi).all()


def test_tool_pose(world):
    out = np.empty(7)
    for q in world.states(5):
        descent.tool_pose(world.problem.tool, q, out)
        np.testing.assert_allclose(out, world.robot.forward(q), atol=1e-12)


def test_is_inside(world):
    twin, answers = twins.Twin(world), set()
    for pose in world.robot.forward(world.states(60)):
        answers.add(bool(twin.is_inside(pose)))
        assert descent.is_inside(world.problem.hold, pose) == twin.is_inside(pose)
    assert answers == {False, True}


def test_along_axis_is_the_nearest_place():
    rng, shares = np.random.default_rng(1), np.linspace(0, 1, 2001)
    for axis in AXES:
        y = axis[0] + rng.normal(size=6) * 0.4
        found = descent.along_axis(axis, y)
        assert found == pytest.approx(twins.along_axis(axis, y), abs=1e-12)
        points = axis[0] + shares[:, None] * (axis[1] - axis[0])
        lengths = np.linalg.norm((points - y) * UNITS, axis=1)
        assert found == pytest.approx(shares[lengths.argmin()], abs=1e-3)
    assert descent.along_axis(np.zeros((2, 6)), np.ones(6)) == 0.0


def test_pull():
    rng, out = np.random.default_rng(2), np.empty(6)
    for axis in (*AXES, np.zeros((2, 6))):
        for scale in (1.0, 0.01):
            y, target = rng.normal(size=(2, 6)) * 0.3 * scale
            left = descent.pull(axis, y, target, out)
            step, off = twins.pull(axis, y, target)
            np.testing.assert_allclose(out, step, atol=1e-13)
            assert left == pytest.approx(off)
            assert np.linalg.norm(out * UNITS) <= _descent.STRIDE * (1 + 1e-12)


def test_pulls_lead_to_the_target():
    """From anywhere, whatever the axis: eq. 3b with line 17's offset has its valley through the target."""
    rng, step = np.random.default_rng(3), np.empty(6)
    for axis in AXES:
        y, target = rng.normal(size=(2, 6)) * 0.5
        for _ in range(300):
            descent.pull(axis, y, target, step)
            y = y + step
        assert np.linalg.norm((y - target) * UNITS) < 1e-6


def test_twist_brings_one_pose_to_the_other(world):
    out = np.empty(6)
    poses = world.robot.forward(world.robot.sample(12, 1))
    for pose, wanted in zip(poses[:6], poses[6:], strict=True):
        descent.twist(pose, wanted, out)
        np.testing.assert_allclose(out, twins.twist(pose, wanted), atol=1e-9)


@pytest.mark.parametrize("dof", [1, 3, 6, 9])
def test_solve_damped(dof):
    rng = np.random.default_rng(dof)
    for damping in (1e-3, 1.0):
        jacobian, right = rng.normal(size=(6, dof)), rng.normal(size=6)
        wanted = np.linalg.solve(jacobian @ jacobian.T + damping * np.eye(6), right)
        descent.solve_damped(jacobian, np.empty((6, 6)), right, damping)
        np.testing.assert_allclose(right, wanted, rtol=1e-7, atol=1e-9)


def test_face(world, work):
    for q in world.states(4):
        descent.face(world.problem, q, work)
        np.testing.assert_allclose(work.jacobian, twins.Twin(world).jacobian(q), atol=1e-12)
        np.testing.assert_allclose(work.pose, world.robot.forward(q), atol=1e-12)


def test_keep_inside(world, work):
    twin, moved = twins.Twin(world), 0
    for pose in world.robot.forward(world.states(20)):
        work.wanted[:] = pose
        descent.keep_inside(world.problem, work)
        np.testing.assert_allclose(work.wanted, twin.keep_inside(pose), atol=1e-9)
        moved += not np.array_equal(work.wanted, pose)
        assert twin.leg.hold.contains(work.wanted, 1e-3)
    assert moved


def test_follow(world, work):
    wanted = world.leg.hold.sample(8, 1)
    for q, pose in zip(world.states(8), wanted, strict=True):
        found = q.copy()
        descent.face(world.problem, q, work)
        work.wanted[:] = pose
        descent.follow(world.problem, found, work)
        np.testing.assert_allclose(found, twins.Twin(world).follow(q, pose), atol=1e-9)


@pytest.mark.parametrize("constrained", [True, False])
def test_descend(world, work, constrained):
    twin = twins.Twin(world)
    for q, target in zip(world.states(8), targets(world, 8), strict=True):
        found = q.copy()
        left = descent.descend(world.problem, found, target, constrained, work)
        state, off = twin.descend(q, target, constrained)
        np.testing.assert_allclose(found, state, atol=1e-9)
        assert left == pytest.approx(off)
        np.testing.assert_allclose(work.pose, world.robot.forward(found), atol=1e-12)


def test_problem_at_reads_what_the_question_wrote(world):
    """The loops that take a table see the same problem: one of them answers for it below."""
    assert len(world.table) == 3 * _problem.SLOTS
    numbers = world.question.table.arrays[_problem.NUMBERS]
    np.testing.assert_array_equal(numbers[:3], [world.leg.level, world.leg.goal_level, world.question.margin])
