"""Charts of poses: six flat coordinates about a middle rotation, in which Gaussians and envelopes live."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from skillfold.keyframes.kernels.charts import flat, full
from skillfold.robots.poses import read_pose

Array = np.ndarray[Any, np.dtype[np.float64]]

LENGTH = 0.15  # metres per radian, wherever positions and rotations must share one length


@dataclass(frozen=True, eq=False)
class PoseChart:
    """Coordinates y = (x, y, z [m], rotation vector [rad]) of poses, the vector taken from a middle rotation.

    The vector turns the middle rotation into that of the pose, in the axes of the middle: log(R_middle⁻¹ R). It is
    smooth up to half a turn from there, which quaternion components, whose covariances are near singular, are not.

    Attributes:
        middle: (4,) unit quaternion, scalar first.
    """

    middle: Array

    def __post_init__(self) -> None:
        # A copy that can be written to: read-only arrays would make kernels compile anew.
        object.__setattr__(self, "middle", np.array(self.middle, np.float64))

    @classmethod
    def between(cls, first: Any, second: Any) -> Self:
        """The chart about the rotation half-way between those of two poses (7,)."""
        from scipy.spatial.transform import Rotation

        turns = read_pose([first, second], "poses of a chart")[:, 3:]
        middle = Rotation.from_quat(turns, scalar_first=True).mean()
        return cls(middle.as_quat(scalar_first=True))

    def to_chart(self, poses: Any) -> Array:
        """Chart coordinates (..., 6) of poses (..., 7)."""
        poses = read_pose(poses, "poses")
        rows = np.ascontiguousarray(poses.reshape(-1, 7))
        out = np.empty((len(rows), 6))
        flat(rows, self.middle, out)
        return out.reshape(*poses.shape[:-1], 6)

    def to_pose(self, coordinates: Any) -> Array:
        """The reverse: poses (..., 7)."""
        coordinates = np.asarray(coordinates, np.float64)
        rows = np.ascontiguousarray(coordinates.reshape(-1, 6))
        out = np.empty((len(rows), 7))
        full(rows, self.middle, out)
        return out.reshape(*coordinates.shape[:-1], 7)


def squared_lengths(differences: Array) -> Array:
    """Squared lengths (...,) [m²] of chart differences (..., 6), a radian as `LENGTH` metres."""
    return (differences[..., :3] ** 2).sum(-1) + LENGTH**2 * (differences[..., 3:] ** 2).sum(-1)
