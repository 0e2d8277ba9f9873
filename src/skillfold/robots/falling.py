"""A robot with a free base on a flat floor: every joint a position servo as strong as its motor, and time runs.

What stands may fall here. Servos are alike in every joint; contacts, as in `world`, as stiff and as sticky as MuJoCo
does well.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.robots.engine import mujoco
from skillfold.robots.joints import robot_bodies
from skillfold.robots.loading import compiled
from skillfold.robots.merging import PREFIX, add_shape
from skillfold.robots.poses import turn
from skillfold.robots.robot import Robot
from skillfold.robots.scene import Scene
from skillfold.robots.world import light, set_contacts
from skillfold.tables import Array

FLOOR = "floor"
STIFFNESS, DAMPING = 200.0, 5.0  # N m/rad, N m s/rad: full torque at a hundredth to a fiftieth of a radian
FRICTION = 0.8
GLOW = 0.34  # of the floor in pictures: lit from the eye alone, what lies flat is dark
STEP = 1e-3  # s
UP = np.array([0.0, 0.0, 1.0])


class Falling:
    """A robot on the floor z = 0, perhaps among obstacles that stand still.

    Attributes:
        robot: with a free base.
        model, data: MuJoCo's.
    """

    def __init__(
        self, robot: Robot, scene: Any = None, own: bool = True, passing: Iterable[str] = (), visual: bool = False
    ) -> None:
        """Build it.

        Args:
            robot: that may fall.
            scene: obstacles.
            own: whether the robot's parts stop each other.
            passing: names of bodies that nothing stops.
            visual: with shapes that only please the eye, and light.

        Raises:
            InputError: a robot whose base is fixed.
        """
        base = robot.joints.base
        if base is None:
            raise InputError(f"{robot.name}: its base is fixed, and cannot fall; expected one that is free.")
        self.robot, self._base = robot, base
        self.model = compiled(
            _spec(robot, Scene(() if scene is None else scene), own, set(passing), visual), robot.source
        )
        set_contacts(self.model, STEP)
        self.data = mujoco.MjData(self.model)
        self._places = robot.joints.addresses
        self._driven = np.array([robot.names.index(self.model.actuator(i).name) for i in range(self.model.nu)])
        self._own = robot_bodies(self.model, robot.joints)
        self._own[0] = False

    def reset(self, q: Array, base: Array) -> None:
        """At rest at joint positions q (dof,), its base at a pose (7,), the servos told to stay."""
        mujoco.mj_resetData(self.model, self.data)
        self.show(q, base)
        self.data.ctrl[:] = self.robot.couple(q)[self._driven]

    def show(self, q: Array, base: Array) -> None:
        """Where it would be, without dynamics."""
        self.data.qpos[self._base : self._base + 7] = base
        self.data.qpos[self._places] = self.robot.couple(q)
        mujoco.mj_forward(self.model, self.data)

    def hold(self, seconds: float) -> None:
        """Servos stay as they were last told."""
        mujoco.mj_step(self.model, self.data, round(seconds / STEP))

    def follow(self, states: Array, seconds: float, every: float = 0.01) -> Array:
        """Servos are led along states (n, dof), from rest to rest; the base's poses (m, 7) every so often [s]."""
        count, ticks = round(every / STEP), max(round(seconds / every), 1)
        wanted = self.robot.couple(states)[:, self._driven]
        share = np.arange(1, ticks + 1) / ticks
        # Fifth-order time law: neither speed nor acceleration at the ends.
        places = share**3 * (10 - 15 * share + 6 * share**2) * (len(states) - 1)
        seen = np.empty((ticks, 7))
        for i, place in enumerate(places):
            first = min(int(place), len(states) - 2) if len(states) > 1 else 0
            last = min(first + 1, len(states) - 1)
            self.data.ctrl[:] = wanted[first] + (place - first) * (wanted[last] - wanted[first])
            mujoco.mj_step(self.model, self.data, count)
            seen[i] = self.base
        return seen

    @property
    def base(self) -> Array:
        """Pose (7,) of the base."""
        return self.data.qpos[self._base : self._base + 7].copy()

    @property
    def joints(self) -> Array:
        """Joint positions (dof,)."""
        return self.data.qpos[self._places].copy()

    def leaning(self, wanted: Array) -> float:
        """Angle [rad] between up in the base's frame now, and as it would be at a wanted pose (7,)."""
        now, then = (turn(q * [1.0, -1.0, -1.0, -1.0], UP) for q in (self.base[3:], wanted[3:]))
        return float(np.arctan2(np.linalg.norm(np.cross(now, then)), now @ then))

    def touching(self) -> set[str]:
        """Bodies of the robot that touch the floor."""
        floor = self.model.geom(FLOOR).id
        pairs = [contact.geom for contact in self.data.contact if floor in contact.geom]
        others = [int(a if b == floor else b) for a, b in pairs]
        return {self.model.body(int(self.model.geom_bodyid[g])).name for g in others}

    def bumps(self) -> set[tuple[str, str]]:
        """Pairs of the robot's own bodies, or a body and an obstacle, that touch."""
        floor, found = self.model.geom(FLOOR).id, set()
        for contact in self.data.contact:
            if floor not in contact.geom and contact.dist < 0:
                a, b = sorted(self._title(int(g)) for g in contact.geom)
                found.add((a, b))
        return found

    def _title(self, geom: int) -> str:
        body = int(self.model.geom_bodyid[geom])
        return self.model.body(body).name if self._own[body] else self.model.geom(geom).name.removeprefix(PREFIX)


def _spec(robot: Robot, scene: Scene, own: bool, passing: set[str], visual: bool) -> Any:
    spec = robot.spec() if visual else robot.lean_spec()
    for geom in spec.geoms:
        if not own:
            geom.conaffinity = 0  # what meets the floor and obstacles still has its contype
        if geom.parent.name in passing:
            geom.contype = geom.conaffinity = 0
    spec.worldbody.add_geom(
        name=FLOOR,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0.0, 0.0, 0.05],
        rgba=[0.93, 0.94, 0.95, 1.0],
        friction=[FRICTION, 0.005, 0.0001],
    )
    for shape in scene:
        add_shape(spec, shape, False)
    for motor in spec.actuators:
        motor.gainprm[0] = STIFFNESS
        motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        motor.biasprm[:3] = 0.0, -STIFFNESS, -DAMPING
        motor.forcerange, motor.forcelimited = motor.ctrlrange, True
        motor.ctrllimited = False
    if visual:
        light(spec)
        spec.add_material(name=FLOOR, rgba=[0.93, 0.94, 0.95, 1.0], emission=GLOW)
        spec.geom(FLOOR).material = FLOOR
    return spec
