"""`SoftEnvelope`: where the tool may be on its way from one keyframe to the next."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from skillfold.keyframes.charts import PoseChart
from skillfold.keyframes.gaussians import PoseGaussian
from skillfold.keyframes.region import PoseRegion

Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True, eq=False)
class SoftEnvelope(PoseRegion):
    """The poses between two pose Gaussians (paper 002, section II-B.2, equation 1).

    Attributes:
        parent, child: the Gaussians at s = 0 and s = 1.
    """

    parent: PoseGaussian
    child: PoseGaussian

    @classmethod
    def between(cls, parent: PoseGaussian, child: PoseGaussian, interpolation: str = "linear") -> Self:
        """The envelope between two Gaussians."""
        chart = PoseChart.between(parent.mean, child.mean)
        (first, start), (last, end) = parent.about(chart), child.about(chart)
        return cls(chart, np.array([first, last]), np.array([start, end]), parent, child)
