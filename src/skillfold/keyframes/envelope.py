"""`SoftEnvelope`: where the tool may be on its way from one keyframe to the next."""

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from skillfold.errors import InputError
from skillfold.keyframes import stations
from skillfold.keyframes.charts import PoseChart
from skillfold.keyframes.gaussians import PoseGaussian
from skillfold.keyframes.region import PoseRegion

Array = np.ndarray[Any, np.dtype[np.float64]]

HALF_TURN = 3.0  # radians between two means beyond which the way to turn is not told
INTERPOLATIONS = ("linear", "bures")


@dataclass(frozen=True, eq=False, repr=False)
class SoftEnvelope(PoseRegion):
    """The poses between two pose Gaussians (paper 002, sections II-B.2 and II-B.3).

    Means go straight from the parent's to the child's, in a chart about the rotation half-way. A pose is inside if
    at some s from 0 to 1 it is within the gates of the Gaussian there, in position and in rotation.

    Attributes:
        parent, child: the Gaussians at s = 0 and s = 1, as they were learnt.
        interpolation: of covariances between them, "linear" (equation 1) or "bures".
        alpha: percent of the variance that reduction kept.
        factor: by which the gates were widened, in d².
    """

    parent: PoseGaussian
    child: PoseGaussian
    interpolation: str = "linear"
    alpha: float = 100.0
    factor: float = 1.0

    @classmethod
    def between(cls, parent: PoseGaussian, child: PoseGaussian, interpolation: str = "linear") -> Self:
        """The envelope between two Gaussians.

        Args:
            parent, child: where it starts and ends.
            interpolation: of the covariances. "linear" is the paper's, and the widest; "bures" follows optimal
                transport, and is thinner half-way where the Gaussians are long in different directions.

        Raises:
            InputError: an unknown interpolation, or rotations (nearly) half a turn apart.
        """
        _check_pair(parent, child)
        chart = PoseChart.between(parent.mean, child.mean)
        (first, start), (last, end) = parent.about(chart), child.about(chart)
        if interpolation not in INTERPOLATIONS:
            raise InputError(f"interpolation: {interpolation!r}; expected one of {', '.join(INTERPOLATIONS)}.")
        covariances = np.array([start, end]) if interpolation == "linear" else stations.bures(start, end)
        return cls(chart, np.array([first, last]), covariances, parent, child, interpolation)

    def reduced(self, alpha: float = 85.0, kappa: float = 0.1) -> Self:
        """The envelope that is kept wide only in its principal directions (algorithm 2).

        As many directions as parent or child need for `alpha` percent of their variance are kept, all along; in the
        others the variance is `kappa` times what it was. Directions of position and rotation rank together. There
        are so many stations, at equal distances, that means of neighbours lie within half a gate of each other, but
        no more than 64; as covariances go straight between stations too, no number of them can tear the envelope.

        Args:
            alpha: percent, above 0; 100 gives the same envelope.
            kappa: above 0 and at most 1.

        Raises:
            InputError: either is out of range.
        """
        alpha, kappa = _number(alpha, "alpha", 100.0), _number(kappa, "kappa", 1.0)
        kept = max(stations.count_kept(ends, alpha) for ends in self.covariances[[0, -1]])
        if alpha == 100.0 or kept == 6:
            return replace(self, alpha=alpha)
        grid = np.linspace(0.0, 1.0, stations.MOST_SEGMENTS + 1)
        reduced = stations.reduce(self.covariances_at(grid), kept, kappa)
        before = len(self.covariances) - 1
        # Its own stations stay among the new ones: else chords between these could leave the envelope.
        segments = before * -(-stations.count_segments(self.axis, reduced) // before)
        s = np.linspace(0.0, 1.0, segments + 1)
        return replace(self, covariances=stations.reduce(self.covariances_at(s), kept, kappa), alpha=alpha)

    def widened(self, factor: float) -> Self:
        """The envelope with gates `factor` times as wide in d²; lengths grow by its root.

        Raises:
            InputError: a factor that is not above 0.
        """
        factor = _number(factor, "factor", np.inf)
        return replace(self, covariances=factor * self.covariances, factor=factor * self.factor)

    def __repr__(self) -> str:
        length, angle = np.linalg.norm(self.axis[:3]), np.linalg.norm(self.axis[3:])
        stations = f"{len(self.covariances)} stations"
        return (
            f"SoftEnvelope({length:.3g} m and {angle:.3g} rad long, {self.interpolation}, {stations}, "
            f"alpha {self.alpha:g}, gates × {self.factor:g})"
        )


def _check_pair(parent: Any, child: Any) -> None:
    for name, given in (("parent", parent), ("child", child)):
        if not isinstance(given, PoseGaussian):
            raise InputError(f"{name}: {type(given).__name__}; expected a PoseGaussian.")
    angle = 2.0 * np.arccos(min(abs(float(parent.mean[3:] @ child.mean[3:])), 1.0))
    if angle > HALF_TURN:
        raise InputError(
            f"parent and child are turned {np.degrees(angle):.0f}° from each other, which leaves open which way to "
            f"turn; expected at most {np.degrees(HALF_TURN):.0f}°: add a keyframe between them."
        )


def _number(value: Any, name: str, most: float) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not (0.0 < number <= most and np.isfinite(number)):
        limit = f", at most {most:g}" if np.isfinite(most) else ""
        raise InputError(f"{name}: {value!r:.40}; expected a number above 0{limit}.")
    return number
