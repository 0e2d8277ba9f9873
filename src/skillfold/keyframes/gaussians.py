"""`PoseGaussian`: where a keyframe lies, how much it may vary, and the gates around it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.keyframes.charts import PoseChart

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
    count: float

    def about(self, chart: PoseChart) -> tuple[Array, Array]:
        """Mean (6,) and gated covariances (2, 3, 3) in a chart: d² ≤ 1 in both blocks is inside.

        The rotation block is carried over by the derivative of the rotation vector at the mean.
        """
        raise NotImplementedError
