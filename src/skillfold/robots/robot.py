"""`Robot`: kinematics, limits and self-collision of one MuJoCo model."""

import threading
from collections.abc import Iterable
from dataclasses import replace
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from skillfold.errors import InputError
from skillfold.robots import kinematics
from skillfold.robots.dynamics import Dynamics, frame_of
from skillfold.robots.frames import NAMELESS, frames_of, last_frame
from skillfold.robots.held import Load, fix_load, read_load
from skillfold.robots.joints import Joints, Limits, loose_notes, machine_of, read_joints
from skillfold.robots.loading import Description, compiled, describe, lean
from skillfold.robots.poses import compose, place_points, turn
from skillfold.robots.reading import read_bases, read_joint_positions, read_whole
from skillfold.robots.tray import Tray, read_tray
from skillfold.spaces import StateSpace
from skillfold.tables import Array, Indices

if TYPE_CHECKING:
    from skillfold.robots.obstacles import Obstacles
    from skillfold.robots.scene import Scene

TOOLS = ("tool", "tool0")  # what a tool frame is called here, and by custom in URDF files


class Robot:
    """A robot, ready to answer; made by `Robot.load`.

    q is one vector of joint positions (dof,) or a batch (..., dof), in the order of `names`; answers have the same
    batch shape. A floating base stands at the origin unless `base` (..., 7) tells where. Where one joint follows
    another (one motor drives both) q has a place for both, and the follower's is not looked at: `couple` fills it in.
    All may be asked from several threads at once.

    Attributes:
        name: of the robot.
        source: bundled name or absolute path it was loaded from.
        names: of the joints.
        dof: number of joint positions.
        frames: names of the sites and bodies that `forward` and `jacobian` can be asked for.
        tool: the frame they take where none is named.
        limits: lower and upper (dof,) [rad, m], infinite where there are none.
        velocity_limits, acceleration_limits, torque_limits: (dof,) infinite where unknown.
        home: (dof,) the model's keyframe of that name, else its first, else its zero pose; within the limits.
        floating: whether the base is free.
        notes: what was left out or made up on loading.
    """

    def __init__(self, description: Description) -> None:
        self.source = description.source
        self._description = description
        self._spec = lean(description.spec)
        self.model = compiled(self._spec, self.source)
        self.joints: Joints = read_joints(self.model, self.source, description.speeds)
        self.notes = (*description.notes, *loose_notes(self.model))
        self.name: str = description.spec.modelname or self.source
        self.names = self.joints.names
        self.dof, self.floating = self.joints.dof, self.joints.base is not None
        self._frames = frames_of(self.model)
        self.frames = tuple(self._frames)
        self.tool = next((name for name in TOOLS if name in self._frames), None) or last_frame(self.model)
        self._local = threading.local()
        self._loads: tuple[Load, ...] = ()

    @classmethod
    def load(cls, name_or_path: str | PathLike[str]) -> Self:
        """A bundled robot (`jaco`, `lwr4`, `nao`, `planar_arm`), or one of yours in an MJCF or URDF file.

        In a URDF, package:// paths are looked for beside and above the file and in ROS_PACKAGE_PATH, visual shapes
        are dropped, links without inertia take one from their shapes; `notes` tells what was made up.

        Raises:
            RobotError: unknown name, damaged file, missing mesh, joints of other kinds; says what is possible.
        """
        return cls(describe(name_or_path))

    def with_tray(self, tray: Tray) -> "Robot":
        """This robot with a tray fixed to its tool, and on it the room that standing tumblers take.

        For what plans and looks out: its obstacles keep the tray clear too, and its dynamics know the load. It is not
        for `simulate`, which puts a tray and tumblers that can fall on the robot itself. A second tray is refused.
        """
        return self._loaded(read_tray(tray, self._loads))

    def holding(self, shapes: Any, mass: float = 0.1) -> "Robot":
        """This robot with things in its hand: its obstacles keep them clear too, and its dynamics know their mass.

        They keep clear of the scene and of the robot, but for the links that they touch: the last two, and what they
        touch wherever the robot stands.

        Args:
            shapes: `Box`, `Sphere`, `Cylinder`, `Capsule`, one or more, each with its pose in the tool frame.
            mass: of all together [kg], shared by volume.

        Raises:
            SceneError: no shapes, or of another kind.
            InputError: a mass that is none.
        """
        return self._loaded(read_load(shapes, mass, len(self._loads)))

    def _loaded(self, load: Load) -> "Robot":
        spec = self.spec()
        fix_load(spec, *frame_of(spec, self.tool), load)
        robot = Robot(replace(self._description, spec=spec))
        robot.tool, robot._loads = self.tool, (*self._loads, load)
        return robot

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.source, self._loads)

    def __repr__(self) -> str:
        base = ", floating base" if self.floating else ""
        return f"Robot({self.name}: {self.dof} joints{base}, tool frame '{self.tool}')"

    @property
    def limits(self) -> Limits:
        """Lower and upper joint limits."""
        return Limits(self.joints.limits.lower.copy(), self.joints.limits.upper.copy())

    @property
    def velocity_limits(self) -> Array:
        """(dof,) [rad/s, m/s]."""
        return self.joints.velocity.copy()

    @property
    def acceleration_limits(self) -> Array:
        """(dof,) [rad/s², m/s²]."""
        return self.joints.acceleration.copy()

    @property
    def torque_limits(self) -> Array:
        """(dof,) [N m, N]."""
        return self.joints.torque.copy()

    @property
    def home(self) -> Array:
        """(dof,) joint positions of the home pose."""
        return self.joints.home.copy()

    @cached_property
    def space(self) -> StateSpace:
        """What the coordinates of q are, with their limits."""
        return self.joints.space()

    @property
    def couplings(self) -> dict[str, str]:
        """Which joint follows which."""
        columns = enumerate(self.joints.columns.tolist())
        return {self.names[k]: self.names[lead] for k, lead in columns if k != lead}

    def forward(self, q: Any, frame: str | None = None, base: Any = None) -> Array:
        """Poses (..., 7) of a frame in the world: x, y, z [m], qw, qx, qy, qz.

        Args:
            q: joint positions (..., dof).
            frame: one of `frames`; None is the tool.
            base: pose (..., 7) of the robot's base in the world; None is the origin.

        Raises:
            InputError: q of another shape or not finite, an unknown frame.
        """
        states, shape = self._read(q)
        out = np.empty((len(states), 7))
        body, offset, turned = self._frame(frame)
        kinematics.poses(states, body, offset, turned, self._machine(), out)
        out = out.reshape(*shape, 7)
        return out if base is None else compose(read_bases(base, shape), out)

    def jacobian(self, q: Any, frame: str | None = None, base: Any = None) -> Array:
        """Jacobians (..., 6, dof) of a frame: linear velocity [m/s], then angular [rad/s], both in world axes.

        Arguments and errors as in `forward`.
        """
        states, shape = self._read(q)
        out = np.zeros((len(states), 6, self.dof))
        body, offset, _ = self._frame(frame)
        kinematics.jacobians(states, body, offset, self._machine(), out)
        out = out.reshape(*shape, 6, self.dof)
        if base is None:
            return out
        turning = read_bases(base, shape)[..., None, 3:]
        columns = out.swapaxes(-1, -2)
        parts = [turn(turning, columns[..., :3]), turn(turning, columns[..., 3:])]
        return np.concatenate(parts, axis=-1).swapaxes(-1, -2)

    def center_of_mass(self, q: Any, base: Any = None) -> Array:
        """Centres of mass (..., 3) of the whole robot in the world; arguments and errors as in `forward`."""
        states, shape = self._read(q)
        out = np.zeros((len(states), 3))
        kinematics.centres(states, self._machine(), out)
        out = out.reshape(*shape, 3)
        return out if base is None else place_points(read_bases(base, shape), out)

    def wrap(self, q: Any) -> Array:
        """(..., dof) q with continuous joints brought into [-π, π)."""
        states, shape = self._read(q)
        return self.space.wrap(states).reshape(*shape, self.dof)

    def couple(self, q: Any) -> Array:
        """(..., dof) q with every follower where its leader puts it."""
        states, shape = self._read(q)
        joints = self.joints
        coupled = joints.offsets + joints.ratios * states[:, joints.columns]
        return np.ascontiguousarray(coupled).reshape(*shape, self.dof)

    def sample(self, count: int, seed: int = 0) -> Array:
        """(count, dof) joint positions uniform within the limits, from -π to π where there are none."""
        lower, upper = self.joints.limits
        lower, upper = np.where(np.isfinite(lower), lower, -np.pi), np.where(np.isfinite(upper), upper, np.pi)
        rng, size = np.random.default_rng(read_whole(seed, "seed")), (read_whole(count, "count"), self.dof)
        return self.couple(rng.uniform(lower, upper, size))

    def self_clearance(self, q: Any) -> Array:
        """Smallest signed distance (...,) [m] between shapes of the robot that are no neighbours.

        Infinite where it has no such shapes. Errors as in `forward`.
        """
        return self._alone.clearance(q)

    def obstacles(
        self,
        scene: "Scene | Iterable[Any] | None" = None,
        *,
        self_collision: bool = True,
        limits: bool = False,
        movable: Iterable[str] = (),
        base: Any = None,
        margin: float = 0.02,
    ) -> "Obstacles":
        """The clearance of this robot in a scene, its gradient, and safe checks of edges.

        Args:
            scene: a `Scene` or a list of shapes; None is empty space.
            self_collision: whether the robot's own shapes count.
            limits: whether joint limits count, a radian as a metre.
            movable: names of obstacles that `move` shall move cheaply, besides those that have a motion.
            base: (7,) pose of a floating base; None is the origin.
            margin: clearance [m] that planners try to keep; they settle for less where there is less.

        Raises:
            SceneError: no scene, or an unknown name.
            InputError: a base pose for a robot whose base is fixed, or a margin that is not above zero.
        """
        from skillfold.robots.obstacles import Obstacles

        return Obstacles.build(self, scene, self_collision, limits, movable, base, margin)

    def dynamics(self, mass: float = 0.0, center: Any = (0.0, 0.0, 0.0)) -> Dynamics:
        """The torques that this robot's motion asks for, with a load fixed to its tool.

        Args:
            mass: of the load [kg].
            center: of its mass, (3,) [m] in the tool frame.
        """
        return Dynamics(self, mass, center)

    def spec(self) -> Any:
        """MuJoCo's specification of the robot, all of it, to add things to and compile."""
        return self._description.spec.copy()

    def lean_spec(self) -> Any:
        """The same without what only pleases the eye: every shape costs time in every pose."""
        return self._spec.copy()

    def compiled_tool(self, frame: str | None = None) -> kinematics.Tool:
        """A frame, None is the tool, for compiled loops of the thread that asks; keep the robot as long."""
        return kinematics.Tool(self._machine(), *self._frame(frame))

    @cached_property
    def _alone(self) -> "Obstacles":
        return self.obstacles()

    def _machine(self) -> Indices:
        """Table for the compiled loops, with this thread's own data."""
        machine = getattr(self._local, "machine", None)
        if machine is None:
            machine = self._local.machine = machine_of(self.model, self.joints)
        return machine.entries

    def _read(self, q: Any) -> tuple[Array, tuple[int, ...]]:
        """Joint positions as (n, dof), and their batch shape."""
        return read_joint_positions(q, self.dof, self.name)

    def _frame(self, name: str | None) -> tuple[int, Array, Array]:
        wanted = self.tool if name is None else name
        if not isinstance(wanted, str) or wanted not in self._frames:
            raise InputError(f"{self.name}: no frame {wanted!r}; possible: {', '.join(self.frames) or NAMELESS}.")
        return self._frames[wanted]


def _again(source: str, loads: tuple[Load, ...]) -> Robot:
    robot = Robot.load(source)
    for load in loads:
        robot = robot._loaded(load)
    return robot
