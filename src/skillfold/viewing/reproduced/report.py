"""The report of a run: one JSON and one HTML page, written anew after every experiment."""

import shlex
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from skillfold.experiments.rows import Row
from skillfold.io.json_text import to_json, write_whole
from skillfold.viewing.reproduced import stored
from skillfold.viewing.reproduced.page import page
from skillfold.viewing.reproduced.result import Experiment
from skillfold.viewing.reproduced.running import REPORT, UnderWay
from skillfold.viewing.reproduced.stored import Run

PAGE = "report.html"
PAPERS = {
    "000": "Havoutis and Ramamoorthy, Motion planning and reactive control on learnt skill manifolds",
    "002": "Tao, Akgun, Thomaz and Billard, Learning pose constraints for trajectory optimization from demonstration",
}
VERDICTS = ("met", "missed", "not measured", "without target")


def write(under_way: UnderWay, experiments: Mapping[str, Experiment], folder: Path) -> dict[str, Any]:
    """Write both files; the facts that stand in them.

    Raises:
        InputError: a file cannot be written.
    """
    told = facts(under_way, experiments, folder)
    write_whole(folder / REPORT, to_json(told))
    write_whole(folder / PAGE, page(told, folder))
    return told


def facts(under_way: UnderWay, experiments: Mapping[str, Experiment], folder: Path) -> dict[str, Any]:
    """All that the report says, in plain values: experiments in the papers' order, and what is absent."""
    there = [name for name in experiments if name in under_way.done or name in under_way.failed]
    parts = [_part(name, experiments[name], under_way) for name in there]
    absent = [name for name in experiments if name not in there]
    return {
        "format": stored.FORMAT,
        **asdict(under_way.run),
        "again": again(under_way.run, there if absent else [], folder),
        "targets": {verdict: sum(part["targets"][verdict] for part in parts) for verdict in VERDICTS},
        "seconds": sum(part["seconds"] or 0.0 for part in parts),
        "experiments": parts,
        "absent": {name: experiments[name].title for name in absent},
    }


def verdict(row: Row) -> str:
    """One of `VERDICTS`."""
    if row.target is None:
        return "without target"
    return {True: "met", False: "missed", None: "not measured"}[row.met]


def again(run: Run, names: Iterable[str], folder: Path) -> str:
    """The command that measures the named experiments (all where none is named) anew, with the same seed."""
    words = ["skillfold", "reproduce", *names]
    words += ["--quick"] if run.quick else []
    words += [] if run.data is None else ["--data", run.data]
    return shlex.join([*words, "--seed", str(run.seed), "--fresh", "--out", str(folder)])


def _part(name: str, experiment: Experiment, under_way: UnderWay) -> dict[str, Any]:
    done = under_way.done.get(name)
    rows, pictures = (done.rows, done.pictures) if done else ((), ())
    return {
        "name": name,
        "title": experiment.title,
        "paper": PAPERS.get(experiment.paper, experiment.paper),
        "differs": list(experiment.differs),
        "failed": under_way.failed.get(name),
        "seconds": done.seconds if done else None,
        "targets": _counted(rows),
        "rows": [row.as_dict() | {"verdict": verdict(row)} for row in rows],
        "pictures": [asdict(picture) | {"file": picture.file.name} for picture in pictures],
    }


def _counted(rows: Iterable[Row]) -> dict[str, int]:
    counts = Counter(map(verdict, rows))
    return {verdict: counts[verdict] for verdict in VERDICTS}
