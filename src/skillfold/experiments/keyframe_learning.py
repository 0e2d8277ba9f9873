"""Learning keyframe skills from seven demonstrations: what the gates hold, and how often the keyframes are found."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from skillfold.motion import Array

AXES = (0.005, 0.04)  # [m] standard deviations of positions, and
TURNS = (0.03, 0.3)  # [rad] of rotations about a keyframe, log-uniform along each axis
ROOM = np.array([0.6, 0.6, 0.4])  # [m] that keyframes lie in
APART = 0.15  # [m] between consecutive keyframes at least, a radian as 0.15 m
RETURNS = 1 / 3  # share of the skills whose last keyframe is near the first
QUANTILE = 9.348  # of χ² with 3 degrees of freedom at 97.5 %


@dataclass(frozen=True)
class Truth:
    """A skill to draw demonstrations from: keyframes with positions, rotation matrices and square roots of Σ."""

    positions: Array
    rotations: Array
    roots: Array
    """(K, 2, 3, 3)"""

    def draw(self, k: int, rng: np.random.Generator) -> Array:
        """A pose (7,) of keyframe k, its quaternion of either sign."""
        moved, turned = self.roots[k] @ rng.standard_normal((2, 3, 1))
        return pose(self.positions[k] + moved[:, 0], self.rotations[k] @ matrix(turned[:, 0]), rng)

    def holds(self, k: int, given: Array) -> bool:
        """Whether a pose lies in the 97.5 % region of keyframe k, in both blocks."""
        moved = given[:3] - self.positions[k]
        turned = vector(self.rotations[k].T @ matrix_of(given[3:]))
        parts = [np.linalg.solve(root, v) for root, v in zip(self.roots[k], (moved, turned), strict=True)]
        return all(float(v @ v) <= QUANTILE for v in parts)


def random_truth(rng: np.random.Generator, count: int = 4) -> Truth:
    """Keyframes anywhere in the room, each turned up to 1 rad from the one before; some skills return."""
    while True:
        positions = rng.uniform(0, 1, (count, 3)) * ROOM
        steps = [matrix(v * rng.uniform(0, 1)) for v in _directions(count, rng)]
        rotations = np.array([steps[0]] * count)
        for k in range(1, count):
            rotations[k] = rotations[k - 1] @ steps[k]
        if rng.uniform() < RETURNS:
            positions[-1] = positions[0] + rng.normal(0, 0.01, 3)
            rotations[-1] = rotations[0] @ matrix(rng.normal(0, 0.05, 3))
        roots = np.array([[_root(AXES, rng), _root(TURNS, rng)] for _ in range(count)])
        turned = [np.linalg.norm(vector(a.T @ b)) for a, b in pairwise(rotations)]
        if (np.hypot(np.linalg.norm(np.diff(positions, axis=0), axis=1), 0.15 * np.array(turned)) > APART).all():
            return Truth(positions, rotations, roots)


def demonstrate(truth: Truth, demos: int, missing: float, extra: float, rng: np.random.Generator) -> list[Array]:
    """Keyframes (m, 7) of each demonstration.

    Each keyframe is left out with probability `missing`, and after each comes, with probability `extra`, one that
    the skill has not: somewhere on the way to the next, 5 cm and 0.5 rad off it (standard deviations).
    """
    made = []
    while len(made) < demos:
        rows = []
        for k in range(len(truth.positions)):
            if rng.uniform() >= missing:
                rows.append(truth.draw(k, rng))
            if rng.uniform() < extra:
                rows.append(_astray(truth, k, rng))
        if rows:
            made.append(np.array(rows))
    return made


def recovered(truth: Truth, means: Any) -> bool:
    """Whether there are as many Gaussians as keyframes, the mean of each in the region of its keyframe, in order."""
    return len(means) == len(truth.positions) and all(truth.holds(k, np.asarray(m)) for k, m in enumerate(means))


def _astray(truth: Truth, k: int, rng: np.random.Generator) -> Array:
    share, after = rng.uniform(), min(k + 1, len(truth.positions) - 1)
    position = (1 - share) * truth.positions[k] + share * truth.positions[after] + rng.normal(0, 0.05, 3)
    between = matrix(share * vector(truth.rotations[k].T @ truth.rotations[after]))
    return pose(position, truth.rotations[k] @ between @ matrix(rng.normal(0, 0.5, 3)), rng)


def _directions(count: int, rng: np.random.Generator) -> Array:
    directions = rng.standard_normal((count, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def _root(between: tuple[float, float], rng: np.random.Generator) -> Array:
    """Square root (3, 3) of a covariance with random axes."""
    axes = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    return axes * np.exp(rng.uniform(*np.log(between), 3))


def matrix(turned: Array) -> Array:
    """Rotation matrix of a rotation vector."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(turned).as_matrix()


def matrix_of(quaternion: Array) -> Array:
    """Rotation matrix of a quaternion, scalar first."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(quaternion, scalar_first=True).as_matrix()


def vector(rotation: Array) -> Array:
    """Rotation vector of a matrix."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_rotvec()


def pose(position: Array, rotation: Array, rng: np.random.Generator) -> Array:
    """Pose (7,), its quaternion of random sign."""
    from scipy.spatial.transform import Rotation

    quaternion = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
    return np.concatenate([position, quaternion * rng.choice([-1.0, 1.0])])
