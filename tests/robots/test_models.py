"""The bundled models against published facts and other people's models."""

import importlib
import json
import math

import mujoco
import numpy as np
import pytest

import skillfold as sf
from robots.oracles import module, package_file
from skillfold.experiments import three_link
from skillfold.experiments.upright import JACO, LWR4, tool_axis
from support import shared

BUNDLED = ("jaco", "lwr4", "nao", "planar_arm")


def rotation(quaternion):
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quaternion, float))
    return matrix.reshape(3, 3)


def dh(theta, d, a, alpha):
    """One step of the standard Denavit-Hartenberg convention."""
    c, s, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
    return np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])


def chain(thetas, table):
    frame = np.eye(4)
    for theta, (d, a, alpha) in zip(thetas, table, strict=True):
        frame = frame @ dh(theta, d, a, alpha)
    return frame


def facts():
    return json.loads(shared("facts/arms_and_objects.json").read_text())


@pytest.mark.parametrize("name", BUNDLED)
def test_home_and_most_random_poses_are_free_of_self_collision(name):
    robot = sf.Robot.load(name)
    assert robot.self_clearance(robot.home) > 0
    assert robot.space.contains(robot.home)
    assert np.mean(robot.self_clearance(robot.sample(3000, seed=1)) > 0) >= 0.8


@pytest.mark.parametrize("name", BUNDLED)
def test_what_planning_needs_is_known(name):
    robot = sf.Robot.load(name)
    assert robot.tool == "tool"
    assert robot.notes == ()
    for limits in (robot.velocity_limits, robot.acceleration_limits, robot.torque_limits):
        assert limits.shape == (robot.dof,)
        assert (limits > 0).all()
        assert np.isfinite(limits).all()


def test_planar_arm_is_the_arm_of_the_reaching_experiments():
    robot = sf.Robot.load("planar_arm")
    q = robot.sample(100)
    pose = robot.forward(q)
    np.testing.assert_allclose(pose[:, :2], three_link.forward(q), atol=1e-14)
    np.testing.assert_allclose(pose[:, 2], 0, atol=1e-15)
    np.testing.assert_allclose(robot.jacobian(q)[:, :2], three_link.jacobian(q), atol=1e-14)


@pytest.mark.parametrize("redundancy", [three_link.REACHING, three_link.WEIGHTED_REACHING])
def test_optimal_reaching_poses_keep_the_planar_arms_limits(redundancy):
    rng = np.random.default_rng(0)
    angle, radius = rng.uniform(0, 2 * np.pi, 500), rng.uniform(0.2, 0.98, 500)
    q = three_link.optimal(radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]), redundancy)
    assert sf.Robot.load("planar_arm").space.contains(q).all()


def test_lwr4_agrees_with_its_published_table():
    robot, table = sf.Robot.load("lwr4"), facts()["kuka_lwr4plus"]
    rows = list(zip(table["d"], table["a"], np.radians(table["alpha_deg"]), strict=True))
    np.testing.assert_allclose(np.degrees(robot.limits.upper), table["limits_deg_from_memory_of_datasheet"])
    for q in robot.sample(50):
        frame, pose = chain(q, rows), robot.forward(q)
        np.testing.assert_allclose(pose[:3], frame[:3, 3], atol=1e-12)
        np.testing.assert_allclose(rotation(pose[3:]), frame[:3, :3], atol=1e-12)


def test_lwr4_and_the_upright_experiment_mean_the_same_arm():
    robot = sf.Robot.load("lwr4")
    q = robot.sample(50)
    axes = np.array([rotation(pose[3:])[:, 2] for pose in robot.forward(q)])
    np.testing.assert_allclose(axes, tool_axis(LWR4, q), atol=1e-12)
    np.testing.assert_allclose(robot.limits, [LWR4.lower, LWR4.upper])


def test_jaco_agrees_with_its_published_distances_and_angles():
    robot, table = sf.Robot.load("jaco"), facts()["jaco2_j2n6s300_dm_control"]
    data = mujoco.MjData(robot.model)
    mujoco.mj_kinematics(robot.model, data)
    gaps = np.linalg.norm(np.diff(data.xanchor, axis=0), axis=1)
    np.testing.assert_allclose(gaps, table["anchor_distances_m"], atol=1e-4)
    assert data.xanchor[0, 2] == pytest.approx(table["base_to_joint1_m"])
    cosines = np.clip(np.sum(data.xaxis[1:] * data.xaxis[:-1], axis=1), -1, 1)
    # A joint's axis has no front: the facts give the angle between lines up to their sense.
    given = np.radians(table["axis_angles_deg"])
    np.testing.assert_allclose(np.abs(cosines), np.abs(np.cos(given)), atol=1e-7)
    for joint, limits in table["limits_rad"].items():
        k = robot.names.index(joint.replace("_", ""))
        np.testing.assert_allclose(np.array(robot.limits)[:, k], limits, atol=1e-4)


def test_jaco_and_the_upright_experiment_mean_the_same_arm():
    robot = sf.Robot.load("jaco")
    q = robot.sample(50)
    axes = np.array([rotation(pose[3:])[:, 2] for pose in robot.forward(q)])
    np.testing.assert_allclose(axes, tool_axis(JACO, q), atol=1e-7)
    assert [kind == "continuous" for kind in robot.space.kinds] == [True, False, False, True, True, True]


def test_jaco_agrees_with_kinovas_table():
    """Kinova's own Denavit-Hartenberg lengths; its joint offsets of 1.6 mm are not in that table."""
    robot = sf.Robot.load("jaco")
    sa, s2a, wrist = math.sin(math.pi / 6), math.sin(math.pi / 3), 0.0741
    lengths = [0.2755, 0, -0.0098, -(0.2073 + sa / s2a * wrist), -2 * sa / s2a * wrist, -(0.16 + sa / s2a * wrist)]
    rows = list(zip(lengths, [0, 0.41, 0, 0, 0, 0], JACO.twist, strict=True))
    for q in robot.sample(50):
        frame = chain(JACO.sign * q + JACO.offset, rows)
        np.testing.assert_allclose(robot.forward(q)[:3], frame[:3, 3], atol=5e-3)


def test_jaco_agrees_with_dm_control():
    file = package_file("dm_control", "third_party/kinova/jaco_arm.xml")
    robot, model = sf.Robot.load("jaco"), mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    for q in robot.sample(50):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        for k in range(6):
            pose = robot.forward(q, f"link{k + 1}")
            np.testing.assert_allclose(pose[:3], data.xanchor[k], atol=1e-6)
            np.testing.assert_allclose(rotation(pose[3:])[:, 2], data.xaxis[k], atol=1e-6)


def test_nao_is_made_of_the_published_joints_and_bodies():
    table = json.loads(shared("facts/nao_h25.json").read_text())
    robot = sf.Robot.load("nao")
    model = robot.model
    assert set(robot.names) == {joint["name"] for joint in table["joints"]}
    for joint in table["joints"]:
        k = model.joint(joint["name"]).id
        body = model.jnt_bodyid[k]
        np.testing.assert_allclose(model.body_pos[body], joint["xyz"])
        np.testing.assert_allclose(model.jnt_axis[k], joint["axis"], atol=2e-6)
        np.testing.assert_allclose(model.jnt_range[k], joint["range"])
        assert model.body(model.body_parentid[body]).name.removesuffix("Link") == joint["parent"]
    for name, body in table["bodies"].items():
        k = model.body(name if name == "Torso" else f"{name}Link").id
        turned = rotation(model.body_iquat[k])
        np.testing.assert_allclose(model.body_mass[k], body["mass"])
        np.testing.assert_allclose(model.body_ipos[k], body["com"], atol=1e-12)
        inertia = turned @ np.diag(model.body_inertia[k]) @ turned.T
        np.testing.assert_allclose(inertia, body["inertia_about_com"], atol=1e-10)


def test_naos_soles_stand_on_its_sensors_and_its_hips_share_a_motor():
    robot = sf.Robot.load("nao")
    assert robot.couplings == {"RHipYawPitch": "LHipYawPitch"}
    assert robot.floating
    flat = np.clip(np.zeros(robot.dof), *robot.limits)
    for side, y in (("l", 0.05), ("r", -0.05)):
        sole = robot.forward(flat, f"{side}_sole")
        np.testing.assert_allclose(sole[:3], [0, y, -0.085 - 0.1 - 0.1029 - 0.04511], atol=1e-12)


def test_naos_center_of_mass_agrees_with_pinocchio():
    file = package_file("qibullet", "robot_data/nao.urdf")
    pin = module("pinocchio")
    # On a free base: Pinocchio leaves out what is fixed to the world, here the torso.
    model = pin.buildModelFromUrdf(str(file), pin.JointModelFreeFlyer())
    data, robot = model.createData(), sf.Robot.load("nao")
    where = [model.joints[model.getJointId(name)].idx_q for name in robot.names]
    worst = 0.0
    for q in robot.sample(200):
        state = pin.neutral(model)
        state[where] = q
        pin.forwardKinematics(model, data, state)
        pin.updateFramePlacements(model, data)
        torso = data.oMf[model.getFrameId("torso")]
        wanted = torso.actInv(pin.centerOfMass(model, data, state))
        worst = max(worst, float(np.abs(robot.center_of_mass(q) - wanted).max()))
    assert worst < 1e-9


def test_every_model_is_in_the_package():
    names = {file.name for file in importlib.resources.files("skillfold.robots").joinpath("models").iterdir()}
    assert {f"{name}.xml" for name in BUNDLED} <= names
