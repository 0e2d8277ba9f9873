"""`skillfold demo` and `skillfold bench`: what the library can do, and how well, measured here and now."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from skillfold.cli import console, files
from skillfold.cli.options import Flag, seed, shown
from skillfold.cli.screen import draw_off_screen
from skillfold.errors import InputError

if TYPE_CHECKING:
    from skillfold.experiments.bench import Report
    from skillfold.experiments.rows import Row


@dataclass(frozen=True)
class Demo:
    """Learn from real handwriting and two arms; plan, project, carry a tray, and draw pictures of it."""

    chapter: Annotated[Literal["keyframes"] | None, tyro.conf.Positional, shown("[keyframes]", "")] = None
    """keyframes alone: an arm past a box and past a can, inside envelopes learnt from seven demonstrations."""
    out: Annotated[Path, shown("FOLDER")] = Path("demo")
    """Folder for the pictures; made where it is missing."""
    seed: int = 0
    """Of everything random."""
    json: Flag = False
    """Report as JSON."""

    def run(self) -> int:
        """Learn, draw, report."""
        chosen = seed(self.seed)
        folder = files.folder(self.out)
        draw_off_screen()
        if self.chapter == "keyframes":
            from skillfold.cli.keyframe_demo import show

            return show(chosen, folder, self.json)
        from skillfold.experiments import demo
        from skillfold.viewing.demo_pictures import draw
        from skillfold.viewing.tumbler_pictures import draw as draw_tray

        start = perf_counter()
        with console.progress() as progress, console.quiet():
            story = demo.run(chosen, progress)
            progress("drawing", 1.0)
            pictures, notes = [str(path) for path in draw(story, folder)], list(story.notes)
            if story.carrying:
                picture, missing = draw_tray(story.carrying, folder / "tray.png")
                pictures.append(str(picture))
                notes += [missing] if missing else []
        facts: dict[str, Any] = {
            "chapters": [c.facts() for c in story.chapters],
            "notes": notes,
            "pictures": pictures,
        }
        facts["tray"] = story.carrying.facts() if story.carrying else None
        facts["seconds"] = perf_counter() - start
        for note in notes:
            console.say(f"note: {note}")
        console.report(facts, self.json, *_demo_tables(facts))
        return 0


@dataclass(frozen=True)
class Bench:
    """Measure how well and how fast the library works, beside its targets and the papers' figures."""

    groups: Annotated[tuple[str, ...], shown("GROUP", "(all when left out)")] = ()
    """Some of arm, sets, upright, noise, around, control, tumblers, recordings, large, keyframes, speed."""
    data: Annotated[Path | None, shown("FOLDER", "(point sets drawn, robot tasks left out)")] = None
    """Folder with ecomann/ and robotasks/."""
    json: Annotated[tuple[Path, ...] | None, shown("[FILE]", "")] = None
    """Report as JSON: on stdout, or in FILE beside the table."""
    seed: Annotated[int | None, shown("INT", "(a fresh one, which the report tells)")] = None
    """Of everything random."""

    def run(self) -> int:
        """Measure and report."""
        file = self._file()
        data = self.data and files.existing_folder("--data", self.data)
        chosen = None if self.seed is None else seed(self.seed)
        from skillfold.experiments import bench

        with console.progress() as progress, console.quiet():
            report = bench.run(self.groups or None, data, chosen, progress)
        if file:
            files.write_text(file, console.to_json(report.as_dict()))
        console.report(report.as_dict(), self.json == (), *_tables(report))
        return 0

    def _file(self) -> Path | None:
        if self.json and len(self.json) > 1:
            raise InputError(f"--json: {len(self.json)} files given; expected one, or none for stdout.")
        return files.writable(self.json[0]) if self.json else None


LEGEND = (
    "length: mean of the plans; residual: largest distance of a plan from the manifold; to demos: mean distance of "
    "the plans from the demonstrated states, apart: of demonstrations from each other; off → on: median distance of "
    "disturbed states from the manifold, before and after projection; each in the unit given."
)


def _demo_tables(facts: dict[str, Any]) -> list[Any]:
    columns = ("skill", "dim", "fit", "plans", "each", "unit", "length", "residual", "to demos", "apart", "off → on")
    sides = dict.fromkeys(columns, "right") | {"skill": "left", "unit": "left"}
    table = console.table("Learnt, planned, pushed off, brought back", sides, map(_cells_of, facts["chapters"]))
    optimal = [
        f"{c['name']}: {c['rmse']:.1e} rad from optimal (RMSE of all plans); the paper reports {c['paper_rmse']:.1e}."
        for c in facts["chapters"]
        if c["rmse"] is not None
    ]
    return [
        table,
        LEGEND,
        *optimal,
        *_tray_lines(facts["tray"]),
        f"{facts['seconds']:.0f} s; pictures: {', '.join(facts['pictures'])}",
    ]


def _tray_lines(tray: dict[str, Any] | None) -> list[str]:
    if tray is None:
        return []
    stand, tilt = tray["standing"], tray["peak_tilt"]
    return [
        f"tray with tumblers, {tray['poses']} poses, learnt in {tray['fit_seconds']:.1f} s: planned past a box in "
        f"{1e3 * tray['plan_seconds']:.0f} ms, planned anew {tray['replans']} times as the box rose, "
        f"{tray['contacts']} contacts; pushed, {stand['skill']} of {tray['tumblers']} tumblers stand (naive arm: "
        f"{stand['naive']}), the tray tilts by {tilt['skill']:.3f} rad at most (naive arm: {tilt['naive']:.3f}); "
        f"{1e6 * tray['step_seconds']:.0f} µs a control step."
    ]


def _cells_of(chapter: dict[str, Any]) -> list[str]:
    lengths = ("mean_length", "largest_residual", "to_demonstrations", "between_demonstrations")
    return [
        chapter["name"],
        f"{chapter['dim']} of {chapter['n_dims']}",
        f"{chapter['fit_seconds']:.1f} s",
        f"{chapter['successful']} of {chapter['plans']}",
        f"{1e3 * chapter['plan_seconds']:.1f} ms",
        chapter["unit"],
        *("–" if chapter[name] is None else f"{chapter[name]:.3g}" for name in lengths),
        f"{chapter['disturbed_off']:.2g} → {chapter['projected_off']:.0e}",
    ]


def _tables(report: "Report") -> list[Any]:
    groups = list(dict.fromkeys(row.group for row in report.rows))
    tables = [
        rows_table(f"{name}, {report.seconds[name]:.0f} s", [row for row in report.rows if row.group == name])
        for name in groups
    ]
    judged = [row.met for row in report.rows if row.met is not None]
    machine = f"{report.machine['system']}, {report.machine['cores']} cores, Python {report.machine['python']}"
    verdict = f"{sum(judged)} of {len(judged)} targets met; seed {report.seed}; {machine}."
    return [*tables, verdict]


def rows_table(title: str, rows: "Sequence[Row]") -> Any:
    """Measured figures beside their targets and the paper's."""
    columns = {"": "left", "measured": "right", "target": "right", "paper": "right", " ": "left", "note": "left"}
    return console.table(title, columns, [_cells(row) for row in rows])


def _cells(row: "Row") -> tuple[Any, ...]:
    from rich.text import Text

    sign = {"<=": "≤", ">=": "≥", "==": "="}.get(row.comparison, row.comparison)
    measured = "–" if row.measured is None else f"{row.measured:.3g} {row.unit}".rstrip()
    target = "" if row.target is None else f"{sign} {row.target:g}"
    verdict = {True: Text("✓", "green"), False: Text("✗", "bold red"), None: Text("")}[row.met]
    return row.name, measured, target, row.paper, verdict, Text(row.note, "dim")
