"""`PoseGaussian`: where a keyframe lies, how much it may vary, and the gates around it."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.keyframes.charts import PoseChart
from skillfold.keyframes.constraint import CompiledConstraint
from skillfold.keyframes.region import PoseRegion
from skillfold.robots.poses import read_numbers, read_pose

Array = np.ndarray[Any, np.dtype[np.float64]]


CHI_SQUARED = (9.348, 9.348)  # holds 97.5 % where the covariance is known, in three dimensions
BLOCKS = (slice(0, 3), slice(3, 6))
THINNEST = 1e-10  # smallest to largest variance of a block: thinner ones would be lost in rounding


@dataclass(frozen=True, eq=False, repr=False)
class PoseGaussian:
    """A Gaussian over poses of a tool: one block of positions, one of rotations.

    A pose belongs to it if in both blocks the squared Mahalanobis distance is within the block's gate.

    Attributes:
        mean: (7,) pose.
        covariance: (6, 6) [m², rad²] block diagonal; rotations as rotation vectors about the mean, in its axes.
        gates: (2,) squared Mahalanobis distances of position and rotation; left out, those that hold 97.5 % where the
            covariance is known.
        count: how many keyframes it was learnt from; 0 if it was written by hand.

    Raises:
        InputError: a mean that is no pose, a covariance that is not positive definite in both blocks or ties them
            together, or gates that are not above zero.
    """

    mean: Array
    covariance: Array
    gates: Array = field(default_factory=lambda: np.array(CHI_SQUARED))
    count: float = 0.0

    def __post_init__(self) -> None:
        mean = read_pose(self.mean, "mean")
        if mean.shape != (7,):
            raise InputError(f"mean: shape {mean.shape}; expected one pose (7,).")
        for name, value in (
            ("mean", mean),
            ("covariance", _covariance(self.covariance)),
            ("gates", _gates(self.gates)),
        ):
            value.flags.writeable = False
            object.__setattr__(self, name, value)

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

    def __repr__(self) -> str:
        place = ", ".join(f"{x:.3g}" for x in self.mean[:3])
        widths = [np.sqrt(np.linalg.eigvalsh(self.covariance[b, b])[::-1]) for b in BLOCKS]
        position, rotation = (" × ".join(f"{x:.2g}" for x in width) for width in widths)
        return f"PoseGaussian(at ({place}) m, σ {position} m, {rotation} rad, {self.count:g} keyframes)"


def _covariance(value: Any) -> Array:
    expected = "a covariance (6, 6) of position and rotation"
    array = read_numbers(value, "covariance", expected)
    if array.shape != (6, 6):
        raise InputError(f"covariance: shape {array.shape}; expected {expected}.")
    scale = np.abs(array).max()
    if not np.abs(array - array.T).max() <= 1e-9 * scale:
        raise InputError("covariance: not symmetric; expected a symmetric (6, 6).")
    if np.abs(array[:3, 3:]).max() > 1e-9 * scale:
        raise InputError("covariance: ties position and rotation together; expected zeros between the two blocks.")
    for name, block in zip(("positions", "rotations"), BLOCKS, strict=True):
        values = np.linalg.eigvalsh(array[block, block])
        if not values[0] > THINNEST * values[2]:
            raise InputError(
                f"covariance: variances of {name} from {values[0]:.2g} to {values[2]:.2g}; expected all above "
                f"zero, and above {THINNEST:g} of the largest."
            )
    return 0.5 * (array + array.T)


def _gates(value: Any) -> Array:
    gates = read_numbers(value, "gates", "two numbers above 0")
    if gates.shape != (2,) or not (gates > 0.0).all():
        raise InputError(f"gates: {gates.tolist()!r:.60}; expected two numbers above 0, of position and rotation.")
    return gates


def _derivative(vector: Array) -> Array:
    """Derivative (3, 3) of the rotation vector by a turn about the body's own axes (inverse right Jacobian)."""
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    half = 0.5 * np.linalg.norm(vector)
    bend = 1.0 / 12.0 if half < 1e-4 else (1.0 - half / np.tan(half)) / (4.0 * half * half)
    return np.eye(3) + 0.5 * cross + bend * cross @ cross
