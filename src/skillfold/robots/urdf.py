"""URDF as MuJoCo can read it: meshes found, what only pleases the eye dropped, facts kept that MuJoCo ignores."""

import math
import os
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

from skillfold.errors import RobotError

READABLE = (".stl", ".obj", ".msh")
MACROS = ("{http://www.ros.org/wiki/xacro", "{http://ros.org/wiki/xacro")  # how their elements begin
JOINT_KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")


@dataclass(frozen=True)
class Mimic:
    """A joint that stands at offset + ratio · leader."""

    follower: str
    leader: str
    offset: float
    ratio: float


@dataclass
class Facts:
    """What MuJoCo's reader drops: joints that follow others, velocity limits; and notes for the user."""

    mimics: list[Mimic] = field(default_factory=list)
    speeds: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def prepare(root: ET.Element, file: Path) -> tuple[str, Facts]:
    """URDF text for MuJoCo, with the absolute path of every mesh, and what MuJoCo would not tell.

    Raises:
        RobotError: names the link or joint, the file that is missing or cannot be read, and where it was looked for.
    """
    if any(element.tag.startswith(MACROS) for element in root.iter()):
        raise RobotError(f"{file}: has xacro macros in it; expand them first: xacro {file.name} > robot.urdf.")
    facts = Facts()
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
        _check_inertia(link, file)
        for collision in link.findall("collision"):
            for mesh in collision.iter("mesh"):
                mesh.set("filename", str(_mesh(mesh.get("filename", ""), link.get("name", "?"), file, root)))
    for joint in root.findall("joint"):
        _read_joint(joint, file, facts)
    names = [joint.get("name", "?") for joint in root.findall("joint") if joint.get("type") != "fixed"]
    for mimic in facts.mimics:
        if mimic.leader not in names or mimic.follower not in names:
            given = f"joint {mimic.follower} shall follow joint '{mimic.leader}'"
            raise RobotError(f"{file}: {given}; joints that move: {', '.join(names)}.")
    bare = [link.get("name", "?") for link in root.iter("link") if _only_shapes(link)]
    if bare:
        facts.notes = (f"No inertia: {', '.join(bare)}. Taken from their shapes at the density of water.",)
    _settings(root)
    return ET.tostring(root, encoding="unicode"), facts


def _only_shapes(link: ET.Element) -> bool:
    return link.find("inertial") is None and link.find("collision") is not None


def _check_inertia(link: ET.Element, file: Path) -> None:
    """An inertial element without a mass would come out as no mass at all: taken as absent where it says nothing."""
    inertial = link.find("inertial")
    if inertial is None:
        return
    mass = inertial.find("mass")
    value = _number(mass.get("value") if mass is not None else "0", f"{file}: mass of link {link.get('name')}")
    if value < 0:
        raise RobotError(f"{file}: link {link.get('name')} has mass {value:g}; expected a positive one.")
    if value == 0:
        link.remove(inertial)


def _read_joint(joint: ET.Element, file: Path, facts: Facts) -> None:
    name, kind = joint.get("name", ""), joint.get("type", "")
    if kind not in JOINT_KINDS:
        raise RobotError(f"{file}: joint {name} is of type {kind!r}; possible: {', '.join(JOINT_KINDS)}.")
    limit, mimic = joint.find("limit"), joint.find("mimic")
    if limit is not None and kind == "continuous":
        for side in ("lower", "upper"):  # which some versions of MuJoCo would keep to
            limit.attrib.pop(side, None)
    if limit is not None and kind in ("revolute", "prismatic"):
        _check_order(limit, name, file)
    if limit is not None and (text := limit.get("velocity")):
        speed = _number(text, f"{file}: velocity limit of joint {name}")
        facts.speeds[name] = speed if speed > 0 else math.inf
    if mimic is not None:
        offset = _number(mimic.get("offset", "0"), f"{file}: mimic offset of joint {name}")
        ratio = _number(mimic.get("multiplier", "1"), f"{file}: mimic multiplier of joint {name}")
        facts.mimics.append(Mimic(name, mimic.get("joint", ""), offset, ratio))
        joint.remove(mimic)  # some versions of MuJoCo follow it themselves, others do not


def _check_order(limit: ET.Element, name: str, file: Path) -> None:
    """MuJoCo takes limits in the wrong order for none; whether they are numbers it looks at itself."""
    try:
        lower, upper = (float(limit.get(side, "0")) for side in ("lower", "upper"))
    except ValueError:
        return
    if lower > upper:
        raise RobotError(
            f"{file}: joint {name} has limits from {lower:g} to {upper:g}; expected the lower one first."
        )


def _number(text: str | None, what: str) -> float:
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RobotError(f"{what} is {text!r}; expected a number.")
    return value


def _mesh(name: str, link: str, file: Path, root: ET.Element) -> Path:
    if Path(name).suffix.lower() not in READABLE:
        raise RobotError(
            f"{file}: collision mesh {name!r} of link {link} is of a kind that MuJoCo cannot read; "
            f"expected {', '.join(READABLE)}. Convert it, or use boxes, cylinders and spheres."
        )
    places = list(dict.fromkeys(_places(name, file, root)))
    for place in places:
        if place.is_file():
            return place.resolve()
    looked = ", ".join(str(place) for place in places[:6])
    raise RobotError(f"{file}: collision mesh {name!r} of link {link} was not found; looked for {looked}.")


def _places(name: str, file: Path, root: ET.Element) -> list[Path]:
    """Where a mesh may lie: its own path, beside the URDF, or in a package beside or above it."""
    scheme, _, rest = name.partition("://")
    if not rest:
        scheme, rest = "", name
    compiler = root.find("mujoco/compiler")
    folder = file.parent / (compiler.get("meshdir", "") if compiler is not None else "")
    if scheme not in ("package", "model"):
        return (
            [Path(rest), folder / rest, folder / Path(rest).name]
            if scheme
            else [folder / rest, folder / Path(rest).name]
        )
    package, _, inside = rest.partition("/")
    above = [file.parent, *file.parent.parents]
    roots = [Path(p) for p in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if p]
    found = [up / inside for up in above if up.name == package]
    found += [up / package / inside for up in (*above, *roots)]
    return [*found, *(up / inside for up in above[:3]), folder / Path(inside).name]


def _settings(root: ET.Element) -> None:
    """Keep every link as a frame, paths as they are, and a robot whose inertias do not quite obey physics."""
    block = root.find("mujoco")
    block = ET.SubElement(root, "mujoco") if block is None else block
    compiler = block.find("compiler")
    compiler = ET.SubElement(block, "compiler") if compiler is None else compiler
    compiler.attrib.pop("meshdir", None)
    wanted = {"strippath": "false", "fusestatic": "false", "discardvisual": "true"}
    compiler.attrib.update(wanted)
    compiler.attrib.setdefault("balanceinertia", "true")
