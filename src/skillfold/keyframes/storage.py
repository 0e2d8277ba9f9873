"""Keyframe skills as files: plain arrays and a JSON header, every shape checked on the way back."""

from os import PathLike
from typing import Any

import numpy as np

from skillfold import archive
from skillfold.errors import SkillFileError
from skillfold.keyframes.envelope import INTERPOLATIONS
from skillfold.keyframes.estimation import read_coverage
from skillfold.keyframes.gaussians import PoseGaussian
from skillfold.keyframes.recorded import FARTHEST
from skillfold.recordings import shortened
from skillfold.robots.poses import EXACT

KIND = "keyframes"
VERSION = 1


def pack(skill: Any) -> tuple[dict[str, Any], archive.Arrays]:
    """Header and arrays of a skill."""
    header = {
        "kind": KIND,
        "version": VERSION,
        "names": list(skill.names),
        "coverage": skill.coverage,
        "interpolation": skill.interpolation,
        "notes": list(skill.notes),
    }
    arrays = {
        "means": np.array([g.mean for g in skill.gaussians]),
        "covariances": np.array([g.covariance for g in skill.gaussians]),
        "gates": np.array([g.gates for g in skill.gaussians]),
        "counts": np.array([g.count for g in skill.gaussians], np.float64),
        "keyframes": np.concatenate(skill.keyframes),
        "lengths": np.array([len(demo) for demo in skill.keyframes], np.int64),
        "labels": np.concatenate(skill.labels),
        "selection": np.array(skill.selection, np.float64).reshape(-1, 2),
    }
    return header, arrays


def unpack(path: str | PathLike[str]) -> dict[str, Any]:
    """The attributes of a saved skill.

    Raises:
        SkillFileError: whatever is wrong with the file.
    """
    header, arrays = archive.read(path, KIND)
    version = header.get("version")
    if type(version) is not int or version != VERSION:
        raise SkillFileError(f"{path}: format version {shortened(version)}; this skillfold reads {VERSION}.")
    with archive.blaming(path, "not a complete skill"):
        gaussians = _gaussians(arrays)
        return {
            "gaussians": gaussians,
            **_demonstrations(arrays, len(gaussians), _texts(header["names"])),
            "coverage": read_coverage(header["coverage"]),
            "interpolation": _one_of(INTERPOLATIONS, header["interpolation"]),
            "selection": _selection(arrays),
            "notes": _texts(header["notes"]),
        }


def _gaussians(arrays: archive.Arrays) -> tuple[PoseGaussian, ...]:
    count = len(arrays["means"])
    if not count:
        raise ValueError("no Gaussians")
    means = _poses(arrays, "means", count)
    covariances = _numbers(arrays, "covariances", (count, 6, 6))
    gates = _numbers(arrays, "gates", (count, 2))
    counts = _numbers(arrays, "counts", (count,))
    if not (counts >= 1).all():
        raise ValueError("counts: expected one keyframe at least of each Gaussian")
    parts = zip(means, covariances, gates, counts.tolist(), strict=True)
    return tuple(PoseGaussian(mean, covariance, gate, number) for mean, covariance, gate, number in parts)


def _demonstrations(arrays: archive.Arrays, places: int, names: tuple[str, ...]) -> dict[str, Any]:
    lengths, labels = arrays["lengths"], arrays["labels"]
    total = len(arrays["keyframes"])
    for name, array, shape in (("lengths", lengths, (len(names),)), ("labels", labels, (total,))):
        if array.dtype != np.int64 or array.shape != shape:
            raise ValueError(f"{name}: expected int64 {shape}, found {array.dtype} {array.shape}")
    if not len(lengths) or lengths.min() < 1 or lengths.max() > total or lengths.sum() != total:
        raise ValueError("lengths do not part the keyframes")
    if labels.min() < -1 or labels.max() >= places:
        raise ValueError("labels do not name Gaussians")
    keyframes = _poses(arrays, "keyframes", total)
    keyframes.flags.writeable = False
    ends = np.cumsum(lengths)[:-1]
    return {
        "keyframes": tuple(np.split(keyframes, ends)),
        "labels": tuple(np.split(np.array(labels), ends)),
        "names": names,
    }


def _selection(arrays: archive.Arrays) -> tuple[tuple[int, float], ...]:
    rows = _numbers(arrays, "selection", (len(arrays["selection"]), 2))
    if not ((rows[:, 0] >= 1) & (rows[:, 0] < 1e6) & (rows[:, 0] % 1 == 0)).all():
        raise ValueError("selection: expected numbers of Gaussians")
    return tuple((int(number), float(evidence)) for number, evidence in rows)


def _poses(arrays: archive.Arrays, name: str, count: int) -> Any:
    poses = _numbers(arrays, name, (count, 7))
    if not (np.abs(np.linalg.norm(poses[:, 3:], axis=1) - 1) <= EXACT).all():
        raise ValueError(f"{name}: expected unit quaternions")
    if not (np.abs(poses[:, :3]) < FARTHEST).all():
        raise ValueError(f"{name}: a position beyond {FARTHEST:g} m")
    return poses


def _numbers(arrays: archive.Arrays, name: str, shape: tuple[int, ...]) -> Any:
    array = arrays[name]
    if array.dtype != np.float64 or array.shape != shape or not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite float64 {shape}, found {array.dtype} {array.shape}")
    return np.array(array, order="C")


def _texts(values: Any) -> tuple[str, ...]:
    if type(values) is not list or not all(type(value) is str for value in values):
        raise TypeError(f"{shortened(values)} where a list of texts belongs")
    return tuple(values)


def _one_of(possible: tuple[str, ...], value: Any) -> str:
    if type(value) is not str or value not in possible:
        raise ValueError(f"{shortened(value)} where one of {', '.join(possible)} belongs")
    return value
