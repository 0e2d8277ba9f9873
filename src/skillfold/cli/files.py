"""Files that commands read and write: skills, output, and single states named in short."""

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from skillfold.cli import console
from skillfold.errors import InputError, SkillFileError

if TYPE_CHECKING:
    from skillfold.demonstrations import Demonstrations
    from skillfold.keyframes.skill import KeyframeSkill
    from skillfold.manifold.skill import SkillManifold
    from skillfold.robots.robot import Robot

KINDS: dict[str, Literal["manifold", "keyframes"]] = {"skill manifold": "manifold", "keyframes": "keyframes"}
DEMO = re.compile(r"demo:(\d{1,9}):(\w+)")
FORMS = "numbers (0.1,0.2), a state of a CSV file (states.csv:3, counted from 0) or of a recording (demo:0:first)"


def kind(path: Path) -> Literal["manifold", "keyframes"]:
    """Which kind of skill a file holds.

    Raises:
        SkillFileError: neither.
    """
    from skillfold import archive

    found = archive.kind_of(path)
    if found not in KINDS:
        raise SkillFileError(f"{path}: holds {found!r:.40}; expected a skill: {' or '.join(KINDS)}.")
    return KINDS[found]


def load_keyframes(path: Path) -> "KeyframeSkill":
    """A saved skill of keyframes."""
    from skillfold.keyframes.skill import KeyframeSkill

    return KeyframeSkill.load(path)


def load(path: Path) -> "SkillManifold":
    """A saved skill manifold."""
    from skillfold.manifold.skill import SkillManifold

    return SkillManifold.load(path)


def load_robot(name: str) -> "Robot":
    """A robot; what was left out or made up on loading is said."""
    from skillfold.robots.robot import Robot

    robot = Robot.load(name)
    for note in robot.notes:
        console.say(f"note: {name}: {note}")
    return robot


def writable(path: Path, *kinds: str) -> Path:
    """The path, if a file can be written there: better told before the work than after.

    Raises:
        InputError: a folder, or in a folder that is missing or locked; or its name ends in none of the kinds, such as
            .csv, where some are given.
    """
    if path.is_dir():
        raise InputError(f"{path}: is a folder; expected the name of a file to write.")
    if kinds and path.suffix.lower() not in kinds:
        raise InputError(f"{path}: ends in {path.suffix or 'nothing'}; possible: {', '.join(kinds)}.")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}; make it first.")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise InputError(f"{path}: cannot be written: permission denied.")
    return path


def folder(path: Path) -> Path:
    """The folder, made where it is missing.

    Raises:
        InputError: it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: no folder can be made: {error.strerror or error}.") from None
    return path


def existing_folder(option: str, path: Path) -> Path:
    """The folder, which must be there.

    Raises:
        InputError: it is not.
    """
    if not path.is_dir():
        raise InputError(f"{option} {path}: no such folder.")
    return path


def write_text(path: Path, text: str) -> None:
    """Write a text file.

    Raises:
        InputError: it cannot be written.
    """
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}.") from None


def state(option: str, text: str, skill: "SkillManifold", demos: "Demonstrations | None") -> Any:
    """The state (D,) that the text of an option names.

    Raises:
        InputError: says what was given and what is possible.
    """
    if text.startswith("demo:"):
        return _of_demonstration(option, text, skill, demos)
    if ".csv:" in text.lower():
        return _of_file(option, text, skill)
    return _numbers(option, text, skill)


def _numbers(option: str, text: str, skill: "SkillManifold") -> list[float]:
    try:
        values = [float(part) for part in text.replace(",", " ").split()]
    except ValueError:
        raise InputError(f"{option} {text!r}: expected {FORMS}.") from None
    if len(values) != skill.n_dims:
        raise InputError(
            f"{option} {text!r}: {len(values)} numbers; expected {skill.n_dims}: {', '.join(skill.names)}."
        )
    return values


def _of_file(option: str, text: str, skill: "SkillManifold") -> Any:
    from skillfold.io.state_files import read_states

    path, _, row = text.rpartition(":")
    states = read_states(Path(path), skill.names).states
    return states[_row(option, text, row, len(states))]


def _of_demonstration(option: str, text: str, skill: "SkillManifold", demos: "Demonstrations | None") -> Any:
    found = DEMO.fullmatch(text)
    if found is None:
        raise InputError(
            f"{option} {text!r}: expected demo:NUMBER:STATE, such as demo:0:first, demo:2:last, demo:0:57."
        )
    ends = _stored_ends(option, text, skill) if demos is None else [d.states for d in demos]
    number = int(found[1])
    if number >= len(ends):
        raise InputError(f"{option} {text!r}: there are {len(ends)} demonstrations, counted from 0.")
    if demos is None and found[2] not in ("first", "last"):
        raise InputError(f"{option} {text!r}: a skill keeps only first and last; name the files with --recordings.")
    return ends[number][_row(option, text, found[2], len(ends[number]))]


def _stored_ends(option: str, text: str, skill: "SkillManifold") -> Any:
    """(n_demos, 2, D) first and last states, to rounding as they were recorded."""
    if skill.route is None:
        raise InputError(
            f"{option} {text!r}: this skill was learnt without whole recordings; name the files with --recordings."
        )
    return skill.route.curves[:, [0, -1]] * skill.route.scale + skill.route.centre


def _row(option: str, text: str, row: str, count: int) -> int:
    if row in ("first", "last"):
        return 0 if row == "first" else count - 1
    if not row.isdecimal() or int(row) >= count:
        raise InputError(f"{option} {text!r}: expected first, last or a number from 0 to {count - 1}, got {row!r}.")
    return int(row)
