"""From a few keyframes to a pose Gaussian whose gates hold new keyframes as often as they promise."""

from functools import lru_cache
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.keyframes.gaussians import PoseGaussian
from skillfold.robots.poses import read_pose

Array = np.ndarray[Any, np.dtype[np.float64]]

COVERAGE = 0.975
FLOORS = (1e-3, 5e-3)  # [m], [rad]: no direction is known better than by this standard deviation
FEWEST = 3  # keyframes that gates are calibrated for
MANY = 60  # with as many, gates hardly change any more
_DRAWS = 40_000
_SHAPES = ((1.0, 1.0, 1.0), (1.0, 1.0, 0.1), (1.0, 0.1, 0.1))  # standard deviations: ball, disc, needle


def estimate(poses: Any, coverage: float = COVERAGE) -> PoseGaussian:
    """Gaussian over poses from keyframes (n, 7) of one place in a skill (section II-A).

    Mean rotation and rotation vectors about it, one covariance for positions and one for rotations. Their
    eigenvalues are drawn together on a logarithmic scale by the share 1.75 / n, so that seven keyframes still tell a
    disc from a ball, and none falls below 1 mm or 0.005 rad. The gates are such that a further keyframe of the same
    place is inside each block with probability `coverage`: quantiles of the squared distance of a new draw from a
    Gaussian so estimated, drawn over balls, discs and needles (1 : 0.1). The χ² gate, which takes the covariance as
    known, holds 70 % at n = 7 where 97.5 % are asked for; these hold 96.5–98.5 % from three keyframes on, at 1.65
    times the linear size of the true region for n = 7 (Hotelling's gate on the raw covariance: 1.9), 2.7 for 4, 3.8
    for 3. One or two keyframes get the gates of three, and less coverage.

    Raises:
        InputError: no poses, or a coverage outside 0.5 to 0.999.
    """
    from scipy.spatial.transform import Rotation

    poses = read_pose(poses, "keyframes")
    if poses.ndim != 2 or not len(poses):
        raise InputError(f"keyframes: shape {poses.shape}; expected poses (n, 7), one at least.")
    turns = Rotation.from_quat(poses[:, 3:], scalar_first=True)
    middle = turns.mean()
    centre = poses[:, :3].mean(0)
    vectors = (middle.inv() * turns).as_rotvec()
    covariance = np.zeros((6, 6))
    covariance[:3, :3] = shrunk(poses[:, :3] - centre, FLOORS[0])
    covariance[3:, 3:] = shrunk(vectors - vectors.mean(0), FLOORS[1])
    gates = np.full(2, gate(min(len(poses), MANY), read_coverage(coverage)))
    mean = np.concatenate([centre, middle.as_quat(canonical=True, scalar_first=True)])
    return PoseGaussian(mean, covariance, gates, float(len(poses)))


def read_coverage(coverage: Any) -> float:
    """The coverage, if it is a share.

    Raises:
        InputError: it is not.
    """
    real = isinstance(coverage, int | float | np.floating) and not isinstance(coverage, bool)
    if not real or not 0.5 <= coverage <= 0.999:
        raise InputError(f"coverage={coverage!r:.40}; expected a share from 0.5 to 0.999, such as 0.975.")
    return float(coverage)


def shrunk(differences: Array, floor: float) -> Array:
    """Covariance (..., 3, 3) of differences (..., n, 3) from their mean, shrunk for so few."""
    count = differences.shape[-2]
    raw = differences.swapaxes(-1, -2) @ differences / max(count - 1, 1)
    values, axes = np.linalg.eigh(raw)
    values = np.maximum(_drawn_together(values, count), floor**2)
    return (axes * values[..., None, :]) @ axes.swapaxes(-1, -2)


def _drawn_together(values: Array, count: int) -> Array:
    """Eigenvalues (..., 3) nearer to their mean.

    A little on the linear scale, for those of fewer keyframes than directions are zero, then on the logarithmic one,
    where balls, discs and needles need the same gate. Shares found by simulation: smallest regions of that coverage.
    """
    linear = min(0.3, 0.1 * 0.3 ** (count - FEWEST))
    values = (1 - linear) * values + linear * values.mean(-1, keepdims=True)
    logarithms = np.log(np.maximum(values, 1e-300))
    share = min(0.4, 1.75 / count)
    return np.exp((1 - share) * logarithms + share * logarithms.mean(-1, keepdims=True))


@lru_cache(maxsize=256)
def gate(count: int, coverage: float) -> float:
    """Squared distance within which a new draw falls with probability `coverage`, from Gaussians of `count` draws."""
    rng = np.random.default_rng(count)
    distances = [_of_new_draws(max(count, FEWEST), np.array(shape), rng) for shape in _SHAPES]
    return float(np.quantile(np.concatenate(distances), coverage))


def _of_new_draws(count: int, shape: Array, rng: np.random.Generator) -> Array:
    seen = shape * rng.standard_normal((_DRAWS // count, count, 3))
    centre = seen.mean(1, keepdims=True)
    covariance = shrunk(seen - centre, 0.0)
    new = shape * rng.standard_normal((len(seen), count, 3)) - centre
    return np.einsum("nik,nik->ni", new, np.linalg.solve(covariance, new.swapaxes(1, 2)).swapaxes(1, 2)).ravel()
