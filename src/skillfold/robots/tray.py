"""`Tray`: a tray on a robot's tool, with tumblers that stand free on it (paper 000, section VI)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.robots.held import Load
from skillfold.robots.poses import compose, read_numbers
from skillfold.robots.reading import read_whole
from skillfold.robots.shapes import Box, Cylinder
from skillfold.tables import Array

TRAY, TUMBLER = "tray", "tumbler"
TRAY_MASK, LOOSE_MASK = 2, 3  # the tray meets tumblers and obstacles, not the robot; tumblers meet all


@dataclass(frozen=True)
class Tray:
    """A tray across the z axis of the tool frame, and tumblers in a circle on it.

    Attributes:
        size: full edge lengths (x, y, z) [m].
        height: of its upper side above the tool frame [m].
        tumblers: how many.
        radius, length: of a tumbler [m].
        mass, tumbler_mass: of the tray, of each tumbler [kg].
        circle: radius of the circle the tumblers stand on [m].
        friction: between them and the tray.

    Raises:
        InputError: sizes or masses that are not above zero, or a number of tumblers that is none.
    """

    size: tuple[float, float, float] = (0.26, 0.26, 0.01)
    height: float = 0.03
    tumblers: int = 3
    radius: float = 0.03
    length: float = 0.12
    mass: float = 0.3
    tumbler_mass: float = 0.15
    circle: float = 0.07
    friction: float = 1.0

    def __post_init__(self) -> None:
        size = read_numbers(self.size, "Tray: size", "three full edge lengths [m]")
        for name in ("height", "radius", "length", "mass", "tumbler_mass", "circle", "friction"):
            if read_numbers(getattr(self, name), f"Tray: {name}", "a number").ndim:
                raise InputError(f"Tray: {name} {getattr(self, name)!r:.40}; expected one number.")
        read_whole(self.tumblers, "Tray: tumblers")
        lengths = (*size.flat, self.radius, self.length, self.mass, self.tumbler_mass, self.friction)
        if size.shape != (3,) or not all(v > 0 for v in lengths):
            raise InputError(f"{self}; expected three edge lengths, and all lengths and masses above zero.")

    @property
    def load(self) -> tuple[float, Array]:
        """Mass [kg] of all and its centre (3,) [m] in the tool frame, while all stand."""
        mass = self.mass + self.tumblers * self.tumbler_mass
        loose = self.tumblers * self.tumbler_mass * (self.height + self.length / 2)
        return mass, np.array([0.0, 0.0, (self.mass * (self.height - self.size[2] / 2) + loose) / mass])

    @property
    def fixed(self) -> Load:
        """The tray, and on it the room that standing tumblers take, with their mass.

        Neither meets the robot itself: the tray is built so that it does not.
        """
        middle = self.height - self.size[2] / 2
        plate = Box((0.0, 0.0, middle), self.size, name=TRAY)
        if not self.tumblers:
            return Load(TRAY, (plate,), (self.mass,), TRAY_MASK)
        around = self.radius + (self.circle if self.tumblers > 1 else 0.0)
        room = Cylinder((0.0, 0.0, self.height + self.length / 2), around, self.length, name=f"{TUMBLER}s")
        return Load(TRAY, (plate, room), (self.mass, self.tumblers * self.tumbler_mass), TRAY_MASK)

    def standing(self, pose_world_tool: Array) -> Array:
        """Poses (tumblers, 7) in the world of tumblers that stand on the tray."""
        angles = 2 * np.pi * np.arange(self.tumblers) / max(self.tumblers, 1)
        circle = self.circle if self.tumblers > 1 else 0.0
        places = np.zeros((self.tumblers, 7))
        places[:, 0], places[:, 1] = circle * np.cos(angles), circle * np.sin(angles)
        places[:, 2], places[:, 3] = self.height + self.length / 2, 1.0
        return compose(np.broadcast_to(pose_world_tool, places.shape), places)


def read_tray(tray: Any, loads: Sequence[Load]) -> Load:
    """A tray as what is fixed to the tool of a robot that holds `loads`.

    Raises:
        InputError: no tray, or a second one.
    """
    if not isinstance(tray, Tray):
        raise InputError(f"with_tray: {type(tray).__name__}; expected a Tray.")
    if any(load.body == TRAY for load in loads):
        raise InputError("with_tray: the robot carries a tray already; expected one.")
    return tray.fixed


def add_tray(spec: Any, body: Any, pose: Array, tray: Tray, kinds: Any) -> None:
    """Add the tray to a body, at the pose (7,) of the tool frame in it, and the tumblers to the world.

    Args:
        spec: MuJoCo's specification.
        body: of the tool.
        pose: of the tool frame in the body.
        tray: what to add.
        kinds: MuJoCo's kinds of shapes.
    """
    place = body.add_frame(pos=pose[:3], quat=pose[3:])
    plate = body.add_body(name=TRAY, pos=[0, 0, tray.height - tray.size[2] / 2])
    plate.set_frame(place)
    half = [edge / 2 for edge in tray.size]
    look = {"friction": [tray.friction, 0.005, 0.0001], "contype": TRAY_MASK, "conaffinity": TRAY_MASK, "condim": 4}
    plate.add_geom(name=TRAY, type=kinds.mjGEOM_BOX, size=half, mass=tray.mass, rgba=[0.75, 0.75, 0.78, 1.0], **look)
    look |= {"contype": LOOSE_MASK, "conaffinity": LOOSE_MASK}
    for i in range(tray.tumblers):
        loose = spec.worldbody.add_body(name=f"{TUMBLER}_{i}")
        loose.add_freejoint()
        loose.add_geom(
            name=f"{TUMBLER}_{i}",
            type=kinds.mjGEOM_CYLINDER,
            size=[tray.radius, tray.length / 2, 0],
            mass=tray.tumbler_mass,
            rgba=[0.35, 0.6, 0.85, 0.9],
            **look,
        )
