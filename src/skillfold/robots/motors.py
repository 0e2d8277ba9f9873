"""The largest torques of a model's joints, from their own limits and those of the motors that act on them."""

import math
from typing import Any

import numpy as np

from skillfold.robots.engine import mujoco
from skillfold.tables import Array, Indices

_AT_JOINTS = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
_ENDLESS = np.array([-math.inf, math.inf])


def torque_limits(model: Any, numbers: Indices) -> Array:
    """(dof,) largest torque in either direction of joints with these numbers (dof,); infinite where unknown.

    Motors that act on one joint add up, such as those that can only pull.
    """
    limited = model.jnt_actfrclimited[numbers].astype(bool)
    torque = np.where(limited, _least(model.jnt_actfrcrange[numbers]), math.inf)
    at_joints = np.isin(model.actuator_trntype, [int(kind) for kind in _AT_JOINTS])
    for k, number in enumerate(numbers):
        motors = np.flatnonzero(at_joints & (model.actuator_trnid[:, 0] == number))
        if len(motors):
            torque[k] = min(torque[k], float(_least(sum(_forces(model, int(i)) for i in motors))))
    return torque


def _least(ranges: Any) -> Array:
    """What ranges (..., 2) hold in either direction; nothing where they leave out zero."""
    return np.maximum(np.minimum(-ranges[..., 0], ranges[..., 1]), 0.0)


def _forces(model: Any, motor: int) -> Array:
    """(2,) least and greatest torque of a motor at its joint: within its limits, and those of its commands."""
    low, high = model.actuator_forcerange[motor] if model.actuator_forcelimited[motor] else _ENDLESS
    if model.actuator_ctrllimited[motor] and _plain(model, motor):
        asked = np.sort(model.actuator_gainprm[motor, 0] * model.actuator_ctrlrange[motor])
        low, high = max(low, asked[0]), min(high, asked[1])
    gear = model.actuator_gear[motor, 0]
    return np.sort(np.array([low, high]) * gear) if gear else np.zeros(2)


def _plain(model: Any, motor: int) -> bool:
    """Whether its force is its command, times a gain."""
    kinds = model.actuator_dyntype[motor], model.actuator_gaintype[motor], model.actuator_biastype[motor]
    return kinds == (mujoco.mjtDyn.mjDYN_NONE, mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_NONE)
