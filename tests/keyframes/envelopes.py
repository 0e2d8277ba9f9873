"""Random pose Gaussians, and plain twins of what envelopes answer, which later ones of the family may use too."""

from itertools import pairwise

import numpy as np
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize
from scipy.spatial.transform import Rotation

from skillfold.keyframes.charts import LENGTH, PoseChart
from skillfold.keyframes.gaussians import PoseGaussian
from skillfold.keyframes.region import PoseRegion

UNITS = np.repeat([1.0, LENGTH], 3)


def rotations(count, rng):
    return Rotation.from_quat(rng.normal(size=(count, 4)))


def random_poses(count, rng, spread=0.3):
    turns = rotations(count, rng).as_quat(scalar_first=True)
    return np.concatenate([rng.normal(size=(count, 3)) * spread, turns], axis=1)


def spd(rng, sizes):
    """A positive definite matrix with these standard deviations in random directions."""
    axes = rotations(1, rng)[0].as_matrix()
    return axes * np.asarray(sizes) ** 2 @ axes.T


def random_gaussian(rng, turn=1.0, thin=0.1):
    """Means within some 0.3 m and `turn` rad; standard deviations from `thin` to 1 of 5 cm and 0.3 rad."""
    covariance = np.zeros((6, 6))
    covariance[:3, :3] = spd(rng, 0.05 * thin ** rng.uniform(size=3))
    covariance[3:, 3:] = spd(rng, 0.3 * thin ** rng.uniform(size=3))
    axis = rng.normal(size=3)
    vector = axis / np.linalg.norm(axis) * rng.uniform(0, turn)
    mean = np.concatenate([rng.normal(size=3) * 0.2, Rotation.from_rotvec(vector).as_quat(scalar_first=True)])
    return PoseGaussian(mean, covariance, rng.uniform(5.0, 20.0, 2), 7)


def random_region(rng, stations):
    """A chain whose stations have nothing to do with each other."""
    chart = PoseChart(random_poses(1, rng)[0, 3:])
    covariances = [
        [spd(rng, 0.1 * 0.1 ** rng.uniform(size=3)), spd(rng, 0.1 ** rng.uniform(size=3))] for _ in range(stations)
    ]
    return PoseRegion(chart, rng.normal(size=(2, 6)) * [0.3, 0.3, 0.3, 0.5, 0.5, 0.5], np.array(covariances))


@st.composite
def pairs(draw, thin=0.05):
    """Parent and child, and a generator for whatever else a test draws."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    turn = draw(st.sampled_from([0.0, 0.3, 1.0]))
    return random_gaussian(rng, turn, thin), random_gaussian(rng, turn, thin), rng


def near(region, count, rng, spread=0.05):
    """Poses in and about a region."""
    y = region.chart.to_chart(region.sample(count, int(rng.integers(2**31))))
    return region.chart.to_pose(y + rng.normal(size=y.shape) * spread / UNITS)


def moved(gaussian, turn, shift):
    """The Gaussian after a rigid motion of everything."""
    R = turn.as_matrix()
    covariance = gaussian.covariance.copy()
    covariance[:3, :3] = R @ covariance[:3, :3] @ R.T
    return PoseGaussian(moved_poses(gaussian.mean, turn, shift), covariance, gaussian.gates, gaussian.count)


def moved_poses(poses, turn, shift):
    turns = (turn * Rotation.from_quat(poses[..., 3:].reshape(-1, 4), scalar_first=True)).as_quat(scalar_first=True)
    positions = turn.apply(poses[..., :3].reshape(-1, 3).copy()) + shift
    return np.concatenate([positions, turns], axis=1).reshape(poses.shape)


def scaled_station(region, s):
    """Mean (6,) and matrices (2, 3, 3) at s, all in metres."""
    n = len(region.covariances) - 1
    k = min(int(s * n), n - 1)
    t = s * n - k
    mean = ((1 - s) * region.ends[0] + s * region.ends[1]) * UNITS
    sigma = (1 - t) * region.covariances[k] + t * region.covariances[k + 1]
    return mean, sigma * np.array([1.0, LENGTH**2])[:, None, None]


def square_at(region, y, s):
    """d² of scaled coordinates (6,) in the worse block at s."""
    mean, sigma = scaled_station(region, s)
    v = (y - mean).reshape(2, 3)
    return max(v[b] @ np.linalg.solve(sigma[b], v[b]) for b in range(2))


def least(function, segments):
    """Least value of a function that is convex on each of equal segments of [0, 1]."""
    grid = np.linspace(0, 1, segments + 1)
    return min(golden(function, a, b) for a, b in pairwise(grid))


def golden(function, low, high):
    """Least value between low and high."""
    share = (np.sqrt(5) - 1) / 2
    inner = [high - share * (high - low), low + share * (high - low)]
    values = [function(s) for s in inner]
    found = min(function(low), function(high), *values)
    for _ in range(55):
        if values[0] < values[1]:
            high, inner[1], values[1] = inner[1], inner[0], values[0]
            inner[0] = high - share * (high - low)
            values[0] = function(inner[0])
        else:
            low, inner[0], values[0] = inner[0], inner[1], values[1]
            inner[1] = low + share * (high - low)
            values[1] = function(inner[1])
        found = min(found, *values)
    return found


def membership(region, y):
    """Least d² of scaled coordinates (6,) over the chain."""
    return least(lambda s: square_at(region, y, s), len(region.covariances) - 1)


def nearest_in_ellipsoid(sigma, v):
    """The point w nearest to v with w'Σ⁻¹w ≤ 1, by a root in the eigenbasis."""
    values, axes = np.linalg.eigh(sigma)
    a = axes.T @ v
    if (a**2 / values).sum() <= 1:
        return v
    most = np.sqrt(values.max()) * np.linalg.norm(a)
    mu = brentq(lambda mu: (values * a**2 / (values + mu) ** 2).sum() - 1, 0, most, xtol=1e-18, rtol=1e-14)
    return axes @ (values * a / (values + mu))


def slice_distance(region, y, s):
    """Distance [m] of scaled coordinates (6,) to the poses inside at s."""
    mean, sigma = scaled_station(region, s)
    v = (y - mean).reshape(2, 3)
    return np.linalg.norm([v[b] - nearest_in_ellipsoid(sigma[b], v[b]) for b in range(2)])


def solved_distance(region, y):
    """The same over the whole chain, by a solver for constrained problems that is told nothing of slices."""

    def gap(x):
        mean, sigma = scaled_station(region, x[6])
        return mean + np.einsum("bij,bj->bi", np.linalg.cholesky(sigma), x[:6].reshape(2, 3)).ravel() - y

    inside = {"type": "ineq", "fun": lambda x: 1 - (x[:6].reshape(2, 3) ** 2).sum(1)}
    bounds = [(-1, 1)] * 6 + [(0, 1)]
    found = []
    for s in (0.05, 0.5, 0.95):
        start = np.append(np.zeros(6), s)
        options = {"ftol": 1e-15, "maxiter": 400}
        solution = minimize(lambda x: (gap(x) ** 2).sum(), start, bounds=bounds, constraints=inside, options=options)
        if inside["fun"](solution.x).min() > -1e-9:
            found.append(np.linalg.norm(gap(np.clip(solution.x, *np.transpose(bounds)))))
    return min(found)
