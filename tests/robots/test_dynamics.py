"""Inverse dynamics against MuJoCo's own, and against laws of mechanics."""

import mujoco
import numpy as np
import pytest

import skillfold as sf
from skillfold.errors import InputError

NAMES = ("jaco", "lwr4", "planar_arm")


def motion(robot, seed, count=5):
    """Positions, velocities and accelerations that keep to the robot's couplings."""
    rng = np.random.default_rng(seed)
    columns, ratios = robot.joints.columns, robot.joints.ratios
    speeds, rises = (ratios * rng.normal(size=(count, robot.dof))[:, columns] for _ in range(2))
    return robot.sample(count, seed), speeds, rises


@pytest.mark.parametrize("name", NAMES)
def test_torques_are_mujocos(robots, name):
    robot = robots[name]
    model = robot.spec().compile()
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    data, dofs = mujoco.MjData(model), model.jnt_dofadr[robot.joints.numbers]
    for q, qd, qdd in zip(*motion(robot, 0), strict=True):
        data.qpos[robot.joints.addresses], data.qvel[dofs], data.qacc[dofs] = q, qd, qdd
        mujoco.mj_inverse(model, data)
        assert np.allclose(robot.dynamics().torque(q, qd, qdd), data.qfrc_inverse[dofs], atol=1e-9)


HELPED = """<mujoco><compiler angle="radian"/><worldbody>
<body gravcomp="1"><joint name="a" axis="0 1 0" damping="2" armature="0.1"/>
<geom type="box" size=".2 .02 .02" pos=".2 0 0"/>
<body name="tool" pos=".4 0 0" gravcomp=".5"><joint name="b" axis="0 1 0" stiffness="3" springref=".5"/>
<geom type="box" size=".2 .02 .02" pos=".2 0 0"/></body></body></worldbody>
<tendon><fixed name="t" stiffness="5" damping="2"><joint joint="a" coef="1"/></fixed></tendon></mujoco>"""


def test_springs_and_compensated_gravity_are_mujocos(tmp_path):
    """What the robot does by itself is not asked for again; tendons are left out."""
    file = tmp_path / "helped.xml"
    file.write_text(HELPED)
    robot = sf.Robot.load(file)
    model = mujoco.MjModel.from_xml_string(HELPED)
    model.tendon_stiffness[:] = model.tendon_damping[:] = 0.0
    data = mujoco.MjData(model)
    for q, qd, qdd in zip(*motion(robot, 4), strict=True):
        data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
        mujoco.mj_inverse(model, data)
        assert np.allclose(robot.dynamics().torque(q, qd, qdd), data.qfrc_inverse, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_mass_matrix_and_bias_make_up_the_torque(robots, name):
    dynamics = robots[name].dynamics()
    q, qd, qdd = motion(robots[name], 1)
    mass = dynamics.mass_matrix(q)
    assert np.array_equal(mass, mass.swapaxes(1, 2)) and (np.linalg.eigvalsh(mass) > 0).all()
    whole = np.einsum("nij,nj->ni", mass, qdd) + dynamics.bias(q, qd)
    assert np.allclose(dynamics.torque(q, qd, qdd), whole, atol=1e-9)


def test_a_load_weighs_what_it_weighs(lwr4):
    q, still = lwr4.sample(6, 2), np.zeros(7)
    center = np.array([0.02, -0.01, 0.05])
    more = lwr4.dynamics(2.0, center).bias(q, still) - lwr4.dynamics().bias(q, still)
    for i, joints in enumerate(q):
        # The force that carries it, through the Jacobian of its centre by differences of forward kinematics.
        step = 1e-6 * np.eye(7)
        height = [_height(lwr4, joints + d, center) - _height(lwr4, joints - d, center) for d in step]
        assert np.allclose(more[i], 2.0 * 9.81 * np.array(height) / 2e-6, atol=1e-5)


def _height(robot, q, center):
    z, w, a, b, c = robot.forward(q)[2:]
    row = np.array([2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)])
    return z + row @ center


def test_the_compiled_form_says_the_same(lwr4):
    q, qd, qdd = (part[0] for part in motion(lwr4, 3))
    dynamics = lwr4.dynamics()
    compiled, out = dynamics.compiled(), np.empty(7)
    assert compiled.inverse.address
    from skillfold.robots.inverse import inverse, inverses

    inverse(q, qd, qdd, compiled.arguments, out)
    assert np.array_equal(out, dynamics.torque(q, qd, qdd))
    rows = np.empty((1, 7))
    inverses(q[None], qd[None], qdd[None], compiled.arguments, rows)
    assert np.array_equal(rows[0], out)


def test_what_cannot_be_answered_is_told(lwr4):
    with pytest.raises(InputError):
        lwr4.dynamics().torque(np.zeros(6), np.zeros(6), np.zeros(6))
    with pytest.raises(InputError):
        lwr4.dynamics().bias(np.full(7, np.nan), np.zeros(7))
    with pytest.raises(InputError, match="kilograms"):
        lwr4.dynamics(-1.0)
    with pytest.raises(InputError, match="kilograms"):
        lwr4.dynamics("heavy")
    with pytest.raises(InputError, match="do not go together"):
        lwr4.dynamics().torque(np.zeros((2, 7)), np.zeros((3, 7)), np.zeros(7))
    with pytest.raises(InputError, match="must be numbers"):
        lwr4.dynamics().mass_matrix("home")
