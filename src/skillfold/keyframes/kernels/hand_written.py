"""Hand-written pose constraints for compiled loops: an axis upright, a plane, a task space region.

Each has an `…_excess` (how far outside [m], below zero inside) and an `…_project` (the same, and the pose that holds
it exactly), of a pose (7,) and the constraint's numbers, a table's only slot:
- axis upright: tool axis (3,), way up (3,), tolerance [rad];
- plane: a point's height along the normal, normal (3,), tolerance [m];
- region: its frame (7,), the inverse (7,) of its offset, lower bounds (6,), upper bounds (6,), tolerance [m].
"""

import math
from typing import Any

import numpy as np

from skillfold.jit import inner, njit
from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.kernels.ellipsoids import Numbers, dot
from skillfold.tables import vector

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

TURN = 2.0 * math.pi
TINY = 1e-12  # of a cross product of unit vectors: they are parallel
LOCKED = 1e-9  # cosine of a pitch at which only the sum of roll and yaw means anything


@njit
def excesses(excess: Any, poses: Array, arguments: Indices, out: Array) -> None:
    """A compiled constraint's excess (n,) of poses (n, 7)."""
    for i in range(len(poses)):
        out[i] = excess(poses[i], arguments)


@njit
def projections(project: Any, poses: Array, arguments: Indices, out: Array) -> None:
    """A compiled constraint's projections (n, 7) of poses (n, 7)."""
    for i in range(len(poses)):
        project(poses[i], out[i], arguments)


@inner
def three(values: Array, i: int) -> Numbers:
    """Three numbers from place i on."""
    return values[i], values[i + 1], values[i + 2]


@inner
def four(values: Array, i: int) -> Numbers:
    """Four numbers from place i on."""
    return values[i], values[i + 1], values[i + 2], values[i + 3]


@inner
def cross(a: Numbers, b: Numbers) -> Numbers:
    """Cross product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inner
def product(a: Numbers, b: Numbers) -> Numbers:
    """Quaternion product: first turn by b, then by a."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@inner
def turned(q: Numbers, v: Numbers) -> Numbers:
    """A vector turned by a unit quaternion."""
    axis = (q[1], q[2], q[3])
    once = cross(axis, v)
    twice = cross(axis, once)
    return (
        v[0] + 2.0 * (q[0] * once[0] + twice[0]),
        v[1] + 2.0 * (q[0] * once[1] + twice[1]),
        v[2] + 2.0 * (q[0] * once[2] + twice[2]),
    )


@inner
def write(position: Numbers, turn: Numbers, out: Array) -> None:
    """Put a pose (7,) together."""
    for c in range(3):
        out[c] = position[c]
    for c in range(4):
        out[c + 3] = turn[c]


@inner
def perpendicular(v: Numbers) -> Numbers:
    """A unit vector at right angles to a unit vector."""
    w = cross(v, (1.0, 0.0, 0.0)) if abs(v[0]) < 0.7 else cross(v, (0.0, 1.0, 0.0))
    length = math.sqrt(dot(w, w))
    return w[0] / length, w[1] / length, w[2] / length


@inner
def upright_excess(pose: Array, table: Indices) -> float:
    """Angle between the tool's axis and the way up, beyond the tolerance, as a length."""
    values = vector(table, 0)
    axis, up = turned(four(pose, 3), three(values, 0)), three(values, 3)
    across = cross(axis, up)
    return LENGTH * (math.atan2(math.sqrt(dot(across, across)), dot(axis, up)) - values[6])


@inner
def upright_project(pose: Array, out: Array, table: Indices) -> float:
    """Turn the tool's axis up, by the shortest way; about any level axis if it points straight down."""
    values, turn = vector(table, 0), four(pose, 3)
    axis, up = turned(turn, three(values, 0)), three(values, 3)
    excess = upright_excess(pose, table)
    if excess > 0.0:
        across = cross(axis, up)
        sine = math.sqrt(dot(across, across))
        half = 0.5 * math.atan2(sine, dot(axis, up))
        level = perpendicular(up) if sine < TINY else (across[0] / sine, across[1] / sine, across[2] / sine)
        s = math.sin(half)
        turn = product((math.cos(half), s * level[0], s * level[1], s * level[2]), turn)
    write(three(pose, 0), turn, out)
    return excess


@inner
def plane_excess(pose: Array, table: Indices) -> float:
    """Distance from the plane, beyond the tolerance."""
    values = vector(table, 0)
    return abs(dot(three(values, 1), three(pose, 0)) - values[0]) - values[4]


@inner
def plane_project(pose: Array, out: Array, table: Indices) -> float:
    """Straight onto the plane."""
    values = vector(table, 0)
    normal, position, excess = three(values, 1), three(pose, 0), plane_excess(pose, table)
    off = dot(normal, position) - values[0] if excess > 0.0 else 0.0
    moved = (position[0] - off * normal[0], position[1] - off * normal[1], position[2] - off * normal[2])
    write(moved, four(pose, 3), out)
    return excess


@inner
def angles(q: Numbers) -> Numbers:
    """Roll, pitch and yaw of a unit quaternion: R = Rz(yaw) Ry(pitch) Rx(roll); no roll where pitch is 90°."""
    w, x, y, z = q
    a, b = 2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)
    sine, cosine = 2.0 * (w * y - z * x), math.sqrt(a * a + b * b)
    pitch = math.atan2(sine, cosine)
    if cosine < LOCKED:
        return 0.0, pitch, -2.0 * math.copysign(1.0, sine) * math.atan2(x, w)
    return math.atan2(a, b), pitch, math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


@inner
def of_angles(roll: float, pitch: float, yaw: float) -> Numbers:
    """The unit quaternion of roll, pitch and yaw."""
    r, p, y = 0.5 * roll, 0.5 * pitch, 0.5 * yaw
    turn = product((math.cos(y), 0.0, 0.0, math.sin(y)), (math.cos(p), 0.0, math.sin(p), 0.0))
    return product(turn, (math.cos(r), math.sin(r), 0.0, 0.0))


@inner
def bounded(value: float, low: float, high: float) -> Numbers:
    """The nearest number within bounds, and how far off it is."""
    inside = min(max(value, low), high)
    return inside, value - inside


@inner
def angle_bounded(value: float, low: float, high: float) -> Numbers:
    """The same of an angle, counted round the circle."""
    middle = 0.5 * (low + high)
    return bounded(value - TURN * math.floor((value - middle) / TURN + 0.5), low, high)


@inner
def angles_bounded(roll: float, pitch: float, yaw: float, low: Numbers, high: Numbers) -> Numbers:
    """Three angles within their bounds, and the sum of squares of how far off they were."""
    r, p = angle_bounded(roll, low[0], high[0]), angle_bounded(pitch, low[1], high[1])
    y = angle_bounded(yaw, low[2], high[2])
    return r[0], p[0], y[0], r[1] * r[1] + p[1] * p[1] + y[1] * y[1]


@inner
def nearest_bounded(pose: Array, values: Array) -> Numbers:
    """Position and roll, pitch and yaw in the region's frame, within their bounds; and how far off [m] they were.

    Each turn has two sets of angles; that nearer to the bounds is taken.
    """
    back = (values[3], -values[4], -values[5], -values[6])  # from the world into the region's frame
    tool, arm = four(pose, 3), turned(four(pose, 3), three(values, 7))
    d = turned(back, (pose[0] + arm[0] - values[0], pose[1] + arm[1] - values[1], pose[2] + arm[2] - values[2]))
    x, y = bounded(d[0], values[14], values[20]), bounded(d[1], values[15], values[21])
    z = bounded(d[2], values[16], values[22])
    roll, pitch, yaw = angles(product(product(back, tool), four(values, 10)))
    low, high = three(values, 17), three(values, 23)
    turn = angles_bounded(roll, pitch, yaw, low, high)
    other = angles_bounded(roll + math.pi, math.pi - pitch, yaw + math.pi, low, high)
    if other[3] < turn[3]:
        turn = other
    off = math.sqrt(x[1] * x[1] + y[1] * y[1] + z[1] * z[1] + LENGTH * LENGTH * turn[3])
    return x[0], y[0], z[0], turn[0], turn[1], turn[2], off


@inner
def region_excess(pose: Array, table: Indices) -> float:
    """How far position and angles are off their bounds, beyond the tolerance."""
    values = vector(table, 0)
    return nearest_bounded(pose, values)[6] - values[26]


@inner
def region_project(pose: Array, out: Array, table: Indices) -> float:
    """Bring position and angles in the region's frame into their bounds."""
    values = vector(table, 0)
    x, y, z, roll, pitch, yaw, off = nearest_bounded(pose, values)
    position, turn = three(pose, 0), four(pose, 3)
    if off > values[26]:
        frame = four(values, 3)
        moved = turned(frame, (x, y, z))
        ahead = (values[10], -values[11], -values[12], -values[13])
        turn = product(product(frame, of_angles(roll, pitch, yaw)), ahead)
        arm = turned(turn, three(values, 7))
        position = (values[0] + moved[0] - arm[0], values[1] + moved[1] - arm[1], values[2] + moved[2] - arm[2])
    write(position, turn, out)
    return off - values[26]
