"""Dynamic movement primitives by the `movement_primitives` package: one imitated motion, moved to new ends.

The motion imitated is the mean of the recordings at equal phase, as in common use where there are several; nothing is
tuned but the number of weights, which is generous.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from skillfold.errors import MissingExtraError
from skillfold.motion import Array

WEIGHTS = 30  # per dimension
DURATION = 1.0  # seconds of a motion; its shape does not depend on it


@dataclass(frozen=True)
class Primitive:
    """A fitted primitive, of positions or of poses (x, y, z, qw, qx, qy, qz)."""

    dmp: Any

    @classmethod
    def fit(cls, recordings: Sequence[Array]) -> Self:
        """From recordings that all have shape (n_points, D), a state per instant."""
        mean = np.mean(recordings, axis=0)
        return cls(_imitating(_package().DMP(mean.shape[1], DURATION, DURATION / (len(mean) - 1), WEIGHTS), mean))

    @classmethod
    def fit_poses(cls, recordings: Sequence[Array]) -> Self:
        """From recordings (n_points, 7) with consistent signs of the quaternions."""
        mean = np.mean(recordings, axis=0)
        mean[:, 3:] /= np.linalg.norm(mean[:, 3:], axis=1, keepdims=True)
        return cls(_imitating(_package().CartesianDMP(DURATION, DURATION / (len(mean) - 1), WEIGHTS), mean))

    def path(self, start: Array, goal: Array) -> Array:
        """The motion (n, D) between other ends."""
        self.dmp.reset()
        self.dmp.configure(start_y=start, goal_y=goal)
        return np.asarray(self.dmp.open_loop()[1], np.float64)


def _imitating(dmp: Any, motion: Array) -> Any:
    dmp.imitate(np.linspace(0.0, DURATION, len(motion)), motion)
    return dmp


def _package() -> Any:
    try:
        from movement_primitives import dmp  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise MissingExtraError("movement_primitives is not installed: pip install 'skillfold[peers]'.") from error
    return dmp
