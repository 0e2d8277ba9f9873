"""`Obstacles`: the clearance of one robot in one scene, its gradient, and safe checks of edges."""

import threading
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from skillfold.clearance import Compiled
from skillfold.errors import InputError
from skillfold.robots import distances, edges
from skillfold.robots.arguments import Layout, layout_of, table_for
from skillfold.robots.compiled import compiled_for
from skillfold.robots.merging import PREFIX
from skillfold.robots.poses import read_pose
from skillfold.robots.reading import read_amount, read_joint_positions
from skillfold.robots.scene import Scene
from skillfold.tables import Array, Table

if TYPE_CHECKING:
    from skillfold.robots.robot import Robot

MARGIN = 0.02  # metres
RESOLUTION = 0.01  # radians


class Closest(NamedTuple):
    """The nearest pair at one pose of a robot.

    Attributes:
        clearance: signed distance [m] (a joint's way to its limit in its own unit).
        first, second: what they are: shapes of the robot, obstacles; a joint and `lower limit` or `upper limit`.
        points: (2, 3) nearest points in the world; NaN for limits.
    """

    clearance: float
    first: str
    second: str
    points: Array


@dataclass(frozen=True, eq=False, repr=False)
class Obstacles:
    """What a robot can run into; made by `robot.obstacles(scene)`.

    Clearance is the smallest signed distance [m] over all pairs of shapes that count; negative where they overlap.
    Far inside one another distances jump and gradients point the wrong way: do not climb out of deep collisions by
    them. All may be asked from several threads at once.

    Attributes:
        robot: whose shapes they are.
        scene: the obstacles, at rest or along their motions.
        time: for which moving obstacles are placed [s]; None is at rest.
        self_collision, limits: whether the robot's own shapes and its joint limits count, a radian as a metre.
        movable: names of obstacles that move without a new model.
        base: (7,) pose of a floating base, None at the origin.
        margin: clearance [m] that planners try to keep.
    """

    robot: "Robot"
    scene: Scene
    time: float | None
    self_collision: bool
    limits: bool
    movable: frozenset[str]
    base: Array | None
    margin: float
    _layout: Layout
    _local: threading.local

    @classmethod
    def build(
        cls,
        robot: "Robot",
        scene: Any,
        self_collision: bool,
        limits: bool,
        movable: Iterable[str],
        base: Any,
        margin: float = MARGIN,
    ) -> "Obstacles":
        """See `Robot.obstacles`."""
        if not (isinstance(margin, int | float | np.number) and np.isfinite(margin) and margin > 0):
            raise InputError(f"margin {margin!r}; expected metres, above zero.")
        scene = scene if isinstance(scene, Scene) else Scene(() if scene is None else scene)
        moving = {shape.name for shape in scene if shape.motion is not None} | set(_names(movable))
        for name in moving:
            scene[name]  # an unknown one is an error
        if base is not None:
            base = _read_base(robot, base)
        layout = layout_of(robot, scene, moving, self_collision)
        options = (self_collision, limits, frozenset(moving), base, float(margin))
        return cls(robot, scene, None, *options, layout, threading.local())

    def __reduce__(self) -> tuple[Any, ...]:
        options = (self.self_collision, self.limits, tuple(sorted(self.movable)), self.base, self.margin)
        return _again, (self.robot, self.scene, self.time, *options)

    def __repr__(self) -> str:
        when = "" if self.time is None else f" at {self.time:g} s"
        return (
            f"Obstacles({self.robot.name} among {len(self.scene)} obstacles{when}, {len(self._layout.pairs)} pairs)"
        )

    @property
    def n_pairs(self) -> int:
        """Pairs of shapes that count; points of clouds not included."""
        return len(self._layout.pairs)

    def clearance(self, q: Any) -> Array:
        """Clearance (...,) at joint positions q (..., dof); infinite where there is nothing to run into.

        Raises:
            InputError: q of another shape or not finite.
        """
        states, shape = self._read(q)
        out = np.empty(len(states))
        distances.clearances(states, self._table().entries, out, np.empty((0, self.robot.dof)))
        return out.reshape(shape)[()]

    def clearance_gradient(self, q: Any) -> Array:
        """Derivative (..., dof) of the clearance by q; zero where there is nothing to run into. Errors as above."""
        states, shape = self._read(q)
        out, gradients = np.empty(len(states)), np.zeros((len(states), self.robot.dof))
        distances.clearances(states, self._table().entries, out, gradients)
        return gradients.reshape(*shape, self.robot.dof)

    def within(self, q: Any, reach: float) -> tuple[Array, Array]:
        """Distances (m,) of all pairs nearer than `reach` [m] at q (dof,), and their gradients (m, dof).

        Of the points of clouds, the nearest to each shape of the robot. Joint limits are left out.

        Raises:
            InputError: q of another shape or not finite, or no reach.
        """
        states, shape = self._read(q)
        if shape:
            raise InputError(f"within: joint positions of shape {np.shape(q)}; expected ({self.robot.dof},).")
        near, gradients = np.empty(self.capacity), np.empty((self.capacity, self.robot.dof))
        count = distances.within(
            states[0], read_amount(reach, "within: reach", "metres"), near, gradients, self._table().entries
        )
        return near[:count], gradients[:count]

    def closest(self, q: Any) -> Closest:
        """The nearest pair at q (dof,): how near, what, and where; errors as in `within`."""
        states, shape = self._read(q)
        if shape:
            raise InputError(f"closest: joint positions of shape {np.shape(q)}; expected ({self.robot.dof},).")
        table = self._table()
        distance = distances.clearance(states[0], np.empty(0), table.entries)
        a, b = (int(i) for i in table.arrays[distances.WINNER])
        if a >= 0:
            points = table.arrays[distances.SEGMENT].reshape(2, 3).copy()
            return Closest(distance, self._title(a), self._title(b), points)
        names = {-1: (self.robot.names[b], "lower limit"), -2: (self.robot.names[b], "upper limit")}
        return Closest(distance, *names.get(a, ("nothing", "nothing")), np.full((2, 3), np.nan))

    def nearest(self, q: Any) -> str:
        """The nearest pair at q (dof,), in words."""
        found = self.closest(q)
        return f"{found.first} to {found.second}"

    @property
    def resolution(self) -> float:
        """Distance [rad, m] between states at which a path is checked."""
        return RESOLUTION

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper joint limits (dof,), which every plan keeps."""
        lower, upper = self.robot.limits
        return lower, upper

    def edge_clear(self, a: Any, b: Any, margin: float = 0.0) -> Any:
        """Whether clearance stays above `margin` [m] all along straight edges from a to b (..., dof); (...,) bool.

        Conservative advancement: True holds between the steps too, by a bound on how fast any point of the robot can
        move. An edge that comes within 0.1 mm of the margin may be called blocked. Moving obstacles stand where they
        are. Shapes of a and b broadcast.
        """
        return self.edge_advance(a, b, margin) >= 1.0

    def edge_advance(self, a: Any, b: Any, margin: float = 0.0) -> Any:
        """Share (...,) of each edge for which that holds: 1 where the whole edge is clear."""
        margin = read_amount(margin, "edge: margin", "metres")
        try:
            a, b = np.broadcast_arrays(np.asarray(a, np.float64), np.asarray(b, np.float64))
        except (TypeError, ValueError):
            raise InputError(f"edge: ends of shapes {np.shape(a)} and {np.shape(b)} do not go together.") from None
        (starts, shape), (ends, _) = self._read(a), self._read(b)
        out = np.empty(len(starts))
        edges.edges(starts, ends, margin, self._table().entries, out)
        return out.reshape(shape)[()]

    def at(self, time: float | None) -> "Obstacles":
        """The same with obstacles that have a motion where they are at `time` [s]; None is at rest.

        Raises:
            InputError: no finite time.
        """
        if time is not None and not (isinstance(time, int | float | np.number) and np.isfinite(time)):
            raise InputError(f"at: time {time!r}; expected seconds.")
        return replace(self, time=None if time is None else float(time), _local=threading.local())

    @property
    def moves(self) -> bool:
        """Whether any obstacle has a motion."""
        return any(shape.motion is not None for shape in self.scene)

    def place(self, compiled: Compiled, time: float) -> None:
        """Put what has a motion where it is at `time` [s], in what this object has compiled; points of clouds stay.

        Fast, and it leaves this object's own `time` behind: for loops that have an object to themselves.
        """
        positions = compiled.owner.arrays[distances.STANDING_POS]
        turns = compiled.owner.arrays[distances.STANDING_QUAT]
        for name, row in self._layout.merged.mocaps.items():
            shape = self.scene[name]
            if shape.motion is not None:
                pose = shape.motion.at(time)
                positions[row], turns[row] = pose[:3], pose[3:]

    def move(self, name: str, pose: Any) -> "Obstacles":
        """The same with one obstacle at another pose (7,) or position (3,), where it then stays.

        Cheap for obstacles with a motion or named in `movable`; else the model is made anew, once.

        Raises:
            SceneError: no such obstacle, or no pose.
        """
        scene = self.scene.moved(name, pose)
        if name in self.movable:
            return replace(self, scene=scene, _local=threading.local())
        options = (self.self_collision, self.limits, self.movable | {name}, self.base, self.margin)
        again = Obstacles.build(self.robot, scene, *options)
        return replace(again, time=self.time)

    def compiled(self) -> Compiled:
        """Functions for compiled loops, and the arguments to call them with.

        The arguments belong to the thread that asks, and each call writes to the memory they point to: never use them
        in two threads at once, and keep what this returns as long as they are in use.
        """
        return compiled_for(self._table(), self.capacity)

    @property
    def capacity(self) -> int:
        """How many distances `within` can find at most."""
        return len(self._layout.pairs) + (len(self._layout.moving) if self._layout.clouds else 0)

    @cached_property
    def _standing(self) -> dict[str, Array]:
        """Pose of each movable obstacle."""
        return {shape.name: shape.at(self.time) for shape in self.scene}

    def _table(self) -> Table:
        """What the compiled loops are given, with this thread's own data."""
        found = getattr(self._local, "table", None)
        if found is None:
            limits = self.robot.limits if self.limits else None
            found = table_for(self._layout, self.scene, self._standing, limits, self.base)
            self._local.table = found
        return found

    def _read(self, q: Any) -> tuple[Array, tuple[int, ...]]:
        return read_joint_positions(q, self.robot.dof, self.robot.name)

    def _title(self, shape: int) -> str:
        model = self._layout.merged.model
        name = model.geom(shape).name or model.body(int(model.geom_bodyid[shape])).name
        return name.removeprefix(PREFIX)


def _names(movable: Any) -> Iterable[Any]:
    if isinstance(movable, str) or not isinstance(movable, Iterable):
        raise InputError(f"movable: {movable!r:.40}; expected a list of names of obstacles.")
    return movable


def _read_base(robot: "Robot", base: Any) -> Array:
    if not robot.floating:
        raise InputError(
            f"{robot.name}: its base is fixed; expected no base pose. Place the scene in the world of its model."
        )
    base = read_pose(base, "base")
    if base.shape != (7,):
        raise InputError(f"base of shape {base.shape}; expected one pose (7,).")
    return base


def _again(robot: "Robot", scene: Scene, time: float | None, *options: Any) -> Obstacles:
    return Obstacles.build(robot, scene, *options).at(time)
