"""Poses as flat coordinates about a middle rotation, and back (see `skillfold.keyframes.charts`)."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner, njit

Array = np.ndarray[Any, np.dtype[np.float64]]

TINY = 1e-12  # below this length of a quaternion's vector part its direction says nothing


@inner
def to_flat(pose: Array, middle: Array, out: Array) -> None:
    """Chart coordinates (6,) of a pose (7,)."""
    for c in range(3):
        out[c] = pose[c]
    a, b, c, d = middle[0], -middle[1], -middle[2], -middle[3]
    w, x, y, z = pose[3], pose[4], pose[5], pose[6]
    e = a * w - b * x - c * y - d * z
    f, g, h = a * x + b * w + c * z - d * y, a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w
    if e < 0.0:  # of the two quaternions of a rotation, the one with the shorter way
        e, f, g, h = -e, -f, -g, -h
    sine = math.sqrt(f * f + g * g + h * h)
    scale = 2.0 * math.atan2(sine, e) / sine if sine > TINY else 2.0
    out[3], out[4], out[5] = scale * f, scale * g, scale * h


@inner
def to_full(coordinates: Array, middle: Array, out: Array) -> None:
    """The pose (7,) with chart coordinates (6,)."""
    for c in range(3):
        out[c] = coordinates[c]
    f, g, h = coordinates[3], coordinates[4], coordinates[5]
    angle = math.sqrt(f * f + g * g + h * h)
    scale = math.sin(0.5 * angle) / angle if angle > TINY else 0.5
    w, x, y, z = math.cos(0.5 * angle), scale * f, scale * g, scale * h
    a, b, c, d = middle[0], middle[1], middle[2], middle[3]
    out[3] = a * w - b * x - c * y - d * z
    out[4] = a * x + b * w + c * z - d * y
    out[5] = a * y - b * z + c * w + d * x
    out[6] = a * z + b * y - c * x + d * w


@njit
def flat(poses: Array, middle: Array, out: Array) -> None:
    """Chart coordinates (n, 6) of poses (n, 7)."""
    for i in range(len(poses)):
        to_flat(poses[i], middle, out[i])


@njit
def full(coordinates: Array, middle: Array, out: Array) -> None:
    """Poses (n, 7) with chart coordinates (n, 6)."""
    for i in range(len(coordinates)):
        to_full(coordinates[i], middle, out[i])
