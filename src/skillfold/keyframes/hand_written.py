"""Pose constraints written by hand: an axis of the tool upright, a plane, a task space region.

Each is a set of poses with a tolerance about it. `distance` is counted from the tolerance's edge; `project` goes all
the way to the set, so that motions that start there have room.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.keyframes.compiled import plane_functions, region_functions, upright_functions
from skillfold.keyframes.constraint import CompiledConstraint, generator
from skillfold.keyframes.kernels import hand_written as kernels
from skillfold.robots.poses import HERE, compose, read_numbers, read_pose, turn
from skillfold.tables import Table, table_of

Array = np.ndarray[Any, np.dtype[np.float64]]

LEAST_TOLERANCE = 1e-9  # rounding alone would break a narrower one


class _HandWritten:
    """What the three have in common: kernels, and the numbers that these take."""

    @staticmethod
    def _functions() -> tuple[Any, Any]:
        raise NotImplementedError

    def distance(self, poses: Any) -> Any:
        """How far (...,) [m] poses (..., 7) lie outside, a radian as `charts.LENGTH` metres; 0 inside."""
        poses = read_pose(poses, "poses")
        rows = np.ascontiguousarray(poses.reshape(-1, 7))
        out = np.empty(len(rows))
        kernels.excesses(self._functions()[0], rows, self._table.entries, out)
        return np.maximum(out, 0.0).reshape(poses.shape[:-1])[()]

    def contains(self, poses: Any, tolerance: float = 0.0) -> Any:
        """Whether poses (..., 7) are inside, or no farther outside than `tolerance` [m]."""
        return self.distance(poses) <= tolerance

    def project(self, poses: Any) -> Array:
        """The nearest poses (..., 7) that hold it exactly; those inside stay as they are."""
        poses = read_pose(poses, "poses")
        rows = np.ascontiguousarray(poses.reshape(-1, 7))
        out = np.empty_like(rows)
        kernels.projections(self._functions()[1], rows, self._table.entries, out)
        return out.reshape(poses.shape)

    def compiled(self) -> CompiledConstraint:
        """The same for compiled loops; its excess is in metres."""
        return CompiledConstraint(*self._functions(), self._table.entries, self._table)

    def _numbers(self) -> Array:
        raise NotImplementedError

    @cached_property
    def _table(self) -> Table:
        return table_of({0: self._numbers()}, 1)


@dataclass(frozen=True, eq=False)
class AxisUpright(_HandWritten):
    """An axis of the tool points up: what is carried in a cup stays in it.

    Attributes:
        axis: (3,) of the tool, in its frame; its length does not matter.
        up: (3,) in the world.
        tolerance: largest angle between the two [rad].

    Raises:
        InputError: an axis without length, a tolerance below 1e-9.
    """

    _functions = staticmethod(upright_functions)
    axis: Any = (0.0, 0.0, 1.0)
    up: Any = (0.0, 0.0, 1.0)
    tolerance: float = 0.05

    def __post_init__(self) -> None:
        _set(self, axis=_direction(self.axis, "axis"), up=_direction(self.up, "up"))
        _set(self, tolerance=_tolerance(self.tolerance))

    def _numbers(self) -> Array:
        return np.array([*self.axis, *self.up, self.tolerance])


@dataclass(frozen=True, eq=False)
class PlaneConstraint(_HandWritten):
    """The tool's origin stays on a plane: wiping, writing, pushing.

    Attributes:
        point: (3,) of the plane [m].
        normal: (3,) at right angles to it; its length does not matter.
        tolerance: largest distance from it [m].

    Raises:
        InputError: a normal without length, a tolerance below 1e-9.
    """

    _functions = staticmethod(plane_functions)
    point: Any
    normal: Any = (0.0, 0.0, 1.0)
    tolerance: float = 0.002

    def __post_init__(self) -> None:
        _set(self, point=_vector(self.point, "point"), normal=_direction(self.normal, "normal"))
        _set(self, tolerance=_tolerance(self.tolerance))

    def _numbers(self) -> Array:
        return np.array([self.point @ self.normal, *self.normal, self.tolerance])


@dataclass(frozen=True, eq=False)
class TaskSpaceRegion(_HandWritten):
    """Bounds on where the tool is and how it is turned in some frame (Berenson, Srinivasa and Kuffner 2011).

    The tool's pose is frame · B · offset: B has its position (x, y, z) and its turn Rz(yaw) Ry(pitch) Rx(roll) within
    bounds. Distances are measured in these six numbers.

    Attributes:
        frame: (7,) pose of the region's frame in the world.
        lower, upper: (6,) bounds of x, y, z [m], roll, pitch and yaw [rad]; two that are equal fix a number.
        offset: (7,) pose of the tool where all six numbers are zero, in the region's frame.
        tolerance: largest distance from the bounds [m].

    Raises:
        InputError: a frame that is no pose, bounds that are not finite or cross, angles that go round more than once,
            a tolerance below 1e-9.
    """

    _functions = staticmethod(region_functions)
    frame: Any
    lower: Any
    upper: Any
    offset: Any = field(default=HERE)
    tolerance: float = 0.002

    def __post_init__(self) -> None:
        lower, upper = _bounds(self.lower, self.upper)
        _set(self, frame=_pose(self.frame, "frame"), offset=_pose(self.offset, "offset"), lower=lower, upper=upper)
        _set(self, tolerance=_tolerance(self.tolerance))

    def sample(self, count: int, seed: int = 0) -> Array:
        """Poses (count, 7) inside, uniform in the six numbers."""
        rng = generator(count, seed)
        from scipy.spatial.transform import Rotation

        numbers = rng.uniform(self.lower, self.upper, size=(count, 6))
        # Not through Euler angles for an empty array, which SciPy refuses.
        turns = Rotation.from_euler("xyz", numbers[:, 3:]).as_quat(scalar_first=True) if count else np.empty((0, 4))
        return compose(self.frame, compose(np.concatenate([numbers[:, :3], turns], axis=1), self.offset))

    def _numbers(self) -> Array:
        return np.array([*self.frame, *_inverted(self.offset), *self.lower, *self.upper, self.tolerance])


def _set(constraint: Any, **values: Any) -> None:
    for name, value in values.items():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
        object.__setattr__(constraint, name, value)


def _vector(value: Any, name: str) -> Array:
    array = read_numbers(value, name, "three numbers")
    if array.shape != (3,):
        raise InputError(f"{name}: shape {array.shape}; expected three numbers.")
    return array


def _direction(value: Any, name: str) -> Array:
    array = _vector(value, name)
    length = math.hypot(*array)  # which knows no overflow
    if not 1e-9 < length < 1e9:
        raise InputError(f"{name}: {array.tolist()} has length {length:.3g}; expected a direction.")
    return array / length


def _pose(value: Any, name: str) -> Array:
    pose = read_pose(value, name)
    if pose.shape != (7,):
        raise InputError(f"{name}: shape {pose.shape}; expected one pose (7,).")
    return pose


def _inverted(pose: Array) -> Array:
    back = pose[3:] * (1.0, -1.0, -1.0, -1.0)
    return np.concatenate([-turn(back, pose[:3]), back])


def _tolerance(value: Any) -> float:
    number = read_numbers(value, "tolerance", "one number")
    if number.shape != () or not number >= LEAST_TOLERANCE:
        raise InputError(f"tolerance: {value!r:.40}; expected one number, at least {LEAST_TOLERANCE:g}.")
    return float(number)


def _bounds(lower: Any, upper: Any) -> tuple[Array, Array]:
    low, high = (read_numbers(v, n, "six finite numbers") for v, n in ((lower, "lower"), (upper, "upper")))
    for name, bounds in (("lower", low), ("upper", high)):
        if bounds.shape != (6,):
            raise InputError(f"{name}: shape {bounds.shape}; expected six numbers: x, y, z, roll, pitch, yaw.")
    if (low > high).any():
        i = int((low > high).argmax())
        raise InputError(f"lower: number {i} is {low[i]:g}, above {high[i]:g} of upper; expected lower ≤ upper.")
    if (high - low)[3:].max() > 2.0 * np.pi + 1e-9:
        raise InputError(
            f"upper: an angle goes {(high - low)[3:].max():.3g} rad round; expected at most a full turn."
        )
    return low, high
