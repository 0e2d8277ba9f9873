"""The Numba loop of inverse dynamics; `m` is a table as in `kinematics`, with the slots below after its own."""

import numpy as np

from skillfold.jit import njit
from skillfold.robots import kinematics as kin
from skillfold.robots.kinematics import place
from skillfold.robots.mujoco_calls import com_pos, com_vel, newton_euler, passive
from skillfold.tables import Array, Indices, address, indices, scalar, vector

QVEL, QACC = kin.SLOTS, kin.SLOTS + 1  # (nv,) MuJoCo's, overwritten
DOFS = kin.SLOTS + 2  # (K,) of each joint in them
ARMATURE = kin.SLOTS + 3  # (K,)
PASSIVE = kin.SLOTS + 4  # (nv,) MuJoCo's: what springs, dampers and compensated gravity do by themselves
FORCES = kin.SLOTS + 5  # (nv,) scratch
SLOTS = kin.SLOTS + 6


@njit
def inverse(q: Array, qd: Array, qdd: Array, m: Indices, out: Array) -> None:
    """Torques (dof,) that give accelerations qdd at positions q and velocities qd, all (dof,)."""
    dofs, columns, ratios = indices(m, DOFS), indices(m, kin.COLUMNS), vector(m, kin.RATIOS)
    speed, rise, forces = vector(m, QVEL), vector(m, QACC), vector(m, FORCES)
    armature, helping = vector(m, ARMATURE), vector(m, PASSIVE)
    model, data = scalar(m, kin.MODEL), scalar(m, kin.DATA)
    place(q, m)
    for k in range(dofs.size):
        speed[dofs[k]] = ratios[k] * qd[columns[k]]
        rise[dofs[k]] = ratios[k] * qdd[columns[k]]
    com_pos(model, data)
    com_vel(model, data)
    passive(model, data)
    newton_euler(model, data, np.int32(1), address(m, FORCES))
    for k in range(dofs.size):
        i = dofs[k]
        out[k] = forces[i] + armature[k] * rise[i] - helping[i]


@njit
def inverses(states: Array, speeds: Array, rises: Array, m: Indices, out: Array) -> None:
    """The same for (n, dof)."""
    for i in range(len(states)):
        inverse(states[i], speeds[i], rises[i], m, out[i])
