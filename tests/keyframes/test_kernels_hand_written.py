"""Kernels of hand-written constraints against SciPy's rotations."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keyframes.envelopes import random_poses
from manifold.kernels import callable_of
from skillfold.keyframes import compiled
from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.kernels import hand_written as _hand_written
from skillfold.tables import table_of

hand_written = callable_of(_hand_written)


def of(quaternion):
    return Rotation.from_quat(quaternion, scalar_first=True)


def unit(rng, count=3):
    vector = rng.normal(size=count)
    return vector / np.linalg.norm(vector)


def test_three_four_cross_product_turned_and_perpendicular():
    rng = np.random.default_rng(0)
    for _ in range(20):
        a, b, v = unit(rng, 4), unit(rng, 4), unit(rng)
        assert hand_written.three(a, 1) == tuple(a[1:])
        assert hand_written.four(a, 0) == tuple(a)
        np.testing.assert_allclose(hand_written.cross(tuple(v), tuple(a[:3])), np.cross(v, a[:3]), atol=1e-15)
        turn = of(hand_written.product(tuple(a), tuple(b)))
        np.testing.assert_allclose(turn.as_matrix(), (of(a) * of(b)).as_matrix(), atol=1e-14)
        np.testing.assert_allclose(hand_written.turned(tuple(a), tuple(v)), of(a).apply(v), atol=1e-14)
        level = hand_written.perpendicular(tuple(v))
        assert (np.dot(level, v), np.linalg.norm(level)) == pytest.approx((0, 1), abs=1e-15)
    assert hand_written.perpendicular((1.0, 0.0, 0.0))[0] == 0


def test_write():
    out = np.empty(7)
    hand_written.write((1.0, 2.0, 3.0), (4.0, 5.0, 6.0, 7.0), out)
    assert out.tolist() == [1, 2, 3, 4, 5, 6, 7]


def test_angles_and_of_angles():
    rng = np.random.default_rng(1)
    for _ in range(50):
        roll, pitch, yaw = rng.uniform([-math.pi, -1.5, -math.pi], [math.pi, 1.5, math.pi])
        q = np.array(hand_written.of_angles(roll, pitch, yaw))
        np.testing.assert_allclose(
            of(q).as_matrix(), Rotation.from_euler("xyz", [roll, pitch, yaw]).as_matrix(), atol=1e-14
        )
        for same in (q, -q):
            np.testing.assert_allclose(hand_written.angles(tuple(same)), [roll, pitch, yaw], atol=1e-13)


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
def test_angles_at_a_pitch_of_90_degrees(pitch):
    """Roll and yaw are not told apart there; the turn is kept all the same."""
    for roll, yaw in ((0.4, -1.1), (3.0, 2.0), (0.0, 0.0)):
        q = hand_written.of_angles(roll, pitch, yaw)
        again = of(hand_written.of_angles(*hand_written.angles(q)))
        assert (again.inv() * of(q)).magnitude() < 1e-7


def test_bounded_angle_bounded_and_angles_bounded():
    assert hand_written.bounded(3.0, -1.0, 2.0) == (2.0, 1.0)
    assert hand_written.angle_bounded(0.5 + 2 * math.pi, 0.0, 1.0) == pytest.approx((0.5, 0))
    assert hand_written.angle_bounded(-3.0, 2.0, 3.0) == pytest.approx((3.0, 2 * math.pi - 6))
    assert hand_written.angle_bounded(17.0, 3.0, 3.0 + 2 * math.pi) == pytest.approx((17 - 4 * math.pi, 0))
    found = hand_written.angles_bounded(0.2, -0.5, 3.0, (-0.1, -0.1, 0.0), (0.1, 0.1, 4.0))
    assert found == pytest.approx((0.1, -0.1, 3.0, 0.1**2 + 0.4**2))


def region_twin(pose, values):
    """How far the six numbers are off their bounds: over whole turns, and both sets of angles."""
    frame, back = (values[:3], of(values[3:7])), (values[7:10], of(values[10:14]))
    turn = frame[1].inv() * of(pose[3:]) * back[1]
    position = frame[1].inv().apply(pose[:3] + of(pose[3:]).apply(back[0]) - frame[0])
    r, p, y = turn.as_euler("xyz")
    whole = 2 * np.pi * np.arange(-2, 3)[:, None]
    best = np.inf
    for angles in ((r, p, y), (r + np.pi, np.pi - p, y + np.pi)):
        every = np.array(angles) + whole
        off = np.abs(every - np.clip(every, values[17:20], values[23:26])).min(0)
        best = min(best, np.linalg.norm(off))
    off = position - np.clip(position, values[14:17], values[20:23])
    return np.hypot(np.linalg.norm(off), LENGTH * best)


def random_region(rng):
    lower = rng.normal(size=6) * [0.1, 0.1, 0.1, 1, 1, 1]
    upper = lower + rng.uniform(0, 1, 6) * [0.2, 0.2, 0, 1, 0, 5]
    return np.concatenate([*random_poses(2, rng), lower, upper, [0.002]])


def test_nearest_bounded():
    rng = np.random.default_rng(2)
    for _ in range(40):
        values, pose = random_region(rng), random_poses(1, rng)[0]
        *inside, off = hand_written.nearest_bounded(pose, values)
        assert off == pytest.approx(region_twin(pose, values), rel=1e-12)
        assert (np.array(inside) >= values[14:20]).all()
        assert (np.array(inside) <= values[20:26]).all()


def arguments_of(values):
    table = table_of({0: np.asarray(values, float)}, 1)
    return table, table.entries


@pytest.mark.parametrize("name", ["upright", "plane", "region"])
def test_excesses_and_projections(name):
    """Through pointers, as planners call them: `upright_excess(`, `plane_excess(`, `region_excess(` and the rest."""
    rng = np.random.default_rng(3)
    poses = random_poses(40, rng)
    axis, up, normal = unit(rng), unit(rng), unit(rng)
    region = random_region(rng)
    tilt = np.arccos(of(poses[:, 3:]).apply(axis) @ up)
    values, wanted = {
        "upright": ([*axis, *up, 0.1], LENGTH * (tilt - 0.1)),
        "plane": ([0.2, *normal, 0.01], np.abs(poses[:, :3] @ normal - 0.2) - 0.01),
        "region": (region, [region_twin(pose, region) - 0.002 for pose in poses]),
    }[name]
    keep, arguments = arguments_of(values)
    excess, project = getattr(compiled, f"{name}_functions")()
    found, out = np.empty(len(poses)), np.empty_like(poses)
    hand_written.excesses(excess, poses, arguments, found)
    np.testing.assert_allclose(found, wanted, atol=1e-12)
    hand_written.projections(project, poses, arguments, out)
    hand_written.excesses(excess, out, arguments, found)
    exact = -values[-1] * (LENGTH if name == "upright" else 1)
    np.testing.assert_allclose(found, np.where(np.array(wanted) > 0, exact, wanted), atol=1e-10)
    assert keep is not None


def test_projections_go_the_shortest_way():
    """They move poses by as much as those were off: `upright_project(`, `plane_project(` and `region_project(`."""
    rng = np.random.default_rng(4)
    for _ in range(20):
        pose, axis, up, normal, out = random_poses(1, rng)[0], unit(rng), unit(rng), unit(rng), np.empty(7)
        table, arguments = arguments_of([*axis, *up, 0.1])
        excess = hand_written.upright_project(pose, out, arguments)
        assert excess == hand_written.upright_excess(pose, arguments)
        turned = (of(out[3:]) * of(pose[3:]).inv()).magnitude()
        assert turned == pytest.approx(excess / LENGTH + 0.1 if excess > 0 else 0, abs=1e-12)
        table, arguments = arguments_of([0.2, *normal, 0.01])
        excess = hand_written.plane_project(pose, out, arguments)
        assert excess == hand_written.plane_excess(pose, arguments)
        assert np.linalg.norm(out[:3] - pose[:3]) == pytest.approx(excess + 0.01 if excess > 0 else 0, abs=1e-12)
        table, arguments = arguments_of(random_region(rng))
        assert hand_written.region_project(pose, out, arguments) == hand_written.region_excess(pose, arguments)
        assert hand_written.region_excess(out, arguments) == pytest.approx(-0.002, abs=1e-12)
        assert table is not None


def test_upright_of_an_axis_that_points_straight_down():
    _, arguments = keep = arguments_of([0, 0, 1, 0, 0, 1, 0.1])
    pose, out = np.array([0, 0, 0, 0, 1.0, 0, 0]), np.empty(7)
    assert hand_written.upright_project(pose, out, arguments) == pytest.approx(LENGTH * (math.pi - 0.1))
    assert hand_written.upright_excess(out, arguments) == pytest.approx(-LENGTH * 0.1)
    assert keep is not None
