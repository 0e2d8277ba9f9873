"""Files of closed-loop runs: everything in a sealed NPZ, the steps as a CSV table."""

import csv
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skillfold import archive
from skillfold.archive import Arrays, blaming
from skillfold.errors import SkillFileError

if TYPE_CHECKING:
    from skillfold.control.rollout import Rollout

KIND, VERSION = "skillfold rollout", 1
# Shape of each array: n steps, D joints, k tumblers.
SHAPES = {
    "times": ("n",),
    "states": ("n", "D"),
    "velocities": ("n", "D"),
    "torques": ("n", "D"),
    "modes": ("n",),
    "distances": ("n",),
    "clearances": ("n",),
    "tool_poses": ("n", 7),
    "tumblers": ("n", "k", 7),
    "step_times": ("n",),
}


def write_rollout(path: str | PathLike[str], rollout: "Rollout") -> None:
    """Write a run as `.npz` or `.csv`.

    Raises:
        SkillFileError: the file cannot be written, or ends in something else.
    """
    try:
        path = Path(path)
    except TypeError:
        raise SkillFileError(f"{path!r:.40}: no path; expected the name of a file.") from None
    kind = path.suffix.lower()
    if kind == ".npz":
        header = {
            "kind": KIND,
            "version": VERSION,
            "names": list(rollout.names),
            "contacts": [list(contact) for contact in rollout.contacts],
            "facts": rollout.facts,
        }
        archive.write(path, header, {name: getattr(rollout, name) for name in SHAPES})
    elif kind == ".csv":
        _write_table(path, rollout)
    else:
        raise SkillFileError(f"{path}: ends in {kind or 'nothing'!r}; possible: .npz, .csv.")


def read_rollout(path: str | PathLike[str]) -> tuple[Arrays, list[Any], tuple[str, ...], dict[str, Any]]:
    """Arrays, contacts, joint names and facts of a run.

    Raises:
        SkillFileError: the file is missing, damaged, or no run.
    """
    header, arrays = archive.read(path, KIND)
    with blaming(path, "not a run that skillfold saved"):
        if header["version"] != VERSION:
            raise ValueError(f"version {header['version']}, expected {VERSION}")
        _check(arrays)
        contacts = [(str(a), str(b), float(start), float(end)) for a, b, start, end in header["contacts"]]
        names = tuple(str(name) for name in header["names"])
        if len(names) != arrays["states"].shape[1]:
            raise ValueError(f"{len(names)} names for {arrays['states'].shape[1]} joints")
        return arrays, contacts, names, dict(header["facts"])


def _check(arrays: Arrays) -> None:
    if set(arrays) != set(SHAPES):
        raise ValueError(f"arrays {', '.join(sorted(arrays))}; expected {', '.join(SHAPES)}")
    sizes: dict[Any, int] = {}
    for name, shape in SHAPES.items():
        array = arrays[name]
        fits = array.ndim == len(shape) and array.dtype.kind == ("U" if name == "modes" else "f")
        for size, axis in zip(array.shape, shape, strict=False):
            fits = fits and size == (axis if isinstance(axis, int) else sizes.setdefault(axis, size))
        if not fits or not len(array):
            raise ValueError(f"{name} of shape {array.shape}, {array.dtype}; expected {shape}")


def _write_table(path: Path, rollout: "Rollout") -> None:
    names = rollout.names
    pose = ("x", "y", "z", "qw", "qx", "qy", "qz")
    tilts = [f"tilt_{i}" for i in range(rollout.tumblers.shape[1])]
    velocities, torques = [f"velocity_{name}" for name in names], [f"torque_{name}" for name in names]
    tool = [f"tool_{part}" for part in pose]
    head = ["t", "mode", *names, *velocities, *torques, "distance", "clearance", *tool, *tilts]
    numbers = np.column_stack(
        [
            rollout.states,
            rollout.velocities,
            rollout.torques,
            rollout.distances,
            rollout.clearances,
            rollout.tool_poses,
            rollout.tilts,
        ]
    )
    try:
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(head)
            for time, mode, row in zip(rollout.times.tolist(), rollout.modes, numbers.tolist(), strict=True):
                writer.writerow([time, mode, *row])
    except (OSError, ValueError) as error:  # a name with a zero byte
        raise SkillFileError(f"{path}: cannot be written: {getattr(error, 'strerror', None) or error}.") from None
