"""`skillfold demo` and `skillfold bench`: what the library can do, and how well, measured here and now."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from skillfold.cli import console, files
from skillfold.cli.options import Flag, shown
from skillfold.errors import InputError

if TYPE_CHECKING:
    from skillfold.experiments.bench import Report
    from skillfold.experiments.rows import Row


@dataclass(frozen=True)
class Demo:
    """Learn from real handwriting and from a three-link arm; plan, project, and draw pictures of it."""

    out: Annotated[Path, shown("FOLDER")] = Path("demo")
    """Folder for the pictures; made where it is missing."""
    seed: int = 0
    """Of everything random."""
    json: Flag = False
    """Report as JSON."""

    def run(self) -> int:
        """Learn, draw, report."""
        raise NotImplementedError


@dataclass(frozen=True)
class Bench:
    """Measure every figure the library claims, beside its target and the paper's figure."""

    groups: Annotated[tuple[str, ...], shown("GROUP", "(all when left out)")] = ()
    """Some of arm, sets, upright, noise, recordings, large, speed."""
    data: Annotated[Path | None, shown("FOLDER", "(point sets drawn, robot tasks left out)")] = None
    """Folder with ecomann/ and robotasks/."""
    json: Annotated[tuple[Path, ...] | None, shown("[FILE]", "")] = None
    """Report as JSON: on stdout, or in FILE beside the table."""
    seed: Annotated[int | None, shown("INT", "(a fresh one, which the report tells)")] = None
    """Of everything random."""

    def run(self) -> int:
        """Measure and report."""
        file = self._file()
        from skillfold.experiments import bench

        with console.progress() as progress, console.quiet():
            report = bench.run(self.groups or None, self.data, self.seed, progress)
        if file:
            files.write_text(file, console.to_json(report.as_dict()))
        console.report(report.as_dict(), self.json == (), *_tables(report))
        return 0

    def _file(self) -> Path | None:
        if self.json and len(self.json) > 1:
            raise InputError(f"--json: {len(self.json)} files given; expected one, or none for stdout.")
        return files.writable(self.json[0]) if self.json else None


def _tables(report: "Report") -> list[Any]:
    groups = list(dict.fromkeys(row.group for row in report.rows))
    tables = [_table(name, [row for row in report.rows if row.group == name], report) for name in groups]
    judged = [row.met for row in report.rows if row.met is not None]
    machine = f"{report.machine['system']}, {report.machine['cores']} cores, Python {report.machine['python']}"
    verdict = f"{sum(judged)} of {len(judged)} targets met; seed {report.seed}; {machine}."
    return [*tables, verdict]


def _table(group: str, rows: "list[Row]", report: "Report") -> Any:
    columns = {"": "left", "measured": "right", "target": "right", "paper": "right", " ": "left", "note": "left"}
    return console.table(f"{group}, {report.seconds[group]:.0f} s", columns, [_cells(row) for row in rows])


def _cells(row: "Row") -> tuple[Any, ...]:
    from rich.text import Text

    sign = {"<=": "≤", ">=": "≥", "==": "="}.get(row.comparison, row.comparison)
    measured = "–" if row.measured is None else f"{row.measured:.3g} {row.unit}".rstrip()
    target = "" if row.target is None else f"{sign} {row.target:g}"
    verdict = {True: Text("✓", "green"), False: Text("✗", "bold red"), None: Text("")}[row.met]
    return row.name, measured, target, row.paper, verdict, Text(row.note, "dim")
