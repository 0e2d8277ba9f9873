"""Keeping a tool upright: a constraint of whole arms that leaves most joints free.

Two arms written down from published Denavit-Hartenberg (DH) values: the seven-joint KUKA LWR4+ and the
six-joint Kinova Jaco j2n6s300. Samples are joint vectors, uniform over the joint box, moved by damped Newton
steps until the tool axis lies within 1.5° of straight down. A skill learnt from them projects random states
of the joint box; success is a tilt below 0.1 rad. Angles in radians.
"""

from dataclasses import dataclass

import numpy as np

from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array

SAMPLE_TILT = np.radians(1.5)
SUCCESS_TILT = 0.1
STATES = 1000


@dataclass(frozen=True)
class Arm:
    """A serial arm in the standard DH convention, without its lengths: the tool axis depends on none.

    Attributes:
        name: of the arm.
        dim: dimension of the set of upright poses.
        twist: (D,) DH angle α after each joint.
        sign, offset: (D,) DH angle θ = sign · q + offset of each joint q.
        lower, upper: (D,) the joint box.
    """

    name: str
    dim: int
    twist: Array
    sign: Array
    offset: Array
    lower: Array
    upper: Array

    def uniform(self, count: int, rng: np.random.Generator) -> Array:
        """Joint vectors (count, D) uniform over the joint box."""
        return rng.uniform(self.lower, self.upper, (count, len(self.lower)))


def _arm(name: str, twist_deg: list[float], lower: list[float], upper: list[float], **mapping: list[float]) -> Arm:
    joints = len(twist_deg)
    sign = np.array(mapping.get("sign", [1.0] * joints))
    offset = np.radians(mapping.get("offset_deg", [0.0] * joints))
    return Arm(name, joints - 2, np.radians(twist_deg), sign, offset, np.array(lower), np.array(upper))


_LWR4_LIMITS = np.radians([170, 120, 170, 120, 170, 120, 170]).tolist()
# KUKA LWR4+: standard DH, no offsets; limits of the data sheet.
LWR4 = _arm("LWR4", [90, -90, -90, 90, 90, -90, 0], [-limit for limit in _LWR4_LIMITS], _LWR4_LIMITS)
# Kinova j2n6s300: wrist joints inclined by 60°; joints 2 and 3 limited, the others turn freely.
JACO = _arm(
    "Jaco",
    [90, 180, 90, 60, 60, 180],
    [-np.pi, 0.8203, 0.3316, -np.pi, -np.pi, -np.pi],
    [np.pi, 5.4629, 5.9516, np.pi, np.pi, np.pi],
    sign=[-1, 1, 1, 1, 1, 1],
    offset_deg=[0, -90, 90, 0, -180, 90],
)


def tool_axis(arm: Arm, joints: Array) -> Array:
    """Unit vectors (N, 3) of the tool axis, the last DH frame's z, in the base frame."""
    return _frames(arm, joints)[:, -1, :, 2]


def tilt(arm: Arm, joints: Array) -> Array:
    """Angle (N,) between the tool axis and straight down."""
    axis = tool_axis(arm, joints)
    return np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), -axis[:, 2])


def upright_poses(arm: Arm, count: int, rng: np.random.Generator) -> Array:
    """Joint vectors (count, D) with the tool axis within 1.5° of straight down, inside the limits."""
    kept = np.empty((0, len(arm.lower)))
    while len(kept) < count:
        poses = _turned(arm, arm.uniform(2 * count, rng), _near_down(2 * count, rng))
        inside = ((poses >= arm.lower) & (poses <= arm.upper)).all(axis=1)
        kept = np.concatenate([kept, poses[inside & (tilt(arm, poses) < SAMPLE_TILT)]])
    return kept[:count]


def measure(settings: Settings, counts: tuple[int, ...] = (500, 1000, 5000), states: int = STATES) -> list[Row]:
    """Share of random states that end upright after projection, per arm and number of samples."""
    rng = np.random.default_rng(settings.seed)
    targets = {500: 0.90, 1000: 0.97, 5000: 0.99}
    rows = []
    for arm in (LWR4, JACO):
        for count in counts:
            settings.progress(f"upright {arm.name}, {count} samples", len(rows) / (2 * len(counts)))
            rows.append(_measure_one(arm, count, targets.get(count), states, settings, rng))
    return rows


def _measure_one(
    arm: Arm, count: int, target: float | None, states: int, settings: Settings, rng: np.random.Generator
) -> Row:
    skill = settings.learn(upright_poses(arm, count, rng))
    before = arm.uniform(states, rng)
    after = np.asarray(skill.project(before))
    tilts = tilt(arm, after)
    moved = np.median(np.linalg.norm(after - before, axis=1))
    note = (
        f"median tilt {np.median(tilts):.1e} rad, p95 {np.percentile(tilts, 95):.1e}; "
        f"median move {moved:.2f} rad; dimension {skill.dim} (true {arm.dim})"
    )
    name = f"upright {arm.name}, {count} samples: tilt < 0.1 rad after projection"
    return Row(name, float(np.mean(tilts < SUCCESS_TILT)), "share", target, ">=", "", note)


def _frames(arm: Arm, joints: Array) -> Array:
    """Rotations (N, D + 1, 3, 3) of the base and of the frame after each joint."""
    angles = arm.sign * joints + arm.offset
    frames = [np.broadcast_to(np.eye(3), (len(joints), 3, 3))]
    for index, twist in enumerate(arm.twist):
        frames.append(frames[-1] @ _dh_rotation(angles[:, index], float(twist)))
    return np.stack(frames, axis=1)


def _dh_rotation(angles: Array, twist: float) -> Array:
    c, s = np.cos(angles), np.sin(angles)
    ca, sa = np.cos(twist), np.sin(twist)
    zero = np.zeros_like(c)
    rows = [[c, -s * ca, s * sa], [s, c * ca, -c * sa], [zero, zero + sa, zero + ca]]
    return np.moveaxis(np.array(rows), -1, 0)


def _near_down(count: int, rng: np.random.Generator) -> Array:
    """Unit vectors (count, 3) uniform over the cap around straight down; a hair inside its rim."""
    tilts = 0.999 * SAMPLE_TILT * np.sqrt(rng.uniform(size=count))
    azimuth = rng.uniform(0, 2 * np.pi, count)
    return np.column_stack([np.sin(tilts) * np.cos(azimuth), np.sin(tilts) * np.sin(azimuth), -np.cos(tilts)])


def _turned(arm: Arm, joints: Array, wanted: Array, steps: int = 40) -> Array:
    """Joint vectors moved by damped Newton steps until the tool axis is the wanted one."""
    q = joints.copy()
    for _ in range(steps):
        frames = _frames(arm, q)
        axis = frames[:, -1, :, 2]
        # Turning joint j moves the tool axis by (joint axis) × (tool axis).
        J = np.cross(arm.sign[:, None] * frames[:, :-1, :, 2], axis[:, None]).swapaxes(1, 2)
        damped = J @ J.swapaxes(1, 2) + 1e-3 * np.eye(3)
        step = (J.swapaxes(1, 2) @ np.linalg.solve(damped, (wanted - axis)[..., None]))[..., 0]
        q += step * np.minimum(1.0, 0.5 / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-12))
    return q
