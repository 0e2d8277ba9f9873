"""Joint positions that bring a robot's tool to a pose: damped least squares from many random starts at once."""

from typing import TYPE_CHECKING, Any

import numpy as np

from skillfold.errors import InputError
from skillfold.robots.poses import multiply, read_pose
from skillfold.tables import Array

if TYPE_CHECKING:
    from skillfold.clearance import Clearance
    from skillfold.robots.robot import Robot

STARTS, STEPS = 64, 60
DAMPING, LEAST_DAMPING = 0.1, 1e-8  # of a squared step, a metre as a radian
LONGEST = 0.4  # rad that a joint may turn in one step
REACHED = 1e-6  # m and rad
ALIKE = 1  # decimals of the joint positions [rad] in which two answers must differ


def reach(robot: "Robot", pose: Any, obstacles: "Clearance | None" = None, seed: int = 0) -> Array:
    """Joint positions (n, dof) with the tool at a pose (7,), in several postures, the one with most room first.

    Args:
        robot: whose tool it is.
        pose: of the tool.
        obstacles: what the robot must be clear of, by `robot.obstacles(scene)`; its own shapes where left out.
        seed: of the starts.

    Returns:
        None but those within the limits and clear; none (0, dof) where the pose is not reached from any start.

    Raises:
        InputError: no pose.
    """
    target = read_pose(pose, "pose of the tool")
    if target.shape != (7,):
        raise InputError(f"pose of the tool: shape {target.shape}; expected (7,).")
    found = _different(robot.wrap(_descended(robot, target, robot.sample(STARTS, seed))))
    room = (robot.obstacles() if obstacles is None else obstacles).clearance(found)
    clear = np.flatnonzero(room > 0.0)
    return found[clear[np.argsort(-room[clear], kind="stable")]]


def _descended(robot: "Robot", target: Array, q: Array) -> Array:
    """Those of the starts (n, dof) that came to the target."""
    lower, upper = robot.limits
    for _ in range(STEPS):
        jacobian, error = robot.jacobian(q), _error(robot, target, q)
        # Damped by what is left of the way (Sugihara): fast at the end, and bounded where the arm is stretched.
        damping = LEAST_DAMPING + 0.5 * DAMPING * (error**2).sum(axis=1)
        normal = jacobian.swapaxes(1, 2) @ jacobian + damping[:, None, None] * np.eye(robot.dof)
        turned = np.linalg.solve(normal, jacobian.swapaxes(1, 2) @ error[..., None])[..., 0]
        turned *= np.minimum(1.0, LONGEST / np.maximum(np.abs(turned).max(axis=1, keepdims=True), 1e-12))
        q = robot.couple(np.clip(q + turned, lower, upper))
    return q[np.abs(_error(robot, target, q)).max(axis=1) < REACHED]


def _error(robot: "Robot", target: Array, q: Array) -> Array:
    """Way (n, 6) from the tool to the target: metres, then a rotation vector, both in world axes."""
    pose = robot.forward(q)
    turn = multiply(target[3:], pose[:, 3:] * [1.0, -1.0, -1.0, -1.0])
    turn *= np.where(turn[:, :1] < 0.0, -1.0, 1.0)
    sine = np.linalg.norm(turn[:, 1:], axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, turn[:, :1])
    return np.concatenate([target[:3] - pose[:, :3], turn[:, 1:] * angle / np.maximum(sine, 1e-12)], axis=1)


def _different(q: Array) -> Array:
    """One of all that are alike, in the order in which they came."""
    first = np.unique(np.round(q, ALIKE), axis=0, return_index=True)[1]
    return q[np.sort(first)]
