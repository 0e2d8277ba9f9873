"""The shapes that obstacles are made of, each at rest or moving along a given motion.

Sizes are whole: a box has full edge lengths, a cylinder its full length. A pose is x, y, z, qw, qx, qy, qz; a
position x, y, z alone means not turned. What is no such number is a `SceneError`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from os import PathLike
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from skillfold.errors import SceneError
from skillfold.robots.mesh_files import read_vertices
from skillfold.robots.poses import HERE, Array, between, read_numbers, read_pose

LARGEST = 1e4  # metres: anything larger was hardly given in metres


@dataclass(frozen=True, eq=False)
class Motion:
    """Poses over time: straight between the times given, turning evenly, at rest before the first and after the last.

    Attributes:
        times: (n,) rising [s].
        poses: (n, 7), or positions (n, 3).

    Raises:
        SceneError: times that do not rise, or poses of another number or shape.
    """

    times: Any
    poses: Any

    def __post_init__(self) -> None:
        times = read_numbers(self.times, "motion times", "rising times [s]", SceneError)
        poses = read_pose(self.poses, "motion poses", SceneError)
        if times.ndim != 1 or not len(times) or poses.shape != (len(times), 7):
            raise SceneError(
                f"Motion: times {times.shape} and poses {poses.shape}; expected (n,) and (n, 7) or (n, 3)."
            )
        if (np.diff(times) <= 0).any():
            i = int(np.argmax(np.diff(times) <= 0))
            raise SceneError(f"Motion: time {times[i + 1]:g} follows {times[i]:g}; expected rising times.")
        _set(self, times=_fixed(times), poses=_fixed(poses))

    def at(self, time: float) -> Array:
        """Pose (7,) at a time [s]."""
        after = int(np.searchsorted(self.times, time))
        if after == 0 or after == len(self.times):
            return np.array(self.poses[min(after, len(self.times) - 1)])
        start, end = self.times[after - 1], self.times[after]
        return between(self.poses[after - 1], self.poses[after], (time - start) / (end - start))

    def __eq__(self, other: object) -> bool:
        return _same(self, other)

    def __hash__(self) -> int:
        return hash((type(self), len(self.times)))


@dataclass(frozen=True, eq=False)
class Shape:
    """What every obstacle has.

    Attributes:
        name: how messages and `move` call it; a scene gives one where it is empty.
        motion: poses over time that it takes instead of its own, for `Obstacles.at`; None where it stays.

    Raises:
        SceneError: says which value of which shape cannot be used, and what was expected.
    """

    name: str = field(default="", kw_only=True)
    motion: Motion | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise SceneError(f"{type(self).__name__}: name {self.name!r}; expected a text.")
        if self.motion is not None and not isinstance(self.motion, Motion):
            raise SceneError(
                f"{self.title}: motion is a {type(self.motion).__name__}; expected Motion(times, poses)."
            )

    @property
    def title(self) -> str:
        """How messages call it."""
        return f"{type(self).__name__} '{self.name}'" if self.name else type(self).__name__

    @property
    def placed(self) -> Array:
        """Pose (7,) at rest."""
        return np.array(getattr(self, "pose", HERE), dtype=np.float64)

    def at(self, time: float | None) -> Array:
        """Pose (7,) at a time [s]; at rest where it has no motion or no time is given."""
        return self.placed if time is None or self.motion is None else self.motion.at(time)

    def __eq__(self, other: object) -> bool:
        return _same(self, other)

    def __hash__(self) -> int:
        return hash((type(self), self.name))

    def _read_pose(self) -> None:
        pose = read_pose(getattr(self, "pose"), f"{self.title}: pose", SceneError)  # noqa: B009 - of subclasses
        if pose.shape != (7,):
            raise SceneError(f"{self.title}: pose of shape {pose.shape}; expected 7 numbers, or a position of 3.")
        if np.abs(pose[:3]).max() > LARGEST:
            raise SceneError(f"{self.title}: stands {np.abs(pose[:3]).max():g} m away; positions are in metres.")
        _set(self, pose=tuple(pose.tolist()))

    def _read_length(self, name: str) -> None:
        value = read_numbers(getattr(self, name), f"{self.title}: {name}", "a length [m]", SceneError)
        if value.ndim or not 0 < value <= LARGEST:
            raise SceneError(f"{self.title}: {name} is {getattr(self, name)!r}; expected a positive length [m].")
        _set(self, **{name: float(value)})


@dataclass(frozen=True, eq=False)
class Box(Shape):
    """A box with its centre at `pose` and full edge lengths `size` (x, y, z) [m] along the pose's axes."""

    pose: Any
    size: Any

    def __post_init__(self) -> None:
        super().__post_init__()
        self._read_pose()
        size = read_numbers(self.size, f"{self.title}: size", "three full edge lengths [m]", SceneError)
        if size.shape != (3,) or not ((size > 0) & (size <= LARGEST)).all():
            raise SceneError(f"{self.title}: size {self.size!r:.60}; expected three positive full edge lengths [m].")
        _set(self, size=tuple(size.tolist()))


@dataclass(frozen=True, eq=False)
class Sphere(Shape):
    """A sphere of `radius` [m] about `center` (x, y, z)."""

    center: Any
    radius: Any

    def __post_init__(self) -> None:
        super().__post_init__()
        center = read_numbers(self.center, f"{self.title}: center", "x, y, z [m]", SceneError)
        if center.shape != (3,) or np.abs(center).max() > LARGEST:
            raise SceneError(f"{self.title}: center {self.center!r:.60}; expected x, y, z [m].")
        _set(self, center=tuple(center.tolist()))
        self._read_length("radius")

    @property
    def placed(self) -> Array:
        """Pose (7,) at rest."""
        return np.array([*self.center, *HERE[3:]])


@dataclass(frozen=True, eq=False)
class Cylinder(Shape):
    """A cylinder with its centre at `pose`, along the pose's z axis, of `radius` and full `length` [m]."""

    pose: Any
    radius: Any
    length: Any

    def __post_init__(self) -> None:
        super().__post_init__()
        self._read_pose()
        self._read_length("radius")
        self._read_length("length")


@dataclass(frozen=True, eq=False)
class Capsule(Cylinder):
    """A cylinder of `radius` and `length` [m] with a half sphere beyond each end: 2 radii longer than `length`."""


@dataclass(frozen=True, eq=False)
class Mesh(Shape):
    """The convex hull of `vertices` (n, 3) [m], in the frame at `pose`. `Mesh.read` takes them from a file."""

    vertices: Any
    pose: Any = HERE

    def __post_init__(self) -> None:
        super().__post_init__()
        self._read_pose()
        vertices = _points(self.vertices, f"{self.title}: vertices")
        try:
            corners = vertices[ConvexHull(vertices).vertices]
        except (QhullError, ValueError):
            raise SceneError(
                f"{self.title}: {len(vertices)} vertices without volume; expected four or more, not all in a plane."
            ) from None
        _set(self, vertices=_fixed(corners))

    @classmethod
    def read(
        cls,
        file: str | PathLike[str],
        pose: Any = HERE,
        *,
        scale: float = 1.0,
        name: str = "",
        motion: Motion | None = None,
    ) -> "Mesh":
        """Hull of the mesh in an OBJ or STL file, its coordinates times `scale`: 0.001 for millimetres.

        Raises:
            SceneError: the file is missing, of another kind, damaged, or has no volume.
        """
        return cls(read_vertices(file, scale), pose, name=name, motion=motion)


@dataclass(frozen=True, eq=False)
class PointCloud(Shape):
    """A sphere of `radius` [m] about each of `points` (n, 3) [m], in the frame at `pose`."""

    points: Any
    radius: Any
    pose: Any = HERE

    def __post_init__(self) -> None:
        super().__post_init__()
        self._read_pose()
        self._read_length("radius")
        _set(self, points=_fixed(_points(self.points, f"{self.title}: points")))


KINDS: dict[str, type[Shape]] = {
    "box": Box,
    "sphere": Sphere,
    "cylinder": Cylinder,
    "capsule": Capsule,
    "mesh": Mesh,
    "point_cloud": PointCloud,
}


def _points(value: Any, what: str) -> Array:
    points = read_numbers(value, what, "points (n, 3) [m]", SceneError)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise SceneError(f"{what} of shape {points.shape}; expected points (n, 3) [m].")
    if np.abs(points).max() > LARGEST:
        raise SceneError(f"{what} reach {np.abs(points).max():g} m away; they are in metres.")
    return points


def _fixed(array: Array) -> Array:
    array.setflags(write=False)
    return array


def _set(target: Any, **values: Any) -> None:
    for name, value in values.items():
        object.__setattr__(target, name, value)


def _same(a: Any, b: Any) -> bool:
    if type(a) is not type(b):
        return NotImplemented
    pairs: Sequence[tuple[Any, Any]] = [(getattr(a, f.name), getattr(b, f.name)) for f in fields(a)]
    return all(np.array_equal(x, y) if isinstance(x, np.ndarray) else x == y for x, y in pairs)
