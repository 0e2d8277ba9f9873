"""Learning keyframe skills from seven demonstrations: what the gates hold, and how often the keyframes are found.

Skills are drawn at random and know nothing of how they are learnt: their poses are rotation matrices, and whether a
pose lies in a keyframe's region is told by the truth's own covariance.
"""

import warnings
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from skillfold.experiments.parallel import in_parallel
from skillfold.experiments.rows import Row, Settings
from skillfold.keyframes.gaussians import PoseGaussian
from skillfold.keyframes.skill import KeyframeSkill
from skillfold.motion import Array

AXES = (0.005, 0.04)  # [m] standard deviations of positions, and
TURNS = (0.03, 0.3)  # [rad] of rotations about a keyframe, log-uniform along each axis
ROOM = np.array([0.6, 0.6, 0.4])  # [m] that keyframes lie in
APART = 0.15  # [m] between consecutive keyframes at least, a radian as 0.15 m
RETURNS = 1 / 3  # share of the skills whose last keyframe is near the first
QUANTILE = 9.348  # of χ² with 3 degrees of freedom at 97.5 %


DEMONSTRATIONS, KEYFRAMES = 7, 4
NOMINAL = 0.975


@dataclass(frozen=True)
class Counts:
    """How many skills of each kind, and how many further poses of each keyframe tell what its gates hold."""

    skills: int = 100
    poses: int = 50


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


def measure(settings: Settings, counts: Counts | None = None) -> list[Row]:
    """All rows; every skill counts, also one whose fit fails."""
    counts = counts or Counts()
    kinds = {"clean": (0.0, 0.0), "15 % missing": (0.15, 0.0), "15 % extra": (0.0, 0.15), "both": (0.15, 0.15)}
    rows = measure_gates(settings, counts)
    for k, (name, shares) in enumerate(kinds.items(), 1):
        cases = [(settings.seed, i, *shares) for i in range(counts.skills)]
        between = (k / (len(kinds) + 1), (k + 1) / (len(kinds) + 1))
        found = list(in_parallel(_found, cases, settings.progress, f"keyframes, {name}", between))
        right, numbers = np.mean(found, axis=0)
        note = f"{counts.skills} skills; the right number of keyframes in {numbers:.2f}"
        target = 0.97 if name == "clean" else 0.9
        rows.append(Row(f"keyframes recovered, {name}", float(right), "", target, ">=", note=note))
    return rows


def measure_gates(settings: Settings, counts: Counts) -> list[Row]:
    """How far from nominal is the share of further poses within the gates, learnt from seven demonstrations."""
    cases = [(settings.seed, i, counts.poses) for i in range(counts.skills)]
    found = in_parallel(_held, cases, settings.progress, "gates", (0.0, 0.2))
    inside = [shares for some in found for shares in some]
    shares = np.mean(inside, axis=(0, 1))
    note = f"{len(inside)} Gaussians, {counts.poses} further poses each; held"
    return [
        Row(f"gate coverage off nominal, {block}", 100 * abs(s - NOMINAL), "points", 2.0, note=f"{note} {s:.3f}")
        for block, s in zip(("position", "rotation"), shares.tolist(), strict=True)
    ]


def _held(seed: int, i: int, poses: int) -> list[list[list[bool]]]:
    """Of a random skill's Gaussians, whether each further pose is within the gates."""
    rng = np.random.default_rng([seed, 1, i])
    truth = random_truth(rng)
    skill = KeyframeSkill.fit(demonstrate(truth, DEMONSTRATIONS, 0.0, 0.0, rng), KEYFRAMES)
    return [
        [within(gaussian, truth.draw(k, rng)) for _ in range(poses)] for k, gaussian in enumerate(skill.gaussians)
    ]


def within(gaussian: PoseGaussian, given: Array) -> list[bool]:
    """Whether a pose is within the gates of position and rotation."""
    moved = given[:3] - gaussian.mean[:3]
    turned = vector(matrix_of(gaussian.mean[3:]).T @ matrix_of(given[3:]))
    blocks = gaussian.covariance[:3, :3], gaussian.covariance[3:, 3:]
    parts = zip((moved, turned), blocks, gaussian.gates, strict=True)
    return [float(v @ np.linalg.solve(block, v)) <= gate for v, block, gate in parts]


def _found(seed: int, i: int, missing: float, extra: float) -> tuple[bool, bool]:
    """Whether a random skill is recovered, and whether the number of its keyframes is."""
    rng = np.random.default_rng([seed, 2, i])
    truth = random_truth(rng)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of places with few keyframes
        skill = KeyframeSkill.fit(demonstrate(truth, DEMONSTRATIONS, missing, extra, rng))
    return recovered(truth, [g.mean for g in skill.gaussians]), skill.n_keyframes == KEYFRAMES


def random_truth(rng: np.random.Generator, count: int = KEYFRAMES) -> Truth:
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
    return axes * np.exp(rng.uniform(np.log(between[0]), np.log(between[1]), 3))


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
