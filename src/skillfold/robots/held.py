"""`Load`: shapes fixed to a robot's tool, such as a thing in its hand, for what plans and looks out."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.errors import InputError, SceneError
from skillfold.robots.merging import write_shape
from skillfold.robots.scene import Scene
from skillfold.robots.shapes import Box, Capsule, Cylinder, Shape, Sphere

MASK = 1  # as MuJoCo gives it to links: meets them, and obstacles
HELD = "held"  # what a load's body is called; it stands before the names of its shapes, which may be the robot's

_VOLUMES: dict[type[Shape], Callable[[Any], float]] = {
    Box: lambda shape: float(np.prod(shape.size)),
    Sphere: lambda shape: 4 / 3 * np.pi * shape.radius**3,
    Cylinder: lambda shape: np.pi * shape.radius**2 * shape.length,
    Capsule: lambda shape: np.pi * shape.radius**2 * (shape.length + 4 / 3 * shape.radius),
}


@dataclass(frozen=True)
class Load:
    """What is fixed to a tool.

    Attributes:
        body: its name among the robot's bodies.
        shapes: with poses in the tool frame.
        masses: of each shape [kg].
        mask: which other shapes it meets, MuJoCo's contype and conaffinity.
    """

    body: str
    shapes: tuple[Shape, ...]
    masses: tuple[float, ...]
    mask: int = MASK


def read_load(shapes: Any, mass: float, number: int) -> Load:
    """Held shapes as users give them; `number` tells loads of one robot apart.

    Raises:
        SceneError: no shapes, or of a kind that cannot be held.
        InputError: a mass that is none.
    """
    held = Scene([shapes] if isinstance(shapes, Shape) else _listed(shapes)).shapes
    for shape in held:
        if type(shape) not in _VOLUMES or shape.motion is not None:
            kinds = ", ".join(kind.__name__ for kind in _VOLUMES)
            what = "moves" if shape.motion is not None else "cannot be held"
            raise SceneError(f"holding: {shape.title} {what}; possible: {kinds}, each at rest in the tool frame.")
    if not held:
        raise SceneError("holding: no shapes; expected one or more, with poses in the tool frame.")
    if isinstance(mass, bool) or not isinstance(mass, int | float | np.number) or not (0 < mass < np.inf):
        raise InputError(f"holding: mass {mass!r:.40}; expected kilograms, above zero.")
    volumes = np.array([_VOLUMES[type(shape)](shape) for shape in held])
    return Load(f"{HELD}_{number}" if number else HELD, held, tuple((mass * volumes / volumes.sum()).tolist()))


def fix_load(spec: Any, body: Any, pose: Any, load: Load) -> None:
    """Fix a load to a body, whose tool frame stands at `pose` (7,) in it.

    It has a body of its own: where a body's inertia is given, MuJoCo takes none from its shapes.
    """
    place = body.add_frame(pos=pose[:3], quat=pose[3:])
    fixed = body.add_body(name=load.body)
    fixed.set_frame(place)
    for shape, mass in zip(load.shapes, load.masses, strict=True):
        name = shape.name if load.mask != MASK else f"{load.body}: {shape.name}"
        write_shape(spec, fixed, shape, name, shape.placed, mass=mass, contype=load.mask, conaffinity=load.mask)


def _listed(shapes: Any) -> Iterable[Any]:
    return list(shapes) if isinstance(shapes, Iterable) else shapes
