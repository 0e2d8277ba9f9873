"""A Nao that stands on one foot: the same robot hung from that foot, twelve leg joints, the rest as in its home pose.

With the sole fixed to the ground the base's pose follows from the joints, so that planners, obstacles and Jacobians
that know a fixed base serve a robot on one leg too. The world's origin lies below the stance ankle, z up, x ahead.
"""

import itertools
import xml.etree.ElementTree as ET
from functools import cache
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.robots.engine import mujoco
from skillfold.robots.loading import MODELS, Description
from skillfold.robots.poses import turn
from skillfold.robots.robot import Robot
from skillfold.tables import Array, Indices

SIDES = ("left", "right")
CHAIN = ("HipYawPitch", "HipRoll", "HipPitch", "KneePitch", "AnklePitch", "AnkleRoll")  # from the hip to the foot
LEGS = tuple(f"{side}{name}" for side in "LR" for name in CHAIN)


class Standing(Robot):
    """Nao on its left or right foot; made by `standing`.

    Attributes:
        side: of the stance foot.
        whole_names: of the joints of the whole Nao.
    """

    def __init__(self, side: str, description: Description, whole: Robot) -> None:
        super().__init__(description)
        self.side, self.whole_names = side, whole.names
        self._home = whole.home
        self._places: Indices = np.array([whole.names.index(name) for name in self.names])

    def __reduce__(self) -> tuple[Any, ...]:
        return standing, (self.side,)

    @property
    def home(self) -> Array:
        """(12,) knees slightly bent."""
        return self.legs(self._home)

    @property
    def stance(self) -> str:
        """Frame of the sole that stands."""
        return f"{self.side[0]}_sole"

    @property
    def swing(self) -> str:
        """Frame of the other sole."""
        return "r_sole" if self.side == "left" else "l_sole"

    def whole(self, q: Any) -> Array:
        """Joint positions (..., 24) of the whole Nao for q (..., 12): head and arms as in its home pose."""
        states = np.asarray(q, np.float64)
        out = np.broadcast_to(self._home, (*states.shape[:-1], len(self._home))).copy()
        out[..., self._places] = states
        return out

    def legs(self, whole: Any) -> Array:
        """Joint positions (..., 12) of q (..., 24) of the whole Nao."""
        return np.asarray(whole, np.float64)[..., self._places]


@cache
def standing(side: str) -> Standing:
    """Nao on its `left` or `right` foot.

    Raises:
        InputError: another side.
    """
    if side not in SIDES:
        raise InputError(f"standing on {side!r}; possible: {', '.join(SIDES)}.")
    nao = Robot.load("nao")
    spec = mujoco.MjSpec.from_string(_hung(side, dict(zip(nao.names, nao.home.tolist(), strict=True))))
    return Standing(side, Description(f"nao on its {side} foot", spec), nao)


def _hung(side: str, home: dict[str, float]) -> str:
    """The bundled model as text, hung from a foot."""
    root = ET.parse(MODELS / "nao.xml").getroot()
    world = _part(root, "worldbody")
    torso = _part(world, "body")
    torso.remove(_part(torso, "freejoint"))
    _stiffen(root, torso, home)
    world.remove(torso)
    world.append(_turned_over(torso, "L" if side == "left" else "R"))
    return ET.tostring(root, encoding="unicode")


def _part(element: ET.Element, path: str) -> ET.Element:
    found = element.find(path)
    if found is None:
        raise InputError(f"<{element.tag}> has no {path}; expected the bundled Nao.")
    return found


def _stiffen(root: ET.Element, torso: ET.Element, home: dict[str, float]) -> None:
    """Fix every joint that is none of the legs' at its home position; leave out what speaks of it."""
    for body in torso.iter("body"):
        joint = body.find("joint")
        if joint is not None and joint.get("name") not in LEGS:
            half, axis = home[str(joint.get("name"))] / 2, _numbers(joint, "axis")
            body.set("quat", _text(np.concatenate([[np.cos(half)], np.sin(half) * axis])))
            body.remove(joint)
    motors = _part(root, "actuator")
    for motor in list(motors):
        if motor.get("joint") not in LEGS:
            motors.remove(motor)
    # Speeds are listed by joint, and the order changes: the whole robot knows them.
    root.remove(_part(root, "custom"))
    root.remove(_part(root, "keyframe"))


def _turned_over(torso: ET.Element, letter: str) -> ET.Element:
    """The chain from the torso to a foot, foot first; each joint turns the other way round about the same axis."""
    chain = [torso]
    for name in CHAIN:
        child = _part(chain[-1], f"body[@name='{letter}{name}Link']")
        chain[-1].remove(child)
        chain.append(child)
    foot = chain[-1]
    below = _numbers(_part(foot, f"site[@name='{letter.lower()}_sole']"), "pos")
    for parent, body in itertools.pairwise(chain):
        joint, place = _part(body, "joint"), _numbers(body, "pos")
        body.remove(joint)
        joint.set("axis", _text(-_numbers(joint, "axis")))
        joint.set("pos", _text(place))
        parent.insert(0, joint)
        parent.set("pos", _text(-place))
        body.append(parent)
    foot.set("pos", _text(-below))
    return foot


def _numbers(element: ET.Element, name: str) -> Array:
    return np.array([float(text) for text in str(element.get(name)).split()])


def _text(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def base_of(nao: Robot, whole: Array, sole: str, ground: Any = (0.0, 0.0, 0.0)) -> Array:
    """Pose (..., 7) of the floating base with which a sole of the whole Nao stands flat at a place on the ground.

    Args:
        nao: `Robot.load("nao")`.
        whole: (..., 24) joint positions.
        sole: frame that stands.
        ground: (3,) below its ankle; the foot points along x.
    """
    foot = nao.forward(whole, sole)
    back = foot[..., 3:] * np.array([1.0, -1.0, -1.0, -1.0])
    return np.concatenate([np.asarray(ground) - turn(back, foot[..., :3]), back], axis=-1)
