"""The distance of two shapes, and bounds of it that cost little. Slots of a table, those of `kinematics` first."""

import math

import numpy as np

from skillfold.jit import inner
from skillfold.robots import kinematics as kin
from skillfold.robots.mujoco_calls import geom_distance
from skillfold.tables import Array, Indices, address, indices, matrix, scalar, vector

RADII = kin.SLOTS  # (n_shapes,) of bounding spheres
CENTRES, AXES = kin.SLOTS + 1, kin.SLOTS + 2  # (n_shapes, 3), (n_shapes, 9) places and rotations, MuJoCo's
SPINES, GIRTHS = kin.SLOTS + 3, kin.SLOTS + 4  # (n_shapes,) each lies within a girth of its z axis, ± spine
BOXES = kin.SLOTS + 5  # (n_shapes, 6) centre and half edges of its bounding box
CRATES = kin.SLOTS + 6  # (n_shapes,) 1 for boxes, which fill their bounding box
TRIAL = kin.SLOTS + 7  # (6,) scratch: nearest points, MuJoCo's last answer
SLOTS = kin.SLOTS + 8

PARALLEL = 1e-12  # less of a spine's direction than this along a box's edge is none


@inner
def gap(a: Array, i: int, b: Array, j: int) -> float:
    """Distance of row i of `a` and row j of `b`."""
    return math.sqrt((a[i, 0] - b[j, 0]) ** 2 + (a[i, 1] - b[j, 1]) ** 2 + (a[i, 2] - b[j, 2]) ** 2)


@inner
def box_gap(a: int, b: int, c: Indices) -> float:
    """Lower bound of the distance of two shapes: from the spine of `a` to the bounding box of `b`, less a's girth."""
    centres, axes, boxes = matrix(c, CENTRES), matrix(c, AXES), matrix(c, BOXES)
    spine = vector(c, SPINES)[a]
    x, y, z = centres[a, 0] - centres[b, 0], centres[a, 1] - centres[b, 1], centres[a, 2] - centres[b, 2]
    total = 0.0
    for i in range(3):
        u, v, w = axes[b, i], axes[b, 3 + i], axes[b, 6 + i]
        along = spine * abs(u * axes[a, 2] + v * axes[a, 5] + w * axes[a, 8])
        apart = abs(u * x + v * y + w * z - boxes[b, i]) - along - boxes[b, 3 + i]
        if apart > 0.0:
            total += apart * apart
    return math.sqrt(total) - vector(c, GIRTHS)[a] if total > 0.0 else -math.inf


@inner
def nearer(a: int, b: int, reach: float, c: Indices) -> bool:
    """Whether two shapes may be nearer than `reach`, by their bounds alone."""
    radii, centres = vector(c, RADII), matrix(c, CENTRES)
    return gap(centres, a, centres, b) - radii[a] - radii[b] < reach and box_gap(a, b, c) < reach


@inner
def measured(a: int, b: int, farthest: float, c: Indices) -> float:
    """Signed distance of two shapes, at most `farthest`; TRIAL holds their nearest points.

    MuJoCo may call a capsule clear of a box that it runs through: that is looked at besides.
    """
    model, data = scalar(c, kin.MODEL), scalar(c, kin.DATA)
    distance = geom_distance(model, data, np.int32(a), np.int32(b), farthest, address(c, TRIAL))
    if distance > 0.0:
        crates, spines, girths = indices(c, CRATES), vector(c, SPINES), vector(c, GIRTHS)
        if crates[b] and spines[a] > 0.0 and pierced(a, b, c):
            return sunk(a, b, girths[a], c)
        if crates[a] and spines[b] > 0.0 and pierced(b, a, c):
            return sunk(a, b, girths[b], c)
    return distance


@inner
def pierced(a: int, b: int, c: Indices) -> bool:
    """Whether the spine of shape a comes into the bounding box of b."""
    centres, axes, boxes = matrix(c, CENTRES), matrix(c, AXES), matrix(c, BOXES)
    last = vector(c, SPINES)[a]
    first = -last
    x, y, z = centres[a, 0] - centres[b, 0], centres[a, 1] - centres[b, 1], centres[a, 2] - centres[b, 2]
    for i in range(3):
        u, v, w = axes[b, i], axes[b, 3 + i], axes[b, 6 + i]
        along = u * axes[a, 2] + v * axes[a, 5] + w * axes[a, 8]
        apart, half = u * x + v * y + w * z - boxes[b, i], boxes[b, 3 + i]
        if abs(along) > PARALLEL:
            one, other = (-half - apart) / along, (half - apart) / along
            first, last = max(first, min(one, other)), min(last, max(one, other))
        elif abs(apart) > half:
            return False
    return first <= last


@inner
def sunk(a: int, b: int, depth: float, c: Indices) -> float:
    """The distance, and nearest points in TRIAL, of shapes of which one is in the other: apart by their centres."""
    centres, trial = matrix(c, CENTRES), vector(c, TRIAL)
    length = max(gap(centres, a, centres, b), 1e-300)
    for i in range(3):
        trial[i] = centres[a, i]
        trial[3 + i] = centres[a, i] - depth * (centres[b, i] - centres[a, i]) / length
    return -depth
