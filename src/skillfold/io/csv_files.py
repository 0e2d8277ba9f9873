"""CSV files of recordings: a header, one row per sample, optional columns `t` or `time`, and `demo`."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from skillfold.errors import RecordingError
from skillfold.recordings import Recording, check_words

_TIME = ("t", "time")
_DEMO = "demo"
# Taken for a coordinate, time would be learnt as one.
_LIKE_TIME = (
    *("timestamp", "timestamps", "time_stamp", "stamp", "sec", "secs", "second", "seconds"),
    *("time_s", "time_sec", "time_ms", "time_ns", "time [s]", "time (s)", "time(s)", "t_s", "t [s]", "t (s)", "t(s)"),
)


def read_csv(path: Path) -> tuple[list[Recording], tuple[str, ...]]:
    """Recordings of one file in order of their first row, and the names of the coordinates.

    Raises:
        RecordingError: names the file, row (as an editor counts, the header is row 1), column and value.
    """
    header, rows = _table(path)
    names = _header(header, path)
    time = [i for i, name in enumerate(names) if name.lower() in _TIME]
    demo = [i for i, name in enumerate(names) if name.lower() == _DEMO]
    if len(time) > 1:
        raise RecordingError(f"{path}: columns {names[time[0]]!r} and {names[time[1]]!r}; expected one of time.")
    coordinates = [i for i in range(len(names)) if i not in time + demo]
    if not coordinates:
        raise RecordingError(f"{path}: no coordinates beside {', '.join(names)}; expected one column at least.")
    _check_widths(rows, names, path)
    recordings = [
        _recording(path, group, names, coordinates, time, label) for label, group in _groups(rows, demo, path).items()
    ]
    return recordings, tuple(names[i] for i in coordinates)


def _table(path: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The header, and the rows that are not blank with their numbers."""
    text = _text(path)
    first = text.lstrip("\r\n").partition("\n")[0]
    delimiter = max(",;\t", key=first.count)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, skipinitialspace=True)
    try:
        rows = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except csv.Error as error:
        raise RecordingError(f"{path}, row {reader.line_num}: no CSV ({error}).") from None
    rows = [(number, row) for number, row in rows if any(row)]
    if not rows:
        raise RecordingError(f"{path}: the file is empty; expected a header and two rows at least.")
    header = rows[0][1]
    last = len(header) - 1
    width = last + any(any(row[last : last + 1]) for _, row in rows)
    return header[:width], [(number, _without_end(row, width)) for number, row in rows[1:]]


def _without_end(row: list[str], width: int) -> list[str]:
    """A row without the blank that a comma at the end of the line makes."""
    return row[:width] if len(row) == width + 1 and not row[-1] else row


def _text(path: Path) -> str:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return file.read()
    except UnicodeDecodeError as error:
        raise RecordingError(
            f"{path}: no text (byte {error.start} is not UTF-8); expected comma-separated values."
        ) from None
    except (OSError, ValueError) as error:
        raise RecordingError(f"{path}: cannot be read ({error}).") from None


def _header(header: list[str], path: Path) -> tuple[str, ...]:
    """Column names; a leading #, as some writers put it, is no part of them."""
    names = [header[0].lstrip("# "), *header[1:]]
    if all(_is_number(name) for name in names):
        raise RecordingError(
            f"{path}, row 1: numbers ({', '.join(names[:4])}) where the header belongs; expected column "
            "names, such as t, x, y."
        )
    like = next((name for name in names if name.lower() in _LIKE_TIME), None)
    if like is not None:
        raise RecordingError(f"{path}, header: column {like!r}; time in seconds is called t, any other is left out.")
    if not names[0]:
        raise RecordingError(
            f"{path}, header: column 1 has no name; expected one for each. An index of pandas is left out by "
            "to_csv(..., index=False)."
        )
    return check_words(names, "column", f"{path}, header")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _check_widths(rows: list[tuple[int, list[str]]], names: tuple[str, ...], path: Path) -> None:
    for number, row in rows:
        if len(row) != len(names):
            raise RecordingError(
                f"{path}, row {number}: {len(row)} values; expected {len(names)} as in the header: "
                f"{', '.join(names)}."
            )


def _groups(rows: list[tuple[int, list[str]]], demo: list[int], path: Path) -> dict[str, list[tuple[int, list[str]]]]:
    """Rows by the value of their `demo` column, or all under the file's name."""
    if not demo or not rows:
        return {path.stem: rows}
    groups: dict[str, list[tuple[int, list[str]]]] = {}
    for number, row in rows:
        label = row[demo[0]]
        if not label or not label.isprintable():
            raise RecordingError(
                f"{path}, row {number}, column '{_DEMO}': value {label!r}; expected the name of a recording."
            )
        groups.setdefault(label, []).append((number, row))
    return groups


def _recording(
    path: Path,
    rows: list[tuple[int, list[str]]],
    names: tuple[str, ...],
    coordinates: list[int],
    time: list[int],
    label: str,
) -> Recording:
    columns = coordinates + time
    table = [[_value(row[i], path, number, names[i]) for i in columns] for number, row in rows]
    values = np.array(table, dtype=np.float64).reshape(len(rows), len(columns))
    place = str(path) if label == path.stem else f"{path}, demo '{label}'"
    states, times = values[:, : len(coordinates)], values[:, -1] if time else None
    return Recording(states, times, label, place, [number for number, _ in rows])


def _value(text: str, path: Path, row: int, column: str) -> float:
    if _is_number(text) and "_" not in text:  # Python reads 1_000 as a number, nobody else does
        return float(text)
    wanted = "a number with a decimal point" if "," in text else "a number"
    wanted += "; columns are parted by commas, semicolons or tabs" if " " in text else ""
    raise RecordingError(f"{path}, row {row}, column '{column}': value {text!r}; expected {wanted}.")


def write_csv(path: Path, recordings: Sequence[tuple[str, Any, Any]], names: tuple[str, ...]) -> None:
    """Write (label, states, times) of each recording under a `demo` column; numbers in full precision.

    Raises:
        RecordingError: names that a reader would take for something else; times for some only.
    """
    reserved = [name for name in names if name.lower() in (*_TIME, _DEMO)]
    if reserved or names[0].startswith("#"):
        raise RecordingError(f"{path}: a coordinate is named {(reserved or names)[0]!r}; CSV needs another name.")
    timed = [times is not None for _, _, times in recordings]
    if any(timed) and not all(timed):
        raise RecordingError(f"{path}: some recordings have times, others not; CSV needs all or none (or .npz).")
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([_DEMO, *(["t"] if all(timed) else []), *names])
        for label, states, times in recordings:
            values = states if times is None else np.column_stack([times, states])
            writer.writerows([label, *row] for row in values.tolist())
