"""Torque limits: what MuJoCo's own actuators can do at their commands' ends."""

import mujoco
import numpy as np
import pytest

import skillfold as sf

ARM = """<mujoco><option gravity="0 0 0"/><worldbody><body>
<joint name="a" axis="0 0 1" {joint}/><geom size=".1" pos="1 0 0"/></body></worldbody>
<actuator>{motors}</actuator></mujoco>"""


def robot(tmp_path, motors, joint=""):
    file = tmp_path / "arm.xml"
    file.write_text(ARM.format(motors=motors, joint=joint))
    return sf.Robot.load(file)


def strongest(robot):
    """Torque in the weaker direction, over commands at their limits or far out."""
    model = robot.spec().compile()
    data, found = mujoco.MjData(model), []
    for corner in np.array(np.meshgrid(*[[-1e6, 1e6]] * model.nu)).reshape(model.nu, -1).T:
        data.ctrl[:] = corner
        mujoco.mj_forward(model, data)
        found.append(data.qfrc_actuator[0])
    return min(-min(found), max(found))


@pytest.mark.parametrize(
    "motors",
    [
        '<motor joint="a" gear="50" ctrlrange="-1 1"/>',
        '<motor joint="a" gear="-2" ctrlrange="-20 30"/>',
        '<motor joint="a" ctrlrange="-20 20" forcerange="-5 5"/>',
        '<position joint="a" kp="100" forcerange="-30 30"/>',
        '<motor joint="a" ctrlrange="-3 3"/><position joint="a" kp="9" forcerange="-4 4"/>',
        '<general joint="a" forcerange="0 5"/><general joint="a" forcerange="-9 0"/>',
        '<general joint="a" gainprm="-3" ctrlrange="-2 1"/>',
    ],
)
def test_torques_are_what_the_motors_can(tmp_path, motors):
    arm = robot(tmp_path, motors)
    assert arm.torque_limits[0] == pytest.approx(strongest(arm))


def test_the_joints_own_limit_counts_too(tmp_path):
    motor = '<motor joint="a" ctrlrange="-20 20"/>'
    assert robot(tmp_path, motor, 'actuatorfrcrange="-7 8"').torque_limits[0] == 7


@pytest.mark.parametrize("motors", ["", '<motor joint="a"/>', '<position joint="a" kp="100" ctrlrange="-1 1"/>'])
def test_motors_without_limits_have_none(tmp_path, motors):
    assert np.isinf(robot(tmp_path, motors).torque_limits[0])
