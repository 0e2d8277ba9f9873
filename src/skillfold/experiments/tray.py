"""Section VI of paper 000: a seven-joint arm that carries a tray with little joint motion.

At a tool position x the pose minimises J = J₁ + J₂, J₁ = w‖q‖² and J₂ = pitch² + roll² of the tray, subject to
f(q) = x (Equations 17 to 20). The tray lies on the tool, whose axis points up; pitch and roll are the two horizontal
components of the rotation that levels it, so that J₂ is the squared tilt. The truth is computed here and nowhere
else: Newton steps on the Karush-Kuhn-Tucker (KKT) system, for all positions at once, along a way from one seed pose
to each position. That traces one branch, elbow up; independent optimisations mix two whose costs nearly agree. With
this cost the last joint only turns the tray: it is zero on the whole branch. Radians and metres; `positions` are
(N, 3) in the frame of the base, `q` are (N, 7).
"""

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from skillfold.motion import Array

if TYPE_CHECKING:
    from skillfold.robots.robot import Robot

PAPER_WEIGHT = 0.1  # tilts of some .13 rad (p95)
LEVEL_WEIGHT = 0.005  # tilt weighed 20 times more: some .008 rad
JOINTS = 7
RADIUS, HEIGHT, AZIMUTH = (0.35, 0.70), (0.45, 0.95), np.radians(100.0)  # of tool positions
SHOULDER = np.array([0.0, 0.0, 0.31])
WRIST = 0.078  # from the wrist up to the tool
STRETCH = 0.70  # from shoulder to wrist at most: there the arm nearly stretches
ROOM = 0.05  # rad that poses keep from the joint limits
SEED = np.array([0.0, -0.27, 0.0, 1.49, 0.0, 1.63, 0.0])
WAYPOINTS, NEWTON_STEPS = 12, 8
LONGEST_STEP = 0.3  # rad, of Newton
CONVERGED = 1e-9
FLAT = 1e-3  # rad: below it the derivatives of tilt² are taken from their series


@cache
def arm() -> "Robot":
    """The bundled KUKA LWR4+."""
    from skillfold.robots.robot import Robot

    return Robot.load("lwr4")


def tilt(q: Array) -> Array:
    """Angle (N,) between the tool axis and straight up."""
    axis = _tool_axis(arm().forward(q))
    return np.arctan2(np.hypot(axis[..., 0], axis[..., 1]), axis[..., 2])


def motion_cost(q: Array, weight: float = PAPER_WEIGHT) -> Array:
    """J₁ (N,) of each pose (Equation 19)."""
    return weight * np.sum(np.square(q), axis=-1)


def cost(q: Array, weight: float = PAPER_WEIGHT) -> Array:
    """J (N,) of each pose (Equation 17)."""
    return motion_cost(q, weight) + tilt(q) ** 2


def positions(q: Array) -> Array:
    """Tool positions (N, 3)."""
    return arm().forward(q)[..., :3]


def workspace(count: int, rng: np.random.Generator) -> Array:
    """Tool positions (count, 3) uniform in the workspace: a half ring before the arm, where it does not stretch."""
    kept = np.empty((0, 3))
    while len(kept) < count:
        radius, height = (rng.uniform(*ends, 2 * count) for ends in (RADIUS, HEIGHT))
        drawn = _cylinder(radius, rng.uniform(-AZIMUTH, AZIMUTH, 2 * count), height)
        kept = np.concatenate([kept, drawn[in_workspace(drawn)]])
    return kept[:count]


def in_workspace(places: Array) -> np.ndarray:
    """Whether tool positions (N, 3) lie in the workspace, (N,)."""
    radius, azimuth = np.hypot(places[:, 0], places[:, 1]), np.arctan2(places[:, 1], places[:, 0])
    ring = (radius >= RADIUS[0]) & (radius <= RADIUS[1]) & (np.abs(azimuth) <= AZIMUTH)
    level = (places[:, 2] >= HEIGHT[0]) & (places[:, 2] <= HEIGHT[1])
    bent = np.linalg.norm(places - [0.0, 0.0, WRIST] - SHOULDER, axis=1) < STRETCH
    return np.asarray(ring & level & bent)


def inside_limits(q: Array) -> np.ndarray:
    """Whether poses (N, 7) stay clear of the joint limits, (N,); poses that are not numbers do not."""
    lower, upper = arm().limits
    return np.all((q >= lower + ROOM) & (q <= upper - ROOM), axis=1)


def tray_poses(count: int, rng: np.random.Generator, weight: float = PAPER_WEIGHT) -> Array:
    """Demonstrations (count, 7): optimal poses at random tool positions, clear of the joint limits."""
    kept = np.empty((0, JOINTS))
    while len(kept) < count:
        poses = optimum(workspace(count + count // 2, rng), weight)
        kept = np.concatenate([kept, poses[inside_limits(poses)]])
    return kept[:count]


def optimum(places: Array, weight: float = PAPER_WEIGHT) -> Array:
    """Optimal poses (N, 7) of the branch at tool positions (N, 3), whatever the limits; NaN beyond its reach."""
    places = np.asarray(places, np.float64)
    q = np.tile(SEED, (len(places), 1))
    start, goal = _cylindrical(positions(q)), _cylindrical(places)
    multipliers = _first_multipliers(q, weight)
    for share in np.linspace(0.0, 1.0, WAYPOINTS):
        waypoints = _cylinder(*(start + share * (goal - start)).T)
        q, multipliers = _newton(q, multipliers, waypoints, weight, 2)
    return _settled(q, multipliers, places, weight)


def levelled(q: Array, weight: float = PAPER_WEIGHT) -> Array:
    """The same as `optimum` at the tool positions of poses (N, 7) that are near the branch already; much faster."""
    return _settled(q, _first_multipliers(q, weight), positions(q), weight)


def kkt_residual(q: Array, places: Array, weight: float) -> Array:
    """Largest violation of stationarity and of the position, per pose."""
    values = _kkt_system(q, _first_multipliers(q, weight), places, weight)[1]
    return np.abs(values[..., 0]).max(axis=1)


def reduced_curvature(q: Array, weight: float) -> Array:
    """Smallest second derivative (N,) of J along the arm's self-motions: a minimum where it is positive."""
    matrix = _kkt_system(q, _first_multipliers(q, weight), positions(q), weight)[0]
    free = np.linalg.svd(matrix[:, JOINTS:, :JOINTS])[2][:, 3:]
    along = free @ matrix[:, :JOINTS, :JOINTS] @ free.swapaxes(1, 2)
    return np.asarray(np.linalg.eigvalsh(along)[:, 0], np.float64)


def _settled(q: Array, multipliers: Array, places: Array, weight: float) -> Array:
    q, _ = _newton(q, multipliers, places, weight, NEWTON_STEPS)
    reached = kkt_residual(q, places, weight) < CONVERGED
    return np.where(reached[:, None], q, np.nan)


def _newton(q: Array, multipliers: Array, places: Array, weight: float, steps: int) -> tuple[Array, Array]:
    """Newton on the KKT system of: minimise J subject to f(q) = x."""
    for _ in range(steps):
        step = np.linalg.solve(*_kkt_system(q, multipliers, places, weight))[..., 0]
        length = np.linalg.norm(step[:, :JOINTS], axis=1, keepdims=True)
        step *= np.minimum(1.0, LONGEST_STEP / np.maximum(length, 1e-12))
        q, multipliers = q - step[:, :JOINTS], multipliers - step[:, JOINTS:]
    return q, multipliers


def _first_multipliers(q: Array, weight: float) -> Array:
    """Multipliers (N, 3) that come nearest to stationarity."""
    pose = _Poses(q)
    gradient = pose.gradient(weight)
    normal = pose.linear @ pose.linear.swapaxes(1, 2) + 1e-12 * np.eye(3)
    return np.asarray(-np.linalg.solve(normal, pose.linear @ gradient[..., None])[..., 0], np.float64)


def _kkt_system(q: Array, multipliers: Array, places: Array, weight: float) -> tuple[Array, Array]:
    """Matrix (N, 10, 10) and right-hand side (N, 10, 1) of one Newton step."""
    pose = _Poses(q)
    matrix = np.zeros((len(q), JOINTS + 3, JOINTS + 3))
    matrix[:, :JOINTS, :JOINTS] = pose.curvature(weight, multipliers)
    matrix[:, JOINTS:, :JOINTS] = pose.linear
    matrix[:, :JOINTS, JOINTS:] = pose.linear.swapaxes(1, 2)
    stationarity = pose.gradient(weight) + np.einsum("nkj,nk->nj", pose.linear, multipliers)
    return matrix, np.concatenate([stationarity, pose.position - places], axis=1)[..., None]


_PAIRS = np.indices((JOINTS, JOINTS))


class _Poses:
    """Positions, axes and their derivatives at poses q (N, 7)."""

    def __init__(self, q: Array) -> None:
        pose, jacobian = arm().forward(q), arm().jacobian(q)
        self.q, self.position, self.linear = q, pose[:, :3], jacobian[:, :3]
        self.axes = jacobian[:, 3:].swapaxes(1, 2)
        axis = _tool_axis(pose)
        self.turned = np.cross(self.axes, axis[:, None])  # (N, 7, 3): each joint turns the tool axis
        self.first, self.second = _squared_tilt(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])

    def gradient(self, weight: float) -> Array:
        """Of J by q, (N, 7)."""
        return 2 * weight * self.q + self.first[:, None] * self.turned[..., 2]

    def curvature(self, weight: float, multipliers: Array) -> Array:
        """Second derivative of J + multipliersᵀ f, (N, 7, 7)."""
        # The joint nearer to the base turns the derivative by the other.
        inner, outer = np.minimum(*_PAIRS), np.maximum(*_PAIRS)
        rising = self.turned[..., 2]
        turned = np.cross(self.axes[:, inner], self.turned[:, outer])[..., 2]
        moved = np.cross(self.axes[:, inner], self.linear.swapaxes(1, 2)[:, outer])
        squared = self.second[:, None, None] * rising[:, :, None] * rising[:, None]
        levelled = squared + self.first[:, None, None] * turned
        return 2 * weight * np.eye(JOINTS) + levelled + np.einsum("nijk,nk->nij", moved, multipliers)


def _squared_tilt(sine: Array, cosine: Array) -> tuple[Array, Array]:
    """First and second derivative of tilt² by its cosine."""
    angle = np.arctan2(sine, cosine)
    safe = np.where(angle < FLAT, 1.0, sine)
    first = np.where(angle < FLAT, -2.0 - angle**2 / 3, -2 * angle / safe)
    second = np.where(angle < FLAT, 2.0 / 3 + 4 * angle**2 / 15, 2 * (safe - angle * cosine) / safe**3)
    return first, second


def _tool_axis(pose: Array) -> Array:
    """The z axis (..., 3) of poses (..., 7)."""
    w, x, y, z = np.moveaxis(pose[..., 3:], -1, 0)
    return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)


def _cylinder(radius: Array, azimuth: Array, height: Array) -> Array:
    return np.column_stack([radius * np.cos(azimuth), radius * np.sin(azimuth), height])


def _cylindrical(places: Array) -> Array:
    """Radius, azimuth and height (N, 3)."""
    return np.column_stack([np.hypot(*places[:, :2].T), np.arctan2(places[:, 1], places[:, 0]), places[:, 2]])
