"""Section V-A and V-B of paper 000: a planar three-link arm that resolves its redundancy by a quadratic cost.

The truth is computed here and nowhere else: at an end-effector position the optimal pose is found by a scan
over the end link's angle and both elbows, then by Newton steps on the Karush-Kuhn-Tucker (KKT) system, for
all positions at once. Angles in radians, lengths in metres; `positions` are (..., 2), `joints` (..., 3).
"""

from dataclasses import dataclass

import numpy as np

from skillfold.motion import Array

LINK = 1.0 / 3.0
SCAN_ANGLES = 240
NEWTON_STEPS = 12
CHUNK = 4000
EDGE, STAGES = 1e-6, 10  # m above the x axis; of the way below it
JUMP, FOLLOWED = 1.0, 1e-8  # rad in one stage; KKT residual


@dataclass(frozen=True)
class Redundancy:
    """The cost Σ (wᵢ (qᵢ − cᵢ))² that picks one pose of those that reach a position (Equations 12, 15)."""

    convenience: tuple[float, float, float]
    weights: tuple[float, float, float]

    def cost(self, joints: Array) -> Array:
        """Cost of each pose."""
        return np.sum((np.array(self.weights) * (joints - np.array(self.convenience))) ** 2, axis=-1)

    def gradient(self, joints: Array) -> Array:
        """Derivative of the cost, (..., 3)."""
        return 2 * np.array(self.weights) ** 2 * (joints - np.array(self.convenience))


REACHING = Redundancy((-np.pi / 3, np.pi / 3, np.pi / 3), (1.0, 1.0, 1.0))
WEIGHTED_REACHING = Redundancy((0.0, 0.0, 0.0), (4.0, 2.0, 1.0))


def forward(joints: Array) -> Array:
    """End-effector positions (..., 2) of poses (..., 3)."""
    angles = np.cumsum(joints, axis=-1)
    return LINK * np.stack([np.cos(angles).sum(-1), np.sin(angles).sum(-1)], axis=-1)


def jacobian(joints: Array) -> Array:
    """(..., 2, 3) derivative of `forward`."""
    angles = np.cumsum(joints, axis=-1)
    # Joint j moves every link from j on: sums over the links behind it.
    rows = [np.flip(np.cumsum(np.flip(part, -1), -1), -1) for part in (-np.sin(angles), np.cos(angles))]
    return LINK * np.stack(rows, axis=-2)


def optimal(positions: Array, redundancy: Redundancy) -> Array:
    """Globally optimal poses (N, 3) at end-effector positions (N, 2); NaN where the arm cannot reach."""
    pieces = [positions[i : i + CHUNK] for i in range(0, len(positions), CHUNK)]
    return np.concatenate([_newton(_scan(piece, redundancy), piece, redundancy) for piece in pieces])


def followed(positions: Array, redundancy: Redundancy) -> Array:
    """Poses (N, 3) of the branch that is optimal above the x axis, followed below it; NaN where it ends.

    There its mirror image is optimal, which skills shown only poses above cannot know.
    """
    above = np.column_stack([positions[:, 0], np.maximum(positions[:, 1], EDGE)])
    poses = optimal(above, redundancy)
    below = np.flatnonzero(positions[:, 1] < EDGE)
    q, first, last = poses[below], above[below], positions[below]
    for share in np.linspace(0.0, 1.0, 1 + STAGES)[1:]:
        before, q = q, _newton(q, first + share * (last - first), redundancy)
        q[np.linalg.norm(q - before, axis=1) > JUMP] = np.nan
    found = (kkt_residual(q, last, redundancy) < FOLLOWED) & (_reduced_curvature(q, redundancy) > 0)
    poses[below] = np.where(found[:, None], q, np.nan)
    return poses


def kkt_residual(joints: Array, positions: Array, redundancy: Redundancy) -> Array:
    """Largest violation of stationarity and of the position, per pose."""
    gradient = redundancy.gradient(joints)
    J = jacobian(joints)
    normal = J @ np.swapaxes(J, -1, -2)
    multipliers = np.linalg.solve(normal, J @ gradient[..., None])
    stationarity = gradient - (np.swapaxes(J, -1, -2) @ multipliers)[..., 0]
    position_error = forward(joints) - positions
    return np.maximum(np.abs(stationarity).max(-1), np.abs(position_error).max(-1))


def _scan(positions: Array, redundancy: Redundancy) -> Array:
    """The best pose over a grid of end-link angles and both elbows, (N, 3)."""
    end = _end_angles(positions)
    wrist = positions[:, None] - LINK * np.stack([np.cos(end), np.sin(end)], axis=-1)
    cos_elbow = np.sum(wrist**2, axis=-1) / (2 * LINK**2) - 1.0
    elbow = np.arccos(np.clip(cos_elbow, -1.0, 1.0))
    elbow = np.stack([elbow, -elbow])
    # With equal links the wrist's direction halves the elbow angle.
    shoulder = np.arctan2(wrist[..., 1], wrist[..., 0]) - elbow / 2
    candidates = np.stack([shoulder, elbow, end - shoulder - elbow], axis=-1)
    candidates = _nearest_turn(candidates, np.array(redundancy.convenience))
    cost = np.where(np.abs(cos_elbow) <= 1.0, redundancy.cost(candidates), np.inf)
    both = np.moveaxis(candidates, 1, 0).reshape(len(positions), -1, 3)
    costs = np.moveaxis(cost, 1, 0).reshape(len(positions), -1)
    best = both[np.arange(len(both)), np.argmin(costs, axis=1)]
    return np.where(np.isfinite(costs.min(axis=1))[:, None], best, np.nan)


def _end_angles(positions: Array) -> Array:
    """(N, SCAN_ANGLES) end-link angles that leave the wrist in reach; a narrow window near full reach."""
    reach = np.maximum(np.linalg.norm(positions, axis=-1), 1e-12)
    limit = np.arccos(np.clip((reach**2 - 3 * LINK**2) / (2 * reach * LINK), -1.0, 1.0))
    direction = np.arctan2(positions[:, 1], positions[:, 0])
    # Inside the window, never on its edge: there the arm is stretched and both elbows coincide.
    return direction[:, None] + limit[:, None] * np.linspace(-1, 1, SCAN_ANGLES + 2)[1:-1]


def _nearest_turn(joints: Array, centre: Array) -> Array:
    """The same pose with every joint within half a turn of `centre`."""
    return centre + np.remainder(joints - centre + np.pi, 2 * np.pi) - np.pi


def _newton(joints: Array, positions: Array, redundancy: Redundancy) -> Array:
    """Newton on the KKT system of: minimise the cost subject to forward(q) = position."""
    q = joints.copy()
    multipliers = _first_multipliers(q, redundancy)
    for _ in range(NEWTON_STEPS):
        step = np.linalg.solve(*_kkt_system(q, multipliers, positions, redundancy))[..., 0]
        q -= step[:, :3]
        multipliers -= step[:, 3:]
    return q


def _reduced_curvature(q: Array, redundancy: Redundancy) -> Array:
    """Second derivative (N,) of the cost along the arm's self-motion: a minimum where it is positive."""
    J = jacobian(q)
    free = np.cross(J[:, 0], J[:, 1])
    whole = 2 * np.diag(np.array(redundancy.weights) ** 2) + _curvature(q, _first_multipliers(q, redundancy))
    return np.einsum("ni,nij,nj->n", free, whole, free)


def _first_multipliers(q: Array, redundancy: Redundancy) -> Array:
    J = jacobian(q)
    normal = J @ np.swapaxes(J, -1, -2) + 1e-9 * np.eye(2)
    return np.einsum("nij,njk,nk->ni", -np.linalg.inv(normal), J, redundancy.gradient(q))


def _kkt_system(q: Array, multipliers: Array, positions: Array, redundancy: Redundancy) -> tuple[Array, Array]:
    """Matrix (N, 5, 5) and right-hand side (N, 5, 1) of one Newton step."""
    J = jacobian(q)
    matrix = np.zeros((len(q), 5, 5))
    matrix[:, :3, :3] = np.diag(2 * np.array(redundancy.weights) ** 2) + _curvature(q, multipliers)
    matrix[:, 3:, :3] = J
    matrix[:, :3, 3:] = np.swapaxes(J, -1, -2)
    stationarity = redundancy.gradient(q) + np.einsum("nkj,nk->nj", J, multipliers)
    return matrix, np.concatenate([stationarity, forward(q) - positions], axis=1)[..., None]


def _curvature(q: Array, multipliers: Array) -> Array:
    """Second derivative of multipliersᵀ forward(q), (N, 3, 3)."""
    angles = np.cumsum(q, axis=-1)
    pull = -LINK * (multipliers[:, :1] * np.cos(angles) + multipliers[:, 1:] * np.sin(angles))
    behind = np.flip(np.cumsum(np.flip(pull, -1), -1), -1)
    # Entry (i, j) sums over the links behind both joints.
    later = np.maximum.outer(np.arange(3), np.arange(3))
    return behind[:, later]
