"""`World`: a robot in a scene that can be stepped and looked at, its obstacles as real shapes."""

from typing import TYPE_CHECKING, Any

import numpy as np

from skillfold.errors import InputError
from skillfold.robots.dynamics import frame_of
from skillfold.robots.engine import mujoco
from skillfold.robots.joints import robot_bodies
from skillfold.robots.loading import compiled
from skillfold.robots.merging import PREFIX, add_shape
from skillfold.robots.scene import Scene
from skillfold.robots.shapes import PointCloud, Sphere
from skillfold.robots.tray import LOOSE_MASK, TUMBLER, Tray, add_tray
from skillfold.tables import Array, Indices

_WARNING = mujoco.mjtWarning
FINE = 1e-3  # seconds, longest step of the dynamics

if TYPE_CHECKING:
    from skillfold.robots.robot import Robot

_UNSTABLE = [int(kind) for kind in (_WARNING.mjWARN_BADQPOS, _WARNING.mjWARN_BADQVEL, _WARNING.mjWARN_BADQACC)]


class World:
    """A robot, a scene and perhaps a tray, as one MuJoCo model with its data.

    Attributes:
        robot, scene, tray: what is in it.
        model, data: MuJoCo's.
        places, dofs: (D,) of the robot's joints in qpos and in qvel.
    """

    def __init__(
        self, robot: "Robot", scene: Any = None, tray: Tray | None = None, step: float = 1e-3, visual: bool = False
    ) -> None:
        """Build it; `step` [s] of time between torques, `visual` for shapes that only please the eye.

        Raises:
            InputError: a robot whose base is free.
        """
        if robot.floating:
            raise InputError(f"{robot.name}: its base is free, and would fall; expected one that is fixed.")
        if not (tray is None or isinstance(tray, Tray)):
            raise InputError(f"tray: {type(tray).__name__}; expected a Tray, or None.")
        self.robot, self.tray = robot, tray
        self.scene = scene if isinstance(scene, Scene) else Scene(() if scene is None else scene)
        self.model = compiled(_spec(robot, self.scene, tray, visual), robot.source)
        self._steps = int(np.ceil(step / FINE - 1e-6))
        _set_options(self.model, step / self._steps)
        self.data = mujoco.MjData(self.model)
        self.places: Indices = robot.joints.addresses
        self.dofs: Indices = self.model.jnt_dofadr[robot.joints.numbers].astype(np.int64)
        self._moving = [
            (shape.motion, int(self.model.body_mocapid[self.model.body(PREFIX + shape.name).id]))
            for shape in self.scene
            if shape.motion is not None
        ]
        self._tumblers = [self.model.body(f"{TUMBLER}_{i}").id for i in range(tray.tumblers if tray else 0)]
        self._groups = self._group()

    def reset(self, q: Array) -> None:
        """Robot at positions q (D,), everything at rest, tumblers standing on the tray."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[: len(self.robot.joints.rest)] = self.robot.joints.rest
        self.data.qpos[self.places] = self.robot.couple(q)
        self.move_obstacles(0.0)
        if self.tray is not None:
            self.put_tumblers(self.tray.standing(self.robot.forward(q)))
        mujoco.mj_forward(self.model, self.data)

    def show(self, time: float, q: Array, tumblers: Array) -> None:
        """Everything where it is at a time, without dynamics: q (D,), poses (tumblers, 7)."""
        self.data.qpos[self.places] = q
        self.move_obstacles(time)
        self.put_tumblers(tumblers)
        mujoco.mj_forward(self.model, self.data)

    def put_tumblers(self, poses: Array) -> None:
        """Tumblers at poses (n, 7)."""
        for body, pose in zip(self._tumblers, poses, strict=True):
            start = self.model.jnt_qposadr[self.model.body_jntadr[body]]
            self.data.qpos[start : start + 7] = pose

    def move_obstacles(self, time: float) -> None:
        """Obstacles with a motion where they are at a time [s]."""
        for motion, number in self._moving:
            pose = motion.at(time)
            self.data.mocap_pos[number], self.data.mocap_quat[number] = pose[:3], pose[3:]

    def advance(self, torque: Array) -> None:
        """One step of time under joint torques (D,), which are held all the while."""
        self.data.qfrc_applied[self.dofs] = torque
        mujoco.mj_step(self.model, self.data, self._steps)

    @property
    def stable(self) -> bool:
        """Whether no step went wrong: MuJoCo starts anew from the zero pose where one does."""
        return not any(self.data.warning[kind].number for kind in _UNSTABLE)

    def push(self, body: int, force: Any) -> None:
        """A force (3,) [N] in world axes at a body's centre of mass, until changed."""
        self.data.xfrc_applied[body, :3] = force

    def body(self, body: str | int) -> int:
        """MuJoCo's number of a body by its name, or of what joint 1, 2, … moves.

        Raises:
            InputError: there is none.
        """
        names = [self.model.body(i).name for i in range(1, self.model.nbody)]
        if isinstance(body, str) and body in names:
            return self.model.body(body).id
        if isinstance(body, int | np.integer) and not isinstance(body, bool) and 1 <= body <= self.robot.dof:
            return int(self.model.jnt_bodyid[self.robot.joints.numbers[body - 1]])
        raise InputError(
            f"{self.robot.name}: no body {body!r}; possible: 1 to {self.robot.dof}, {', '.join(filter(None, names))}."
        )

    def tumblers(self) -> Array:
        """Poses (n, 7) of the tumblers."""
        return np.concatenate([self.data.xpos[self._tumblers], self.data.xquat[self._tumblers]], axis=1)

    def touching(self, states: Array) -> int:
        """At how many of joint positions (n, D) robot or tray touch an obstacle or the robot itself, all at rest."""
        count = 0
        for q in states:
            self.data.qpos[self.places] = q
            mujoco.mj_kinematics(self.model, self.data)
            mujoco.mj_collision(self.model, self.data)
            count += bool(self.contacts())
        return count

    def contacts(self) -> list[tuple[str, str]]:
        """What of the robot or the tray touches an obstacle, or the robot itself, by names."""
        count = self.data.ncon
        if not count:
            return []
        contact = self.data.contact
        geoms, near = contact.geom[:count], contact.dist[:count] < 0
        groups = self._groups[geoms]
        told = near & (geoms >= 0).all(1) & (groups >= 0).all(1) & (groups > 0).any(1)
        return sorted({(self._title(a), self._title(b)) for a, b in geoms[told]}) if told.any() else []

    def _title(self, geom: int) -> str:
        name = self.model.geom(geom).name or self.model.body(int(self.model.geom_bodyid[geom])).name
        return name.removeprefix(PREFIX)

    def _group(self) -> Indices:
        """By shape: 1 of the robot or tray, 0 of an obstacle, -1 of a tumbler."""
        mine = robot_bodies(self.model, self.robot.joints)
        bodies = self.model.geom_bodyid
        groups = np.where(mine[bodies], 1, 0)
        groups[[self.model.geom(g).name.startswith(PREFIX) for g in range(self.model.ngeom)]] = 0
        groups[np.isin(bodies, self._tumblers)] = -1
        return groups


def _spec(robot: "Robot", scene: Scene, tray: Tray | None, visual: bool) -> Any:
    spec = robot.spec() if visual else robot.lean_spec()
    for shape in scene:
        if isinstance(shape, PointCloud):
            for i, point in enumerate(np.asarray(shape.points)):
                ball = Sphere(center=point, radius=shape.radius, name=f"{shape.name}: {i}", motion=None)
                add_shape(spec, ball, False)
        else:
            add_shape(spec, shape, shape.motion is not None)
    for geom in spec.geoms:
        if geom.name.startswith(PREFIX):
            geom.contype = geom.conaffinity = LOOSE_MASK
            geom.rgba = [0.55, 0.58, 0.62, 1.0]
    if visual:
        light(spec)
    if tray is not None:
        add_tray(spec, *frame_of(spec, robot.tool), tray, mujoco.mjtGeom)
    return spec


def light(spec: Any) -> None:
    """A white room: MuJoCo's is black, and dark."""
    spec.add_texture(
        name="room",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[1, 1, 1],
        rgb2=[0.86, 0.88, 0.9],
        width=64,
        height=384,
    )
    spec.visual.headlight.ambient = [0.45, 0.45, 0.45]
    spec.visual.headlight.diffuse = [0.5, 0.5, 0.5]


def _set_options(model: Any, step: float) -> None:
    """Torques go straight to the joints."""
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
    set_contacts(model, step)


def set_contacts(model: Any, step: float) -> None:
    """Contacts as stiff and as sticky as MuJoCo does well, at steps [s] of time."""
    model.opt.timestep = step
    several = getattr(mujoco.mjtEnableBit, "mjENBL_MULTICCD", 0)  # points of a contact; later versions always do
    model.opt.enableflags |= int(several)
    model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    model.opt.impratio = 10.0
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
