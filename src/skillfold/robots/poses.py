"""Arithmetic of poses (..., 7): x, y, z, then the unit quaternion qw, qx, qy, qz."""

from typing import Any

import numpy as np

from skillfold.errors import InputError

Array = np.ndarray[Any, np.dtype[np.float64]]

UNIT = 1e-3  # a quaternion whose length is farther from 1 than this was hardly meant as one
EXACT = 1e-12  # one that is as close as this stays as it is, so that reading it twice changes no bit
FARTHEST = 1e100  # metres: squares of more would not be finite
HERE = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def read_pose(value: Any, what: str, kind: type[InputError] = InputError) -> Array:
    """Pose (..., 7) from a pose, or from a position (..., 3) that is not turned.

    Raises:
        InputError: of the kind given; `what` names the value in its message.
    """
    pose = read_numbers(value, what, "a pose (x, y, z, qw, qx, qy, qz) or a position (x, y, z)", kind)
    if pose.ndim and pose.shape[-1] == 3:
        pose = np.concatenate([pose, np.broadcast_to(HERE[3:], (*pose.shape[:-1], 4))], axis=-1)
    if pose.ndim == 0 or pose.shape[-1] != 7:
        raise kind(f"{what}: shape {pose.shape}; expected a pose of 7 numbers or a position of 3.")
    if not (np.abs(pose[..., :3]) < FARTHEST).all():
        raise kind(f"{what}: a position {np.abs(pose[..., :3]).max():.2g} m away; positions are in metres.")
    # Squares of huge entries would not be finite, and are as wrong as those of length 2.
    length = np.linalg.norm(np.clip(pose[..., 3:], -2.0, 2.0), axis=-1, keepdims=True)
    if not (np.abs(length - 1) <= UNIT).all():
        worst = float(length.ravel()[np.abs(length - 1).argmax()])
        raise kind(f"{what}: quaternion (qw, qx, qy, qz) of length {worst:.4g}; expected length 1.")
    pose[..., 3:] /= np.where(np.abs(length - 1) > EXACT, length, 1.0)
    return pose


def read_numbers(value: Any, what: str, expected: str, kind: type[InputError] = InputError) -> Array:
    """Finite float64 array, a copy.

    Raises:
        InputError: of the kind given.
    """
    try:
        given = np.asarray(value)
        if given.dtype.kind == "c":
            raise TypeError
        with np.errstate(over="ignore"):  # wider floats may become infinite, which is caught as such
            array = np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise kind(f"{what}: {value!r:.80}; expected {expected}.") from None
    if not np.isfinite(array).all():
        raise kind(f"{what}: has numbers that are not finite; expected {expected}.")
    return array


def multiply(a: Array, b: Array) -> Array:
    """Quaternion product (..., 4): first turn by `b`, then by `a`."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    parts = [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]
    return np.stack(parts, axis=-1)


def turn(quaternion: Array, vectors: Array) -> Array:
    """Vectors (..., 3) turned by unit quaternions (..., 4)."""
    w, axis = quaternion[..., :1], quaternion[..., 1:]
    twice = 2 * np.cross(axis, vectors)
    return vectors + w * twice + np.cross(axis, twice)


def place_points(pose: Array, points: Array) -> Array:
    """Points (..., 3) of a frame at `pose` (..., 7), in the frame that the pose is given in."""
    return pose[..., :3] + turn(pose[..., 3:], points)


def compose(outer: Array, inner: Array) -> Array:
    """Pose (..., 7) of what stands at `inner` in a frame that stands at `outer`."""
    turned = multiply(outer[..., 3:], inner[..., 3:])
    return np.concatenate([place_points(outer, inner[..., :3]), turned], axis=-1)


def between(first: Array, second: Array, share: float) -> Array:
    """Pose `share` of the way from `first` (7,) to `second` (7,): straight, turning evenly the shorter way."""
    a, b = first[3:], second[3:]
    dot = float(a @ b)
    if dot < 0:
        b, dot = -b, -dot
    angle = np.arccos(min(dot, 1.0))
    weights = (1 - share, share)
    if angle > 1e-6:
        weights = (np.sin((1 - share) * angle) / np.sin(angle), np.sin(share * angle) / np.sin(angle))
    quaternion = weights[0] * a + weights[1] * b
    position = (1 - share) * first[:3] + share * second[:3]
    return np.concatenate([position, quaternion / np.linalg.norm(quaternion)])
