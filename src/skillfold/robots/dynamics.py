"""`Dynamics`: the torques that a robot's motion asks for."""

import threading
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from skillfold.errors import InputError
from skillfold.jit import pointer
from skillfold.robots.engine import mujoco
from skillfold.robots.inverse import ARMATURE, DOFS, FORCES, PASSIVE, QACC, QVEL, SLOTS, inverse, inverses
from skillfold.robots.joints import Joints, pose_slots
from skillfold.robots.loading import compiled
from skillfold.robots.poses import read_pose
from skillfold.robots.reading import read_amount, read_joint_positions
from skillfold.tables import Array, Indices, Table, table_of

if TYPE_CHECKING:
    from skillfold.robots.robot import Robot

LOAD = "skillfold load"


class CompiledDynamics(NamedTuple):
    """Inverse dynamics for compiled loops; keep this as long as it is in use.

    Attributes:
        inverse: (q, qd, qdd, arguments, out), all (dof,) but the arguments; see `Dynamics.torque`.
        arguments: int64 array, for one thread.
        owner: what the arguments point to.
    """

    inverse: Any
    arguments: Indices
    owner: Any


class Dynamics:
    """Inverse dynamics of a robot; made by `Robot.dynamics`.

    Gravity, where the model does not compensate it, inertia (armature and a load included), velocity terms, the
    joints' springs and damping; no dry friction, no tendons and no contacts. A floating base is held where it is.
    May be asked from several threads at once.
    """

    def __init__(self, robot: "Robot", mass: float, center: Any) -> None:
        self._name, self._joints = robot.name, robot.joints
        spec = robot.lean_spec()
        mass = read_amount(mass, "mass", "kilograms")
        if mass:
            _attach(spec, robot.tool, mass, center)
        self._model = compiled(spec, robot.source)
        for name in ("tendon_stiffness", "tendon_stiffnesspoly"):  # their lengths are not looked at
            getattr(self._model, name, np.zeros(0))[:] = 0.0  # not all versions have both
        self._local = threading.local()

    def torque(self, q: Any, qd: Any, qdd: Any) -> Array:
        """Torques (..., dof) [N m, N] that give accelerations qdd at positions q and velocities qd, all (..., dof).

        Raises:
            InputError: arguments of another shape, or not finite.
        """
        try:
            given = np.broadcast_arrays(q, qd, qdd)
        except ValueError:
            raise InputError(f"{self._name}: positions, velocities and accelerations do not go together.") from None
        (states, shape), (speeds, _), (rises, _) = (self._read(values) for values in given)
        out = np.empty(states.shape)
        inverses(states, speeds, rises, self._table().entries, out)
        return out.reshape(*shape, self._joints.dof)

    def bias(self, q: Any, qd: Any) -> Array:
        """Torques (..., dof) at no acceleration: gravity, Coriolis and centrifugal terms, damping."""
        return self.torque(q, qd, np.zeros(self._joints.dof))

    def mass_matrix(self, q: Any) -> Array:
        """Inertia matrices M (..., dof, dof) [kg m²] at positions q (..., dof)."""
        states, shape = self._read(q)
        states = states.reshape(*shape, 1, self._joints.dof)
        still = np.zeros(self._joints.dof)
        columns = self.torque(states, still, np.eye(self._joints.dof)) - self.bias(states, still)
        return 0.5 * (columns + columns.swapaxes(-1, -2))

    def compiled(self) -> CompiledDynamics:
        """The same for compiled loops, for the thread that asks."""
        table = self._table()
        return CompiledDynamics(_pointer(), table.entries, table)

    def _read(self, values: Any) -> tuple[Array, tuple[int, ...]]:
        return read_joint_positions(values, self._joints.dof, self._name)

    def _table(self) -> Table:
        found = getattr(self._local, "table", None)
        if found is None:
            found = self._local.table = _table_of(self._model, self._joints)
        return found


def _table_of(model: Any, joints: Joints) -> Table:
    data = mujoco.MjData(model)
    dofs = model.jnt_dofadr[joints.numbers]
    slots = pose_slots(model, data, joints, None) | {
        QVEL: data.qvel,
        QACC: data.qacc,
        DOFS: dofs.astype(np.int64),
        ARMATURE: model.dof_armature[dofs],
        PASSIVE: data.qfrc_passive,
        FORCES: np.zeros(model.nv),
    }
    return table_of(slots, SLOTS, model, data)


def _attach(spec: Any, frame: str, mass: float, center: Any) -> None:
    """Add a small heavy body at a point of the tool frame."""
    body, pose = frame_of(spec, frame)
    place = body.add_frame(pos=pose[:3], quat=pose[3:])
    load = body.add_body(name=LOAD, mass=mass, pos=np.asarray(read_pose(center, "center"))[:3])
    load.explicitinertial, load.inertia, load.ipos = True, [1e-4 * mass] * 3, [0.0, 0.0, 0.0]
    load.set_frame(place)


def frame_of(spec: Any, frame: str) -> tuple[Any, Array]:
    """The body that a frame of a robot is fixed to, and its pose (7,) there."""
    site = next((site for site in spec.sites if site.name == frame), None)
    if site is not None:
        return site.parent, np.concatenate([site.pos, site.quat])
    return spec.body(frame), np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


def _inverse(q: Array, qd: Array, qdd: Array, arguments: Indices, out: Array) -> float:
    inverse(q, qd, qdd, arguments, out)
    return 0.0


_made: list[Any] = []


def _pointer() -> Any:
    """Compiled at first use, or found on disk."""
    if not _made:
        row, table = np.empty(0), np.empty(0, np.int64)
        _made.append(pointer(_inverse, 0.0, row, row, row, table, row))
    return _made[0]
