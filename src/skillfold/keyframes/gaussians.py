"""`PoseGaussian`: where a keyframe lies, how much it may vary, and the gates around it."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skillfold.keyframes.charts import PoseChart
from skillfold.keyframes.constraint import CompiledConstraint
from skillfold.keyframes.region import PoseRegion

Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True, eq=False)
class PoseGaussian:
    """A Gaussian over poses of a tool: one block of positions, one of rotations.

    A pose belongs to it if in both blocks the squared Mahalanobis distance is within the block's gate.

    Attributes:
        mean: (7,) pose.
        covariance: (6, 6) [m², rad²] block diagonal; rotations as rotation vectors about the mean, in its axes.
        gates: (2,) squared Mahalanobis distances of position and rotation.
        count: how many keyframes it was learnt from.
    """

    mean: Array
    covariance: Array
    gates: Array
    count: float = float("nan")

    def about(self, chart: PoseChart) -> tuple[Array, Array]:
        """Mean (6,) and gated covariances (2, 3, 3) in a chart: d² ≤ 1 in both blocks is inside.

        The rotation block is carried over by the derivative of the rotation vector at the mean.
        """
        mean = chart.to_chart(self.mean)
        carry = _derivative(mean[3:])
        position, rotation = self.covariance[:3, :3], carry @ self.covariance[3:, 3:] @ carry.T
        return mean, np.array([self.gates[0] * position, self.gates[1] * rotation])

    @cached_property
    def region(self) -> PoseRegion:
        """The poses within its gates."""
        chart = PoseChart(self.mean[3:])
        mean, covariances = self.about(chart)
        return PoseRegion(chart, np.array([mean, mean]), np.array([covariances, covariances]))

    def contains(self, poses: Any, tolerance: float = 0.0) -> Any:
        """Whether poses (..., 7) are within the gates, or no farther outside than `tolerance` [m]."""
        return self.region.contains(poses, tolerance)

    def distance(self, poses: Any) -> Any:
        """Distance (...,) [m] of poses (..., 7) to the nearest within the gates; 0 inside."""
        return self.region.distance(poses)

    def project(self, poses: Any) -> Array:
        """The nearest poses (..., 7) within the gates; those inside stay as they are."""
        return self.region.project(poses)

    def sample(self, count: int, seed: int = 0) -> Array:
        """Poses (count, 7) within the gates, uniform in both blocks."""
        return self.region.sample(count, seed)

    def compiled(self) -> CompiledConstraint:
        """The same for compiled loops."""
        return self.region.compiled()


def _derivative(vector: Array) -> Array:
    """Derivative (3, 3) of the rotation vector by a turn about the body's own axes (inverse right Jacobian)."""
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    half = 0.5 * np.linalg.norm(vector)
    bend = 1.0 / 12.0 if half < 1e-4 else (1.0 - half / np.tan(half)) / (4.0 * half * half)
    return np.eye(3) + 0.5 * cross + bend * cross @ cross
