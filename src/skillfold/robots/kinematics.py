"""The Numba loops over poses of a robot: forward kinematics, Jacobians, centre of mass.

`m` is a table (see `tables`) of a robot's model, one `MjData` of it, and how joint positions q enter. Pure functions
but for that data, which they overwrite: one table per thread. The tests hold a plain twin of each.
"""

from typing import NamedTuple

import numpy as np

from skillfold.jit import inner, njit
from skillfold.robots.mujoco_calls import kinematics
from skillfold.tables import Array, Indices, index_matrix, indices, matrix, scalar, vector

MODEL, DATA = 0, 1  # their addresses
QPOS, REST = 2, 3  # (nq,) MuJoCo's positions, overwritten from all that q does not tell, and from q
PLACES = 4  # (K,) of each joint in qpos
COLUMNS, OFFSETS, RATIOS = 5, 6, 7  # (K,) joint k stands at offset + ratio · q[column]: its own, or its leader's
JOINTS, SLIDES = 8, 9  # (K,) MuJoCo's number of each, and whether it is prismatic
MOVES = 10  # (n_bodies, K) whether joint k moves the body
XANCHOR, XAXIS = 11, 12  # (n_joints, 3) in the world
XPOS, XQUAT, XIPOS = 13, 14, 15  # (n_bodies, 3 or 4) in the world: frames and centres of mass
MASSES = 16  # (n_bodies,) of what belongs to the robot
SLOTS = 17


class Tool(NamedTuple):
    """A frame of a robot for compiled loops.

    Attributes:
        machine: table of the robot.
        body: that the frame is fixed to.
        offset, turn: (3,), (4,) its place in it.
    """

    machine: Indices
    body: int
    offset: Array
    turn: Array


@inner
def place(q: Array, m: Indices) -> None:
    """Bring the robot to joint positions q (dof,)."""
    qpos, rest, places = vector(m, QPOS), vector(m, REST), indices(m, PLACES)
    columns, offsets, ratios = indices(m, COLUMNS), vector(m, OFFSETS), vector(m, RATIOS)
    for i in range(rest.size):
        qpos[i] = rest[i]
    for k in range(places.size):
        qpos[places[k]] = offsets[k] + ratios[k] * q[columns[k]]
    kinematics(scalar(m, MODEL), scalar(m, DATA))


@inner
def add_motion(m: Indices, k: int, point: Array, scale: float, out: Array) -> None:
    """Add to `out` (3,) `scale` times the velocity of a point that joint k moves at unit speed."""
    joint = indices(m, JOINTS)[k]
    axis, anchor = matrix(m, XAXIS), matrix(m, XANCHOR)
    x, y, z = axis[joint, 0], axis[joint, 1], axis[joint, 2]
    if indices(m, SLIDES)[k]:
        out[0] += scale * x
        out[1] += scale * y
        out[2] += scale * z
        return
    a, b, c = point[0] - anchor[joint, 0], point[1] - anchor[joint, 1], point[2] - anchor[joint, 2]
    out[0] += scale * (y * c - z * b)
    out[1] += scale * (z * a - x * c)
    out[2] += scale * (x * b - y * a)


@inner
def frame_point(m: Indices, body: int, offset: Array, out: Array) -> None:
    """World position of the point `offset` (3,) of a body's frame."""
    position, turn = matrix(m, XPOS), matrix(m, XQUAT)
    w, x, y, z = turn[body, 0], turn[body, 1], turn[body, 2], turn[body, 3]
    a, b, c = offset[0], offset[1], offset[2]
    # Twice axis × offset, then the usual rotation by a quaternion.
    d, e, f = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    out[0] = position[body, 0] + a + w * d + y * f - z * e
    out[1] = position[body, 1] + b + w * e + z * d - x * f
    out[2] = position[body, 2] + c + w * f + x * e - y * d


@inner
def frame_pose(m: Indices, body: int, offset: Array, turn: Array, out: Array) -> None:
    """Pose (7,) of the frame at `offset` (3,), `turn` (4,) of a body, where the robot was placed."""
    turned = matrix(m, XQUAT)
    e, f, g, h = turn[0], turn[1], turn[2], turn[3]
    frame_point(m, body, offset, out)
    w, x, y, z = turned[body, 0], turned[body, 1], turned[body, 2], turned[body, 3]
    out[3] = w * e - x * f - y * g - z * h
    out[4] = w * f + x * e + y * h - z * g
    out[5] = w * g - x * h + y * e + z * f
    out[6] = w * h + x * g - y * f + z * e


@inner
def frame_jacobian(m: Indices, body: int, point: Array, out: Array) -> None:
    """Add to `out` (6, dof) how joints move a point (3,) of a body: linear rows, then angular ones."""
    moves, columns, ratios = index_matrix(m, MOVES), indices(m, COLUMNS), vector(m, RATIOS)
    joints, slides, axis = indices(m, JOINTS), indices(m, SLIDES), matrix(m, XAXIS)
    for k in range(joints.size):
        if not moves[body, k]:
            continue
        add_motion(m, k, point, ratios[k], out[:3, columns[k]])
        if not slides[k]:
            for c in range(3):
                out[3 + c, columns[k]] += ratios[k] * axis[joints[k], c]


@njit
def poses(states: Array, body: int, offset: Array, turn: Array, m: Indices, out: Array) -> None:
    """Poses (n, 7) of the frame at `offset` (3,), `turn` (4,) of a body, for joint positions (n, dof)."""
    for i in range(len(states)):
        place(states[i], m)
        frame_pose(m, body, offset, turn, out[i])


@njit
def jacobians(states: Array, body: int, offset: Array, m: Indices, out: Array) -> None:
    """Jacobians (n, 6, dof), all zero before: linear rows, then angular ones."""
    point = np.zeros(3)
    for i in range(len(states)):
        place(states[i], m)
        frame_point(m, body, offset, point)
        frame_jacobian(m, body, point, out[i])


@njit
def centres(states: Array, m: Indices, out: Array) -> None:
    """Centres of mass (n, 3), all zero before."""
    masses, middle = vector(m, MASSES), matrix(m, XIPOS)
    total = masses.sum()
    for i in range(len(states)):
        place(states[i], m)
        for body in range(masses.size):
            for c in range(3):
                out[i, c] += masses[body] / total * middle[body, c]
