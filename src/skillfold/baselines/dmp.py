"""Dynamic movement primitives by the `movement_primitives` package: one imitated motion, moved to new ends.

The motion imitated is the mean of the recordings at equal phase, as in common use where there are several. Of the
package's options only those are set that do a primitive good here: weights are generous, and the scaling is the
smooth one, which is made for other ends and keeps shapes better than the usual one. Nothing is tuned.
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
        """From recordings that all have shape (n_points, D), a state per instant, from rest to rest."""
        mean = np.mean(recordings, axis=0)
        step = DURATION / (len(mean) - 1)
        return cls(_imitating(_package().DMP(mean.shape[1], DURATION, step, WEIGHTS, smooth_scaling=True), mean))

    @classmethod
    def fit_poses(cls, recordings: Sequence[Array]) -> Self:
        """From recordings (n_points, 7) with consistent signs of the quaternions."""
        mean = np.mean(recordings, axis=0)
        mean[:, 3:] /= np.linalg.norm(mean[:, 3:], axis=1, keepdims=True)
        step = DURATION / (len(mean) - 1)
        return cls(_imitating(_package().CartesianDMP(DURATION, step, WEIGHTS, smooth_scaling=True), mean))

    def path(self, start: Array, goal: Array) -> Array:
        """The motion (n, D) between other ends."""
        self.dmp.reset()
        self.dmp.configure(start_y=start, goal_y=goal)
        return np.asarray(self.dmp.open_loop()[1], np.float64)

    def paths(self, starts: Array, goals: Array) -> list[Array]:
        """The same between starts (m, D) and goals (m, D)."""
        return [self.path(start, goal) for start, goal in zip(starts, goals, strict=True)]


def from_rest(recording: Array) -> Array:
    """The same recording (n, D), its evenly spaced states moved so that it starts and ends at rest (minimum jerk).

    A primitive does nothing else: one that imitates a motion of even speed is off its shape by 4 to 5 %.
    """
    share = np.linspace(0.0, 1.0, len(recording))
    wanted = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    return np.column_stack([np.interp(wanted, share, column) for column in recording.T])


def _imitating(dmp: Any, motion: Array) -> Any:
    dmp.imitate(np.linspace(0.0, DURATION, len(motion)), motion)
    return dmp


def _package() -> Any:
    try:
        from movement_primitives import dmp  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise MissingExtraError("movement_primitives is not installed: pip install 'skillfold[peers]'.") from error
    return dmp
