"""Single states in CSV files: a header, one row per state; and tables of states written back."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skillfold.errors import InputError, RecordingError
from skillfold.io.csv_files import read_csv
from skillfold.motion import Array
from skillfold.recordings import Recording


@dataclass(frozen=True)
class StateTable:
    """States of a file, in the order of its rows.

    Attributes:
        states: (n, D).
        beside: the columns `demo` and `t` where the file has them, to be written back as they were.
    """

    states: Array
    beside: Mapping[str, Sequence[Any]]


def read_states(path: Path, names: tuple[str, ...]) -> StateTable:
    """The coordinates `names` of every row; their columns may stand in any order, beside others.

    Where coordinates have no names of their own (x0, x1, …) as many columns as there are coordinates will do.

    Raises:
        RecordingError: names the file, row, column and value.
    """
    recordings, found = read_csv(path)
    columns = _columns(path, found, names)
    parts = [_states(recording, columns, found) for recording in recordings]
    states = np.concatenate(parts)
    if not len(states):
        raise RecordingError(f"{path}: no rows below the header; expected one state at least.")
    rows = np.concatenate([np.asarray(recording.rows) for recording in recordings])
    order = np.argsort(rows, kind="stable")
    beside = {name: [values[i] for i in order] for name, values in _beside(recordings).items()}
    return StateTable(states[order], beside)


def write_table(path: Path, columns: Mapping[str, Sequence[Any]]) -> None:
    """Write columns of equal length under a header; numbers in full precision.

    Raises:
        InputError: the file cannot be written.
    """
    try:
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows(zip(*columns.values(), strict=True))
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}.") from None


def state_columns(names: tuple[str, ...], states: Array) -> dict[str, list[float]]:
    """States (n, D) as columns of plain numbers."""
    return {name: column.tolist() for name, column in zip(names, states.T, strict=True)}


def _columns(path: Path, found: tuple[str, ...], names: tuple[str, ...]) -> list[int]:
    if set(names) <= set(found):
        return [found.index(name) for name in names]
    unnamed = names == tuple(f"x{i}" for i in range(len(names)))
    if unnamed and len(found) == len(names):
        return list(range(len(names)))
    raise RecordingError(f"{path}: columns {', '.join(found)}; expected {', '.join(names)}.")


def _states(recording: Recording, columns: list[int], found: tuple[str, ...]) -> Array:
    states = np.asarray(recording.states)[:, columns]
    if not np.isfinite(states).all():
        row, column = (int(i) for i in np.argwhere(~np.isfinite(states))[0])
        place = recording.at(row, found[columns[column]])
        raise RecordingError(f"{place}: value {states[row, column]}; expected a finite number.")
    return states


def _beside(recordings: list[Recording]) -> dict[str, list[Any]]:
    columns: dict[str, list[Any]] = {}
    if len(recordings) > 1:
        columns["demo"] = [recording.label for recording in recordings for _ in recording.states]
    if all(recording.times is not None for recording in recordings):
        columns["t"] = [float(t) for recording in recordings for t in recording.times]
    return columns
