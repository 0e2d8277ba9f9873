"""`PoseRegion`: a chain of ellipsoids in a chart of poses, which Gaussians and envelopes are made of."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.keyframes import compiled
from skillfold.keyframes.charts import LENGTH, PoseChart
from skillfold.keyframes.constraint import CompiledConstraint, generator
from skillfold.keyframes.kernels import chains, envelope
from skillfold.keyframes.stations import UNITS
from skillfold.robots.poses import read_numbers, read_pose
from skillfold.tables import Table, table_of

Array = np.ndarray[Any, np.dtype[np.float64]]

UPPER = np.triu_indices(3)
PLACES = "places between the ends, 0 to 1"


@dataclass(frozen=True, eq=False)
class PoseRegion:
    """Poses within reach of a straight line of means: in both blocks, position and rotation, v'Σ⁻¹v ≤ 1 somewhere.

    Along the line, at s from 0 to 1, means go straight from the first to the last, and matrices Σ straight between
    stations at equal distances.

    Attributes:
        chart: of the coordinates.
        ends: (2, 6) means at s = 0 and 1 [m, rad].
        covariances: (n + 1, 2, 3, 3) gated covariances Σ [m², rad²] of position and rotation at the stations.
    """

    chart: PoseChart
    ends: Array
    covariances: Array

    def membership(self, poses: Any) -> tuple[Any, Any]:
        """Least d² (...,) of poses (..., 7) in gates, 1 at the edge, and the place s (...,) along the line."""
        poses = _read(poses)
        rows = poses.reshape(-1, 7)
        squares, places = np.empty(len(rows)), np.empty(len(rows))
        envelope.memberships(rows, self._table.entries, squares, places)
        return _shaped(squares, poses), _shaped(places, poses)

    def place(self, poses: Any) -> Any:
        """The place s (...,) along the line, from 0 to 1, at which poses (..., 7) are deepest inside."""
        return self.membership(poses)[1]

    def contains(self, poses: Any, tolerance: float = 0.0) -> Any:
        """Whether poses (..., 7) are inside, or no farther outside than `tolerance` [m]."""
        if tolerance <= 0.0:
            return self.membership(poses)[0] <= 1.0
        return self.distance(poses) <= tolerance

    def distance(self, poses: Any) -> Any:
        """Distance (...,) [m] of poses (..., 7) to the nearest inside, a radian as `LENGTH` metres; 0 inside."""
        return self._projected(poses)[1]

    def project(self, poses: Any) -> Array:
        """The nearest poses (..., 7) inside; those inside stay as they are."""
        return self._projected(poses)[0]

    def sample(self, count: int, seed: int = 0) -> Array:
        """Poses (count, 7) inside: uniform in s, and in the ellipsoids there (algorithm 5, lines 4 to 15)."""
        rng = generator(count, seed)
        s = rng.uniform(size=count)
        steps = rng.normal(size=(count, 2, 3))
        lengths = np.linalg.norm(steps, axis=-1, keepdims=True)
        steps *= envelope.INSIDE * rng.uniform(size=(count, 2, 1)) ** (1 / 3) / lengths
        factors = np.linalg.cholesky(self.covariances_at(s))
        means, steps = self.means_at(s), np.einsum("nbij,nbj->nbi", factors, steps).reshape(count, 6)
        steps[:, 3:] *= _covered(means[:, 3:], steps[:, 3:], rng)
        return self.chart.to_pose(means + steps)

    @property
    def axis(self) -> Array:
        """The way (6,) from the first mean to the last, in the chart [m, rad]."""
        return self.ends[1] - self.ends[0]

    def at(self, s: Any) -> tuple[Array, Array]:
        """Mean poses (..., 7) and gated covariances (..., 2, 3, 3) at places s (...,) from 0 to 1."""
        s = np.clip(read_numbers(s, "s", "places from 0 to 1"), 0.0, 1.0)
        return self.chart.to_pose(self.means_at(s)), self.covariances_at(s)

    def slice(self, s: float) -> "PoseRegion":
        """The poses inside at one place s alone: 1 is where an envelope ends."""
        place = np.clip(read_numbers(s, "s", "one place from 0 to 1"), 0.0, 1.0)
        if place.shape != ():
            raise InputError(f"s: shape {place.shape}; expected one place from 0 to 1.")
        mean, covariances = self.means_at(place), self.covariances_at(place)
        return PoseRegion(self.chart, np.array([mean, mean]), np.array([covariances, covariances]))

    def means_at(self, s: Any) -> Array:
        """Means (..., 6) in the chart at places s (...,)."""
        s = read_numbers(s, "s", PLACES)[..., None]
        return (1.0 - s) * self.ends[0] + s * self.ends[1]

    def covariances_at(self, s: Any) -> Array:
        """Gated covariances (..., 2, 3, 3) at places s (...,)."""
        n = len(self.covariances) - 1
        x = read_numbers(s, "s", PLACES) * n
        k = np.clip(x, 0, n - 1).astype(int)
        t = (x - k)[..., None, None, None]
        return (1.0 - t) * self.covariances[k] + t * self.covariances[k + 1]

    def compiled(self) -> CompiledConstraint:
        """The same for compiled loops; its excess is √d² - 1 in gates."""
        return compiled.compiled_chain(self._table)

    def _projected(self, poses: Any) -> tuple[Array, Any]:
        poses = _read(poses)
        rows = poses.reshape(-1, 7)
        out, distances = np.empty_like(rows), np.empty(len(rows))
        envelope.projections(rows, self._table.entries, out, distances)
        return out.reshape(poses.shape), _shaped(distances, poses)

    @cached_property
    def _table(self) -> Table:
        units = np.repeat([1.0, LENGTH], 3)
        ends, stations = self.ends * units, self.covariances * UNITS
        axis = ends[1] - ends[0]
        return table_of(
            {
                chains.MIDDLE: self.chart.middle,
                chains.START: ends[0],
                chains.AXIS: axis,
                chains.STATIONS: stations[:, :, UPPER[0], UPPER[1]].reshape(-1, 12),
                chains.SEGMENTS: _segments(np.linspace(ends[0], ends[1], len(stations)), stations),
                chains.REACHES: _reaches(axis, stations),
            },
            chains.SLOTS,
        )


def _covered(means: Array, steps: Array, rng: np.random.Generator) -> Array:
    """Factors (n, 1) that keep steps (n, 3) from means within half a turn: 1 for those that are, else random."""
    limit = envelope.HALF_TURN / LENGTH
    far = np.linalg.norm(means + steps, axis=1) > limit
    factors, mean, step = np.ones((len(means), 1)), means[far], steps[far]
    a, b = (step**2).sum(1), (mean * step).sum(1)
    reach = (np.sqrt(b * b - a * ((mean**2).sum(1) - limit**2)) - b) / a
    factors[far, 0] = reach * rng.uniform(size=len(reach)) ** (1 / 3)
    return factors


def _segments(means: Array, stations: Array) -> Array:
    """Simultaneous diagonalisation of the matrices at the ends of each segment, (n, 36), see `chains.block_of`."""
    means = means.reshape(-1, 2, 3, 1)
    inverses = np.linalg.inv(np.linalg.cholesky(stations[:-1]))
    ratios, turns = np.linalg.eigh(inverses @ stations[1:] @ np.swapaxes(inverses, -1, -2))
    whiten = np.swapaxes(turns, -1, -2) @ inverses
    offsets, steps = whiten @ means[:-1], whiten @ (means[1:] - means[:-1])
    parts = whiten.reshape(*ratios.shape[:-1], 9), offsets[..., 0], steps[..., 0], ratios
    return np.asarray(np.concatenate(parts, axis=-1), np.float64).reshape(len(ratios), -1)


def _reaches(axis: Array, stations: Array) -> Array:
    """Least d² (n, 2) per squared difference in s along the axis of each block; 0 where it has no length."""
    axes = axis.reshape(2, 3)
    along = np.einsum("bi,kbij,bj->kb", axes, stations, axes)
    lengths = (axes**2).sum(1) ** 2
    widest = np.maximum(np.maximum(along[1:], along[:-1]), 1e-300)
    return np.asarray(np.where(lengths > 0.0, lengths / widest, 0.0), np.float64)


def _read(poses: Any) -> Array:
    read = read_pose(poses, "poses")
    if read.size == 0 and read.ndim < 2:
        raise InputError("poses: none given; expected poses (..., 7).")
    return np.ascontiguousarray(read)


def _shaped(values: Array, poses: Array) -> Any:
    return values.reshape(poses.shape[:-1])[()]
