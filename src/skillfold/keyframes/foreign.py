"""Constraints that users wrote: what they answer is looked at before it is used."""

from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.keyframes.constraint import Array, PoseConstraint
from skillfold.recordings import shortened
from skillfold.robots.poses import read_pose


class Foreign:
    """A user's constraint that answers as `PoseConstraint` says, or raises.

    Its own errors are its user's and come through as they are. It has `sample` where the user's has.
    """

    def __init__(self, constraint: Any) -> None:
        """Raises `InputError` where it has no `distance` or no `project`."""
        missing = [name for name in ("distance", "project") if not callable(getattr(constraint, name, None))]
        if missing:
            raise InputError(
                f"constraint: {type(constraint).__name__} has no {' and no '.join(missing)}; expected both to take "
                "poses (n, 7)."
            )
        self._constraint = constraint
        if callable(getattr(constraint, "sample", None)):
            self.sample = self._sample

    def distance(self, poses: Any) -> Array:
        """See `PoseConstraint`; the user's function is given a copy."""
        distances = self._constraint.distance(np.array(poses))
        array = _numbers(distances)
        if array.shape != np.shape(poses)[:-1] or array.dtype.kind not in "fiub":
            raise InputError(
                f"constraint: distance of poses {np.shape(poses)} is {_told(distances)}; expected metres "
                f"{np.shape(poses)[:-1]}."
            )
        wrong = np.isnan(array)
        if wrong.any():
            pose = np.reshape(poses, (-1, 7))[wrong.ravel().argmax()]
            raise InputError(f"constraint: distance is NaN at the pose {pose.round(6).tolist()}; expected metres.")
        return array.astype(np.float64)

    def project(self, poses: Any) -> Array:
        """See `PoseConstraint`; the user's function is given a copy."""
        return _poses(self._constraint.project(np.array(poses)), np.shape(poses), "projection")

    def _sample(self, count: int, seed: int) -> Array:
        return _poses(self._constraint.sample(count, seed), (count, 7), "sample")


def known(constraint: PoseConstraint) -> Any:
    """The constraint itself where it is compiled, as the library's own are; else looked at.

    Raises:
        InputError: it has neither `compiled` nor `distance` and `project`.
    """
    return constraint if hasattr(constraint, "compiled") or isinstance(constraint, Foreign) else Foreign(constraint)


def _poses(given: Any, shape: tuple[int, ...], what: str) -> Array:
    if _numbers(given).shape != shape:
        raise InputError(f"constraint: {what} is {_told(given)}; expected poses {shape}.")
    return read_pose(given, f"constraint: {what}")


def _numbers(given: Any) -> np.ndarray[Any, Any]:
    try:
        return np.asarray(given)
    except ValueError:  # lists of different lengths
        return np.empty(0, object)


def _told(given: Any) -> str:
    return f"an array {given.shape} of {given.dtype}" if isinstance(given, np.ndarray) else shortened(given)
