"""Recordings from files and folders, whatever their format, and back."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

from skillfold.consistency import column_names, scalar_first
from skillfold.errors import RecordingError
from skillfold.io.csv_files import read_csv, write_csv
from skillfold.io.npz_files import read_npz, write_npz
from skillfold.recordings import Recording, checked_states
from skillfold.spaces import StateSpace

Parts = tuple[list[Recording], tuple[str, ...] | None, StateSpace | None]


def read(path: Any, given: StateSpace | None = None, moving: bool = True) -> Parts:
    """Recordings of a file, a folder or a list of these, the coordinate names, and the space given or stored.

    Recordings must have two samples at least, and move, unless `moving` says that they need not.

    Raises:
        RecordingError: names the file and what is wrong with it.
    """
    files = _files(path)
    parts = [_read_file(file, moving) for file in files]
    recordings, names, space = parts[0]
    for file, (more, other, stored) in zip(files[1:], parts[1:], strict=True):
        if given is None and stored != space:
            raise RecordingError(f"{file}: {stored!r}, but {files[0]} has {space!r}; expected one space.")
        recordings = recordings + _same_columns(more, other, names, file, files[0])
    return _distinct(recordings), names, space if given is None else given


def write(
    path: str | PathLike[str],
    recordings: Sequence[tuple[str, Any, Any]],
    names: tuple[str, ...],
    space: StateSpace,
) -> None:
    """Write (label, states, times) of each recording to a `.csv` or `.npz` file."""
    file = _path(path)
    try:
        if file.suffix.lower() == ".npz":
            return write_npz(file, recordings, names, space)
        if file.suffix.lower() == ".csv":
            return write_csv(file, recordings, names)
    except (OSError, ValueError) as error:
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(f"{file}: cannot be written ({error}).") from None
    raise RecordingError(f"{file}: unknown suffix {file.suffix!r}; possible: .csv, .npz.")


def _path(path: Any) -> Path:
    if not isinstance(path, str | PathLike):
        raise RecordingError(f"Got {path!r} as a path; expected text or a Path.")
    try:
        return Path(path).expanduser()
    except (RuntimeError, TypeError) as error:
        raise RecordingError(f"{path!r}: no usable path ({error}).") from None


def _files(path: Any) -> list[Path]:
    if not isinstance(path, list | tuple):
        return _in_folder(_path(path))
    files = [file for one in path for file in _in_folder(_path(one))]
    if not files:
        raise RecordingError("No files given; expected one at least.")
    return files


def _in_folder(path: Path) -> list[Path]:
    try:
        if not path.is_dir():
            if not path.exists():
                raise RecordingError(f"{path}: no such file or folder.")
            return [path]
        files = sorted(f for f in path.iterdir() if f.suffix.lower() in (".csv", ".npz") and f.is_file())
    except (OSError, ValueError) as error:
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(f"{str(path)!r}: cannot be opened ({error}).") from None
    if not files:
        raise RecordingError(f"{path}: no recordings in this folder; expected .csv or .npz files.")
    return files


def _read_file(file: Path, moving: bool) -> Parts:
    """Recordings of one file, their columns reordered to scalar-first quaternions."""
    suffix = file.suffix.lower()
    if suffix == ".npz":
        recordings, names, space = read_npz(file)
    elif suffix == ".csv":
        (recordings, names), space = read_csv(file), None
    else:
        raise RecordingError(f"{file}: unknown suffix {file.suffix!r}; possible: .csv, .npz.")
    recordings = [replace(recording, moving=moving) for recording in recordings]
    if names is None or space is not None:
        return recordings, names, space
    order = scalar_first(column_names(names))
    if order == sorted(order):
        return recordings, names, None
    return [_reordered(r, names, order) for r in recordings], tuple(names[i] for i in order), None


def _reordered(recording: Recording, names: tuple[str, ...], order: list[int]) -> Recording:
    return replace(recording, states=checked_states(recording, names)[:, order])


def _same_columns(recordings: list[Recording], names: Any, expected: Any, file: Path, first: Path) -> list[Recording]:
    if names == expected:
        return recordings
    if names is None or expected is None or set(names) != set(expected):
        raise RecordingError(f"{file}: columns {_told(names)}; expected {_told(expected)} as in {first}.")
    return [_reordered(r, names, [names.index(name) for name in expected]) for r in recordings]


def _told(names: Any) -> str:
    return "without names" if names is None else ", ".join(names)


def _distinct(recordings: list[Recording]) -> list[Recording]:
    """Labels made different where several files use the same ones."""
    counts = Counter(r.label for r in recordings)
    if max(counts.values()) == 1:
        return recordings
    return [replace(r, label=f"{i}:{r.label}") for i, r in enumerate(recordings)]
