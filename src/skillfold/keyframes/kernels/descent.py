"""Poses that descend toward a target: the paper's projection (algorithm 3, lines 15-28; eqs. 3-5), mended.

Eq. 2 cancels against eq. 6 and Σ against Σ⁻¹ in eq. 5, so a step is the plain sum of two differences of poses: to the
target, and to the line through the target along the envelope's axis. Only the feedback error e2 moves the joints.
"""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner
from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.kernels.charts import to_flat, to_full
from skillfold.keyframes.kernels.problem import FULL, Held, Problem, Work
from skillfold.robots.kinematics import Tool, frame_jacobian, frame_pose, place

Array = np.ndarray[Any, np.dtype[np.float64]]

GAIN = 0.5  # of the differences that one step closes
STRIDE = 0.08  # metres: longest step of the pose
DAMPING = 1e-3  # square metres: λ² of the damped inverse
INWARD = 0.25  # of the way back inside that a target is put deeper than the border


@inner
def tool_pose(tool: Tool, q: Array, out: Array) -> None:
    """Pose (7,) of the tool at joint positions q (D,)."""
    place(q, tool.machine)
    frame_pose(tool.machine, tool.body, tool.offset, tool.turn, out)


@inner
def is_inside(held: Held, pose: Array) -> bool:
    """Whether a pose (7,) holds the constraint."""
    return held.excess(pose, held.arguments) <= held.level


@inner
def turned(angle: float) -> float:
    """An angle brought into half a turn to each side."""
    return angle - FULL * math.floor(angle / FULL + 0.5)


@inner
def along_axis(axis: Array, y: Array) -> float:
    """Place 0..1 on the axis (2, 6) that is nearest to chart coordinates y (6,), a radian as `LENGTH` metres."""
    dot, square = 0.0, 0.0
    for c in range(6):
        weight = 1.0 if c < 3 else LENGTH * LENGTH
        way = axis[1, c] - axis[0, c]
        dot += weight * way * (y[c] - axis[0, c])
        square += weight * way * way
    return min(max(dot / square, 0.0), 1.0) if square > 0.0 else 0.0


@inner
def pull(axis: Array, y: Array, target: Array, out: Array) -> float:
    """The step (6,) from chart coordinates y toward a target, bent to the axis; how far off the target is [m].

    Eq. 3b with the offset of line 17: toward the line through the target along the axis, which ends where it ends.
    """
    here, there = along_axis(axis, y), along_axis(axis, target)
    left, length = 0.0, 0.0
    for c in range(6):
        weight = 1.0 if c < 3 else LENGTH * LENGTH
        ahead = target[c] - y[c]
        aside = ahead + (here - there) * (axis[1, c] - axis[0, c])
        out[c] = GAIN * (ahead + aside)
        left += weight * ahead * ahead
        length += weight * out[c] * out[c]
    shrink = min(1.0, STRIDE / max(math.sqrt(length), 1e-300))
    for c in range(6):
        out[c] *= shrink
    return math.sqrt(left)


@inner
def keep_inside(problem: Problem, work: Work) -> None:
    """Bring the pose `work.wanted` inside where it is not, a little deeper than the border."""
    hold, wanted, y, deeper = problem.hold, work.wanted, work.step, work.other
    if is_inside(hold, wanted):
        return
    hold.project(wanted, work.passing, hold.arguments)
    to_flat(wanted, problem.middle, y)
    to_flat(work.passing, problem.middle, deeper)
    for c in range(6):
        deeper[c] += INWARD * (deeper[c] - y[c])
    to_full(deeper, problem.middle, wanted)


@inner
def twist(pose: Array, wanted: Array, out: Array) -> None:
    """From a pose (7,) to another: way [m] and turn [rad] in world axes, the turn times `LENGTH`; (6,)."""
    to_flat(wanted, pose[3:], out)
    w, x, y, z = pose[3], pose[4], pose[5], pose[6]
    a, b, c = out[3], out[4], out[5]
    d, e, f = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    out[3] = LENGTH * (a + w * d + y * f - z * e)
    out[4] = LENGTH * (b + w * e + z * d - x * f)
    out[5] = LENGTH * (c + w * f + x * e - y * d)
    for k in range(3):
        out[k] -= pose[k]


@inner
def solve_damped(jacobian: Array, square: Array, right: Array, damping: float) -> None:
    """Solve (J Jᵀ + λ²) x = right (6,), in place, by Cholesky's way; `square` (6, 6) is scratch."""
    for i in range(6):
        for j in range(i + 1):
            s = damping if i == j else 0.0
            for k in range(jacobian.shape[1]):
                s += jacobian[i, k] * jacobian[j, k]
            for k in range(j):
                s -= square[i, k] * square[j, k]
            square[i, j] = math.sqrt(s) if i == j else s / square[j, j]
    for i in range(6):
        for k in range(i):
            right[i] -= square[i, k] * right[k]
        right[i] /= square[i, i]
    for i in range(5, -1, -1):
        for k in range(i + 1, 6):
            right[i] -= square[k, i] * right[k]
        right[i] /= square[i, i]


@inner
def face(problem: Problem, q: Array, work: Work) -> None:
    """Pose and scaled Jacobian at joint positions q (D,), into `work`."""
    tool, jacobian = problem.tool, work.jacobian
    tool_pose(tool, q, work.pose)
    for i in range(6):
        for k in range(q.size):
            jacobian[i, k] = 0.0
    frame_jacobian(tool.machine, tool.body, work.pose[:3], jacobian)
    for i in range(3, 6):
        for k in range(q.size):
            jacobian[i, k] *= LENGTH


@inner
def follow(problem: Problem, q: Array, work: Work) -> None:
    """Move joint positions q (D,), which `work` faces, toward the pose `work.wanted`: damped, within limits."""
    jacobian, right = work.jacobian, work.step
    twist(work.pose, work.wanted, right)
    solve_damped(jacobian, work.square, right, DAMPING)
    length = 0.0
    for k in range(q.size):
        s = 0.0
        for i in range(6):
            s += jacobian[i, k] * right[i]
        work.state[k] = s
        length += s * s
    shrink = min(1.0, problem.reach / max(math.sqrt(length), 1e-300))
    for k in range(q.size):
        q[k] = min(max(q[k] + shrink * work.state[k], problem.lower[k]), problem.upper[k])


@inner
def descend(problem: Problem, q: Array, target: Array, constrained: bool, work: Work) -> float:
    """One step of joint positions q (D,), in place, toward a target's chart coordinates (6,).

    Returns how far off the pose was before [m]; `work.pose` is the new pose. Where the step is constrained, the pose
    is led along the border of the constraint rather than across.
    """
    face(problem, q, work)
    to_flat(work.pose, problem.middle, work.flat)
    left = pull(problem.axis, work.flat, target, work.step)
    for c in range(6):
        work.flat[c] += work.step[c]
    to_full(work.flat, problem.middle, work.wanted)
    if constrained:
        keep_inside(problem, work)
    follow(problem, q, work)
    tool_pose(problem.tool, q, work.pose)
    return left
