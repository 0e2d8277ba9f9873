"""Keyframes as users hand them in, read and checked: arrays, recordings, files."""

from os import PathLike
from typing import Any

import numpy as np

from skillfold.demonstrations import Demonstration, Demonstrations
from skillfold.errors import InputError
from skillfold.keyframes.extraction import extract
from skillfold.recordings import shortened
from skillfold.robots.poses import read_pose

Array = np.ndarray[Any, np.dtype[np.float64]]

POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")
MANY = 30  # keyframes of a demonstration: more are a recording, and would take minutes to lay along each other
FARTHEST = 1e6  # metres; products of larger positions would drown what they differ by


def read_keyframes(
    given: Any, extracted: bool = False, gripper: str | None = None
) -> tuple[tuple[Array, ...], tuple[str, ...]]:
    """Keyframes (m, 7) of each demonstration, read-only, and the demonstrations' names.

    Args:
        given: list of arrays (m, 7), an array (n_demos, m, 7), `Demonstrations`, or a file or files of them.
        extracted: the recordings are full ones, from which keyframes are taken.
        gripper: name of the gripper's column in full recordings.

    Raises:
        InputError: says which demonstration, and what was expected.
    """
    if isinstance(given, str | PathLike):
        given = Demonstrations.load(given, moving=extracted or gripper is not None)
    if isinstance(given, Demonstrations):
        labels = tuple(d.label for d in given)
        parts = [_of_recording(d, given.names, extracted, gripper) for d in given]
    else:
        if gripper is not None:
            raise InputError(f"gripper={gripper!r}: arrays have no named columns; expected Demonstrations or a file.")
        parts = [_of_array(one, f"demonstration {i}") for i, one in enumerate(_listed(given))]
        parts = [part[extract(part)] for part in parts] if extracted else parts
        labels = tuple(str(i) for i in range(len(parts)))
    for part, label in zip(parts, labels, strict=True):
        if len(part) > MANY:
            raise InputError(
                f"demonstration '{label}': {len(part)} keyframes; expected {MANY} at most. Of a full recording, "
                "extract=True or gripper='<column>' takes keyframes."
            )
        part.flags.writeable = False
    return tuple(parts), labels


def _listed(given: Any) -> list[Any]:
    if isinstance(given, list | tuple) or (isinstance(given, np.ndarray) and given.ndim == 3):
        if len(given):
            return list(given)
        raise InputError("keyframes: no demonstrations; expected one at least.")
    raise InputError(
        f"keyframes: got {shortened(given)}; expected a list of arrays (m, 7), one for each demonstration, an array "
        "(n_demos, m, 7), Demonstrations, or the path of a file with a demo column."
    )


def _of_array(given: Any, place: str) -> Array:
    poses = read_pose(given, place)
    if poses.ndim != 2 or not len(poses) or np.shape(given)[-1] != 7:
        raise InputError(f"{place}: shape {np.shape(given)}; expected keyframes (m, 7): {', '.join(POSE)}.")
    if not (np.abs(poses[:, :3]) < FARTHEST).all():
        raise InputError(f"{place}: a position beyond {FARTHEST:g} m; expected metres.")
    return poses


def _of_recording(demo: Demonstration, names: tuple[str, ...], extracted: bool, gripper: str | None) -> Array:
    columns = _pose_columns(names)
    poses = _of_array(np.asarray(demo.states)[:, columns], f"demonstration '{demo.label}'")
    if gripper is None:
        return poses[extract(poses, demo.times)] if extracted else poses
    if gripper not in names or names.index(gripper) in columns:
        possible = [name for i, name in enumerate(names) if i not in columns]
        raise InputError(f"gripper={gripper!r}: no such column; possible: {', '.join(possible) or 'none'}.")
    return poses[extract(poses, demo.times, np.asarray(demo.states)[:, names.index(gripper)])]


def _pose_columns(names: tuple[str, ...]) -> list[int]:
    """Columns of the pose, in small letters or capitals; seven without names of their own are one."""
    if names == tuple(f"x{i}" for i in range(7)):
        return list(range(7))
    places = {name.lower(): i for i, name in enumerate(names)} | {name: i for i, name in enumerate(names)}
    missing = [name for name in POSE if name not in places]
    if missing:
        raise InputError(f"keyframes: columns {', '.join(names)}; expected {', '.join(POSE)} [m, unit quaternion].")
    return [places[name] for name in POSE]
