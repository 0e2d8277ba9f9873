"""Results on disk: every experiment in a file of its own, so that a run that was stopped can go on.

A file says which run it belongs to. What is damaged, of another run, or without its pictures does not count.
"""

import json
import math
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, get_args

from skillfold.experiments.rows import Comparison, Row
from skillfold.io.json_text import write_whole
from skillfold.viewing.reproduced.result import Picture

FORMAT = 1
LARGEST = 10_000_000  # bytes of a file that is read
PNG = b"\x89PNG\r\n\x1a\n"
FAULTS = (OSError, ValueError, TypeError, KeyError, ArithmeticError, RecursionError)
"""What files that hold anything but results can bring about while they are read."""


@dataclass(frozen=True)
class Run:
    """What all experiments of one report share: figures of other seeds or machines never stand among them.

    Attributes:
        seed: of everything random.
        quick: few trials of everything.
        data: folder of recordings, in full; None without.
        machine: versions and machine, as `experiments.bench.machine` tells them.
    """

    seed: int
    quick: bool
    data: str | None
    machine: dict[str, Any]


@dataclass(frozen=True)
class Finished:
    """One experiment, done: its rows and pictures, and how many seconds it took."""

    rows: tuple[Row, ...]
    pictures: tuple[Picture, ...]
    seconds: float


def write(path: Path, run: Run, done: Finished) -> None:
    """Keep what an experiment came to.

    Raises:
        InputError: the file cannot be written.
    """
    told = {
        "format": FORMAT,
        "run": asdict(run),
        "seconds": done.seconds,
        "rows": [_row_told(row) for row in done.rows],
        "pictures": [asdict(picture) | {"file": picture.file.name} for picture in done.pictures],
    }
    write_whole(path, json.dumps(told, indent=1, allow_nan=False))


def read(path: Path) -> tuple[Run, Finished]:
    """What `write` kept.

    Raises:
        ValueError: in words, whatever is wrong with the file or its pictures.
    """
    try:
        told = _object(path)
        rows = tuple(map(_row, _listed(told["rows"])))
        pictures = tuple(_picture(part, path.parent) for part in _listed(told["pictures"]))
        return run_of(told["run"]), Finished(rows, pictures, _number(told["seconds"]))
    except FAULTS as error:
        raise ValueError(_words(error)) from None


def read_run(path: Path) -> Run | None:
    """The run that a report is of; None where there is no report, or none that can be read."""
    try:
        return run_of(_object(path))
    except FAULTS:
        return None


def run_of(told: Any) -> Run:
    """A run from plain values.

    Raises:
        ValueError, TypeError, KeyError: they are not those of a run.
    """
    run = Run(**{field.name: told[field.name] for field in fields(Run)})
    kinds = (type(run.seed) is int, type(run.quick) is bool, type(run.machine) is dict)
    if not all(kinds) or run.seed < 0 or not isinstance(run.data, str | None):
        raise ValueError("says of no run what it was")
    return run


def png(path: Path) -> bytes:
    """The bytes of a picture.

    Raises:
        ValueError: it is no PNG.
        OSError: it cannot be read.
    """
    data = path.read_bytes()
    if not data.startswith(PNG):
        raise ValueError(f"{path.name!r:.60} is no picture")
    return data


def _object(path: Path) -> dict[str, Any]:
    if path.stat().st_size > LARGEST:
        raise ValueError(f"larger than {LARGEST} bytes")
    told = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(told, dict) or told.get("format") != FORMAT:
        raise ValueError(f"not of format {FORMAT}")
    return told


def _listed(told: Any) -> list[Any]:
    if not isinstance(told, list):
        raise ValueError(f"expected a list, got {told!r:.40}")
    return told


def _row_told(row: Row) -> dict[str, Any]:
    """Plain values; a figure that JSON has not (a path of infinite cost) in words."""
    return asdict(row) | {"measured": _figure(row.measured), "target": _figure(row.target)}


def _figure(value: float | None) -> float | str | None:
    if value is None:
        return None
    return float(value) if math.isfinite(value) else repr(float(value))


def _row(told: dict[str, Any]) -> Row:
    values = {field.name: told[field.name] for field in fields(Row)}
    for name in ("measured", "target"):
        values[name] = None if values[name] is None else _number(values[name])
    texts = [text for name, text in values.items() if name not in ("measured", "target")]
    if not all(isinstance(text, str) for text in texts) or values["comparison"] not in get_args(Comparison):
        raise ValueError(f"not a row: {told!r:.60}")
    return Row(**values)


def _number(told: Any) -> float:
    if isinstance(told, bool):
        raise ValueError(f"expected a number, got {told}")
    return float(told)


def _picture(told: dict[str, Any], folder: Path) -> Picture:
    """A picture that lies beside the file: a name from a file leads nowhere else."""
    name, figures, caption = told["file"], told["figures"], told["caption"]
    if not all(isinstance(text, str) for text in (name, figures, caption)) or Path(name).name != name:
        raise ValueError(f"not a picture: {told!r:.60}")
    png(folder / name)
    return Picture(folder / name, figures, caption)


def _words(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"without {error.args[0]!r:.40}"
    text = " ".join(str(getattr(error, "strerror", None) or error).split())
    return text[:120].removesuffix(".") or type(error).__name__
