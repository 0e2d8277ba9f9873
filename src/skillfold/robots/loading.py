"""Robots from bundled models, MJCF and URDF files, as MuJoCo specifications."""

import warnings
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import dataclass, field
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from skillfold.errors import RobotError
from skillfold.robots.engine import listening, mujoco
from skillfold.robots.urdf import Mimic, prepare

MODELS = Path(__file__).parent / "models"
# Given to what moves and has neither shape nor inertia: MuJoCo refuses bodies without mass.
DUMMY_MASS, DUMMY_INERTIA = 1e-3, 1e-6
_TIES = {
    mujoco.mjtEq.mjEQ_CONNECT: "connect",
    mujoco.mjtEq.mjEQ_WELD: "weld",
    mujoco.mjtEq.mjEQ_TENDON: "tendon",
}


@dataclass(frozen=True)
class Description:
    """A robot as its file describes it.

    Attributes:
        source: bundled name, or absolute path.
        spec: MuJoCo's specification.
        speeds: velocity limits that MuJoCo's model has no place for, by joint name.
        notes: what a user should know: shapes that were left out, masses that were made up, ties that are not kept.
    """

    source: str
    spec: Any
    speeds: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def bundled() -> tuple[str, ...]:
    """Names of the robots that come with skillfold."""
    return tuple(sorted(file.stem for file in MODELS.glob("*.xml")))


def describe(name_or_path: str | PathLike[str]) -> Description:
    """The robot of that bundled name or in that file.

    Raises:
        RobotError: there is none, or the file cannot be used.
    """
    file = _find(name_or_path)
    source = file.stem if file.parent == MODELS else str(file)
    root = _root(file)
    if root.tag == "robot":
        text, facts = prepare(root, file)
        spec, warned = _made(file, lambda: mujoco.MjSpec.from_string(text))
        for mimic in facts.mimics:
            _follow(spec, mimic)
        masses, _ = _made(file, lambda: _give_mass(spec))  # a name that two joints have is found here
        return Description(source, spec, facts.speeds, (*facts.notes, *warned, *masses, *_not_kept(spec)))
    if root.tag != "mujoco":
        raise RobotError(f"{file}: its root element is <{root.tag}>; expected <mujoco> (MJCF) or <robot> (URDF).")
    spec, warned = _made(file, lambda: mujoco.MjSpec.from_file(str(file)))
    return Description(source, spec, {}, (*warned, *_give_mass(spec), *_not_kept(spec)))


def compiled(spec: Any, source: str) -> Any:
    """MuJoCo's model of a specification.

    Raises:
        RobotError: MuJoCo refuses it; says why.
    """
    return _made(source, spec.compile)[0]


def lean(spec: Any) -> Any:
    """A copy without what only pleases the eye: every shape costs time in every pose."""
    copy = spec.copy()
    copy.compiler.discardvisual = True
    return copy


def _find(given: str | PathLike[str]) -> Path:
    try:
        text = fspath(given)
    except TypeError:
        text = None
    if not isinstance(text, str):
        raise RobotError(f"Robot {given!r:.80}; expected a name ({', '.join(bundled())}) or a path.")
    if text in bundled():
        return MODELS / f"{text}.xml"
    try:
        file = Path(text).expanduser()
        if file.is_file():
            return file.resolve()
    except (OSError, ValueError, RuntimeError):  # names that no file can have, or of users that do not exist
        pass
    raise RobotError(
        f"Unknown robot '{text}': no such file, and no bundled robot of that name. "
        f"Bundled: {', '.join(bundled())}. Or give the path of an MJCF or URDF file."
    )


def _root(file: Path) -> ET.Element:
    try:
        return ET.fromstring(file.read_bytes())
    except (ET.ParseError, ValueError, LookupError, OSError) as error:
        raise RobotError(f"{file}: no readable XML: {error}.") from None


def _made(source: Any, make: Callable[[], Any]) -> tuple[Any, list[str]]:
    """What MuJoCo makes, and what it warns of."""
    try:
        # Some versions warn in Python's way.
        with listening() as warned, warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            made = make()
    except (ValueError, TypeError, RuntimeError, mujoco.FatalError) as error:
        words = " ".join(str(error).removeprefix("Error:").split())
        raise RobotError(f"{source}: MuJoCo cannot use it: {words}.") from None
    told = [*warned, *(str(warning.message) for warning in caught)]
    return made, [f"MuJoCo: {' '.join(text.split())}." for text in told]


def _follow(spec: Any, mimic: Mimic) -> None:
    """Let one joint follow another, as a constraint of the model."""
    equality = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT)
    equality.name1, equality.name2 = mimic.follower, mimic.leader
    equality.data[:2] = mimic.offset, mimic.ratio


def _give_mass(spec: Any) -> list[str]:
    """Give what moves and has neither shape nor inertia a hair of both; says which bodies."""
    bodies = [body for body in spec.bodies if body.joints and not any(_has_mass(part) for part in _rigid(body))]
    for body in bodies:
        body.mass, body.inertia, body.explicitinertial = DUMMY_MASS, [DUMMY_INERTIA] * 3, True
    names = ", ".join(body.name or "(unnamed)" for body in bodies)
    return [f"No inertia and no shape: {names}. Given {DUMMY_MASS * 1000:g} g each."] if bodies else []


def _not_kept(spec: Any) -> list[str]:
    """Which constraints joint positions do not keep to."""
    ties = [tie for tie in spec.equalities if tie.active and tie.type in _TIES]
    told = ", ".join(f"{_TIES[tie.type]} of {' and '.join(filter(None, (tie.name1, tie.name2)))}" for tie in ties)
    return [f"Every joint is taken to move by itself, whatever the model ties together: {told}."] if ties else []


def _has_mass(body: Any) -> bool:
    return bool(body.explicitinertial or body.mass > 0 or body.geoms)


def _rigid(body: Any) -> list[Any]:
    """A body and all that is fixed to it."""
    return [body, *(part for child in body.bodies if not child.joints for part in _rigid(child))]
