"""The protocol for skills learnt from whole demonstrations: leave one out, plan its motion, compare.

Pure functions. Paths are (n_points, n_dims); `unit=True` marks paths of unit quaternions, whose means and
interpolations are put back on the unit sphere. Phase is the share of the arc length.
"""

from collections.abc import Sequence

import numpy as np

from skillfold.motion import Array

POINTS = 100


def resample(states: Array, points: int = POINTS, unit: bool = False) -> Array:
    """`points` states at equal arc length along the polyline through `states`; ends kept exactly."""
    steps = np.linalg.norm(np.diff(states, axis=0), axis=1)
    phase = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.linspace(0.0, phase[-1], points)
    columns = [np.interp(wanted, phase, column) for column in np.asarray(states, float).T]
    return _on_sphere(np.column_stack(columns), unit)


def straight_line(start: Array, goal: Array, points: int = POINTS, unit: bool = False) -> Array:
    """States on the line from start to goal: what needs no demonstrations at all."""
    phase = np.linspace(0.0, 1.0, points)[:, None]
    return _on_sphere((1 - phase) * start + phase * goal, unit)


def corrected_mean(
    others: Sequence[Array], start: Array, goal: Array, points: int = POINTS, unit: bool = False
) -> Array:
    """Mean of the demonstrations at equal phase, moved to the given ends by a correction linear in phase."""
    mean = np.mean([resample(other, points, unit) for other in others], axis=0)
    phase = np.linspace(0.0, 1.0, points)[:, None]
    return _on_sphere(mean + (1 - phase) * (start - mean[0]) + phase * (goal - mean[-1]), unit)


def located_mean(
    others: Sequence[Array], start: Array, goal: Array, points: int = POINTS, unit: bool = False
) -> Array:
    """`corrected_mean` of the stretches of the demonstrations that pass nearest to start and goal."""
    return corrected_mean([located(other, start, goal) for other in others], start, goal, points, unit)


def located(path: Array, start: Array, goal: Array, shortest: float = 0.1) -> Array:
    """The stretch of `path`, `shortest` of its states or longer, whose ends lie nearest to start and goal."""
    gap = max(1, round(shortest * (len(path) - 1)))
    to_start = np.sum((path[:-gap] - start) ** 2, axis=1)
    to_goal = np.sum((path[gap:] - goal) ** 2, axis=1)
    best_so_far = np.minimum.accumulate(to_start)
    last = int(np.argmin(best_so_far + to_goal))
    first = int(np.argmin(to_start[: last + 1]))
    return path[first : last + gap + 1]


def random_stretch(path: Array, rng: np.random.Generator, shares: tuple[float, float] = (0.3, 0.7)) -> Array:
    """A contiguous part of `path`, its share of the states uniform in `shares`, its place uniform."""
    length = max(2, round(rng.uniform(*shares) * len(path)))
    first = int(rng.integers(0, len(path) - length + 1))
    return path[first : first + length]


def distance_between(path: Array, truth: Array, points: int = POINTS, unit: bool = False) -> float:
    """Mean over phase of the distance between the two paths' points at equal phase."""
    gaps = resample(path, points, unit) - resample(truth, points, unit)
    return float(np.linalg.norm(gaps, axis=1).mean())


def nearest_distance(path: Array, truth: Array, points: int = POINTS, unit: bool = False) -> float:
    """Mean distance from the points of each path to the nearest of the other, both directions averaged."""
    a, b = resample(path, points, unit), resample(truth, points, unit)
    gaps = np.linalg.norm(a[:, None] - b[None], axis=2)
    return float((gaps.min(axis=0).mean() + gaps.min(axis=1).mean()) / 2)


def geometric_mean(ratios: Sequence[float] | Array) -> float:
    """Exponential of the mean logarithm."""
    return float(np.exp(np.mean(np.log(np.asarray(ratios, float)))))


def _on_sphere(states: Array, unit: bool) -> Array:
    return states / np.linalg.norm(states, axis=1, keepdims=True) if unit else states
