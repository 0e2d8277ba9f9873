"""`Robot`: what it answers, whatever the batch, the base and the thread."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skillfold as sf
from skillfold.errors import InputError, SkillfoldError
from skillfold.robots import kinematics

NAMES = st.sampled_from(["jaco", "lwr4", "nao", "planar_arm"])
LAWS = settings(max_examples=30, deadline=None)


def rotation(quaternion):
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quaternion, float))
    return matrix.reshape(3, 3)


def plain(robot, q):
    """MuJoCo's own data at q: the twin of the compiled loops."""
    data = mujoco.MjData(robot.model)
    if robot.floating:
        data.qpos[:7] = 0, 0, 0, 1, 0, 0, 0
    for name, value in zip(robot.names, robot.couple(q), strict=True):
        data.qpos[robot.model.joint(name).qposadr[0]] = value
    mujoco.mj_kinematics(robot.model, data)
    mujoco.mj_comPos(robot.model, data)
    return data


@given(name=NAMES, seed=st.integers(0, 999), pick=st.integers(0, 999))
@LAWS
def test_poses_jacobians_and_centers_are_mujocos(robots, name, seed, pick):
    robot = robots[name]
    q, frame = robot.sample(1, seed)[0], robot.frames[pick % len(robot.frames)]
    data, model = plain(robot, q), robot.model
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, frame)
    body = int(model.site_bodyid[site]) if site >= 0 else model.body(frame).id
    place = data.site_xpos[site] if site >= 0 else data.xpos[body]
    turned = data.site_xmat[site] if site >= 0 else data.xmat[body]
    pose = robot.forward(q, frame)
    np.testing.assert_allclose(pose[:3], place, atol=1e-12)
    np.testing.assert_allclose(rotation(pose[3:]), turned.reshape(3, 3), atol=1e-12)
    np.testing.assert_allclose(robot.center_of_mass(q), data.subtree_com[0], atol=1e-12)
    linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, linear, angular, pose[:3], body)
    columns = np.zeros((6, robot.dof))
    for name in robot.names:
        leader = robot.names.index(robot.couplings.get(name, name))
        dof = model.joint(name).dofadr[0]
        columns[:, leader] += np.concatenate([linear[:, dof], angular[:, dof]])
    np.testing.assert_allclose(robot.jacobian(q, frame), columns, atol=1e-12)


@given(name=NAMES, seed=st.integers(0, 999), turned=st.booleans())
@LAWS
def test_jacobian_is_the_derivative_of_forward(robots, name, seed, turned):
    robot = robots[name]
    q, h = robot.sample(1, seed)[0], 1e-6
    base = np.array([0.3, -0.2, 0.5, 0.5, -0.5, 0.5, 0.5]) if turned else None
    steps = h * np.eye(robot.dof)
    ahead, behind = robot.forward(q + steps, base=base), robot.forward(q - steps, base=base)
    J = robot.jacobian(q, base=base)
    np.testing.assert_allclose(J[:3], (ahead - behind)[:, :3].T / (2 * h), atol=1e-7)
    for k in range(robot.dof):
        spin = rotation(ahead[k, 3:]) @ rotation(behind[k, 3:]).T / (2 * h)
        spin = (spin - spin.T) / 2
        np.testing.assert_allclose(J[3:, k], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-7)


@given(name=NAMES, shape=st.sampled_from([(), (1,), (3,), (2, 3), (0,), (2, 0)]))
@LAWS
def test_any_batch_shape_comes_back(robots, name, shape):
    robot = robots[name]
    q = robot.sample(max(int(np.prod(shape)), 1))[: int(np.prod(shape))].reshape(*shape, robot.dof)
    assert robot.forward(q).shape == (*shape, 7)
    assert robot.jacobian(q).shape == (*shape, 6, robot.dof)
    assert robot.center_of_mass(q).shape == (*shape, 3)
    assert np.shape(robot.self_clearance(q)) == shape
    flat = q.reshape(-1, robot.dof)
    single = [robot.forward(one) for one in flat]
    np.testing.assert_array_equal(robot.forward(q).reshape(-1, 7), np.reshape(single, (-1, 7)))


def test_a_base_carries_everything(nao):
    q = nao.sample(4)
    base = np.array([[0.1, 0.2, 0.3, 0.5, 0.5, -0.5, 0.5]] * 4)
    turned = rotation(base[0, 3:])
    np.testing.assert_allclose(nao.forward(q, base=base)[:, :3], nao.forward(q)[:, :3] @ turned.T + base[:, :3])
    np.testing.assert_allclose(nao.center_of_mass(q, base), nao.center_of_mass(q) @ turned.T + base[:, :3])
    np.testing.assert_allclose(nao.forward(q, "Torso", base), base, atol=1e-12)
    np.testing.assert_allclose(nao.forward(q, base=base[0, :3])[:, 3:], nao.forward(q)[:, 3:])


def test_followers_follow_and_their_own_place_is_not_looked_at(nao):
    q = nao.sample(5)
    follower, leader = (nao.names.index(name) for name in ("RHipYawPitch", "LHipYawPitch"))
    np.testing.assert_array_equal(q[:, follower], q[:, leader])
    other = q.copy()
    other[:, follower] = 0.1
    np.testing.assert_array_equal(nao.forward(other, "r_sole"), nao.forward(q, "r_sole"))
    np.testing.assert_array_equal(nao.couple(other), q)
    assert not nao.jacobian(q, "r_sole")[..., follower].any()
    assert nao.jacobian(q, "r_sole")[..., leader].any()


def test_wrap_touches_joints_that_turn_without_end_alone(robots):
    robot = robots["jaco"]
    q = robot.sample(5)
    far = q + 2 * np.pi * np.array([1, 0, 0, -2, 1, 3])
    np.testing.assert_allclose(robot.wrap(far), q, atol=1e-12)
    for one, other in zip(robot.forward(far), robot.forward(q), strict=True):
        np.testing.assert_allclose(rotation(one[3:]), rotation(other[3:]), atol=1e-12)


def test_samples_keep_limits_and_seeds(robots):
    for robot in robots.values():
        q = robot.sample(200, 3)
        assert robot.space.contains(q).all()
        np.testing.assert_array_equal(q, robot.sample(200, 3))
        assert np.asarray(robot.limits).shape == (2, robot.dof)


def test_what_it_hands_out_is_not_its_own(lwr4):
    lwr4.home[:] = 9
    lwr4.limits.lower[:] = 9
    lwr4.torque_limits[:] = 9
    assert lwr4.home[1] == pytest.approx(-np.pi / 6)
    assert lwr4.limits.lower[0] < 0
    assert lwr4.torque_limits[0] == 176


def test_lwr4_home_points_the_tool_down(lwr4):
    assert rotation(lwr4.forward(lwr4.home)[3:])[2, 2] == pytest.approx(-1)
    assert lwr4.forward(lwr4.home)[0] > 0.4


def test_repr_says_what_it_is(lwr4, nao):
    assert repr(lwr4) == "Robot(lwr4: 7 joints, tool frame 'tool')"
    assert repr(nao) == "Robot(nao: 24 joints, floating base, tool frame 'tool')"


@pytest.mark.parametrize(
    ("q", "message"),
    [
        (np.zeros(6), r"lwr4: joint positions of shape \(6,\); expected \(\.\.\., 7\)"),
        (0.0, r"shape \(\); expected \(\.\.\., 7\)"),
        ("home", "must be numbers"),
        ([[0.0] * 7, [0, 0, 0, np.nan, 0, 0, 0]], "joint 3 of state 1 is nan"),
        ([np.inf] + [0.0] * 6, "joint 0 of state 0 is inf"),
        ([[1, 2], [3]], "must be numbers"),
    ],
)
def test_bad_joint_positions_say_what_is_wrong(lwr4, q, message):
    for ask in (lwr4.forward, lwr4.jacobian, lwr4.center_of_mass, lwr4.self_clearance, lwr4.wrap, lwr4.couple):
        with pytest.raises(InputError, match=message):
            ask(q)


def test_unknown_frames_and_bases_say_what_there_is(lwr4):
    with pytest.raises(InputError, match=r"no frame 'hand'; possible: tool, base, link1"):
        lwr4.forward(lwr4.home, "hand")
    with pytest.raises(InputError, match=r"no frame 3"):
        lwr4.jacobian(lwr4.home, 3)
    with pytest.raises(InputError, match=r"quaternion .* of length 0"):
        lwr4.forward(lwr4.home, base=[0, 0, 0, 0, 0, 0, 0])
    with pytest.raises(InputError, match=r"base: shape \(5,\)"):
        lwr4.forward(lwr4.home, base=np.zeros(5))
    for ask in (lwr4.forward, lwr4.jacobian, lwr4.center_of_mass):
        with pytest.raises(InputError, match=r"batch shape \(4,\), joint positions of \(3,\)"):
            ask(np.zeros((3, 7)), base=np.zeros((4, 3)))


@pytest.mark.parametrize(("count", "seed"), [(-1, 0), (2.5, 0), ("two", 0), (2, -1), (2, "x"), (True, 0)])
def test_samples_that_cannot_be_drawn_are_told(planar, count, seed):
    with pytest.raises(InputError, match="expected a whole number"):
        planar.sample(count, seed)


def test_threads_each_have_their_own_data(lwr4):
    q = lwr4.sample(4000, 1)
    wanted = lwr4.forward(q), lwr4.self_clearance(q), lwr4.jacobian(q)

    def ask(_):
        return lwr4.forward(q), lwr4.self_clearance(q), lwr4.jacobian(q)

    with ThreadPoolExecutor(4) as pool:
        for answers in pool.map(ask, range(8)):
            for answer, right in zip(answers, wanted, strict=True):
                np.testing.assert_array_equal(answer, right)


def test_pickled_robots_are_loaded_anew(nao):
    again = pickle.loads(pickle.dumps(nao))
    assert again.names == nao.names
    np.testing.assert_array_equal(again.forward(nao.home), nao.forward(nao.home))


def test_the_specification_is_a_copy_to_build_on(lwr4):
    spec = lwr4.spec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.1, 0, 0])
    assert spec.compile().ngeom == lwr4.spec().compile().ngeom + 1


def test_slots_of_the_tables_are_different():
    slots = [v for name, v in vars(kinematics).items() if name.isupper() and name != "SLOTS" and isinstance(v, int)]
    assert sorted(slots) == list(range(kinematics.SLOTS))


def test_errors_are_of_the_one_root():
    with pytest.raises(SkillfoldError):
        sf.Robot.load("none")
