"""What commands say: reports on stdout, as tables or JSON; progress, notes and errors on stderr."""

import io
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from skillfold.io.json_text import to_json

PLAIN_WIDTH = 120  # of tables that go to a file or a pipe

Progress = Callable[[str, float], None]
"""Called with a stage and the share of it that is done."""
Begin = Callable[[str, float], Progress]
"""Called with the part of a whole that begins and the share of the whole that is done; answers its own progress."""


def forgive() -> None:
    """Characters that a terminal cannot show become question marks, not errors."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def say(text: str) -> None:
    """One line to stderr."""
    sys.stderr.write(f"skillfold: {' '.join(text.split())}\n")


def report(facts: Mapping[str, Any], as_json: bool, *tables: Any) -> None:
    """Facts as JSON, or the tables (facts in two columns where none are given), to stdout."""
    if as_json:
        sys.stdout.write(to_json(facts))
    else:
        out = _console(stderr=False)
        for part in tables or (facts_table(facts),):
            out.print(part, soft_wrap=isinstance(part, str) and not out.is_terminal)
    sys.stdout.flush()  # a reader that has gone is noticed here, and not at exit


def facts_table(facts: Mapping[str, Any]) -> str:
    """Names and values, a line each; nothing for None and for empty ones."""
    told = {name.replace("_", " "): value for name, value in facts.items() if value not in (None, "", [])}
    width = max(map(len, told), default=0)
    return "\n".join(f"{name:<{width}}  {_shown(value)}" for name, value in told.items())


def table(title: str, columns: Mapping[str, str], rows: Any) -> Any:
    """A table with thin rules; `columns` maps headings to "left" or "right"."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    look = {"box": box.SIMPLE_HEAD, "pad_edge": False, "collapse_padding": True}
    made = Table(title=title, title_justify="left", title_style="bold", **look)
    for heading, side in columns.items():
        made.add_column(heading, justify=side, header_style="dim")  # type: ignore[arg-type]
    for row in rows:
        made.add_row(*(cell if isinstance(cell, Text) else Text(str(cell)) for cell in row))
    return made


@contextmanager
def progress() -> Iterator[Progress]:
    """A bar on a terminal, one line for each stage elsewhere; on stderr."""
    err = _console(stderr=True)
    if not err.is_terminal:
        yield _stage_lines()
        return
    with _bar(err) as bar:
        task = bar.add_task("", total=1.0)
        yield lambda stage, share: bar.update(task, description=stage, completed=share)


@contextmanager
def progress_in_parts() -> Iterator[Begin]:
    """Two bars on a terminal, of the whole and of the part under way; lines that name the part elsewhere."""
    err = _console(stderr=True)
    if not err.is_terminal:
        yield lambda part, done: _stage_lines(f"{part}: ")
        return
    with _bar(err) as bar:
        whole, inside = bar.add_task("", total=1.0), bar.add_task("", total=1.0)

        def begin(part: str, done: float) -> Progress:
            bar.update(whole, description=part, completed=done)
            bar.reset(inside, description="")
            return lambda stage, share: bar.update(inside, description=f"  {stage}", completed=share)

        yield begin


@contextmanager
def quiet() -> Iterator[None]:
    """Warnings of the library are not shown: commands say in their own words what a user should know."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _bar(err: Any) -> Any:
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}", markup=False), BarColumn(28), TimeElapsedColumn())
    return Bar(*columns, console=err, transient=True)


def _stage_lines(before: str = "") -> Progress:
    told: list[str] = []

    def tell(stage: str, share: float) -> None:
        if told[-1:] != [stage]:
            told.append(stage)
            say(f"{before}{stage} …")

    return tell


def _console(stderr: bool) -> Any:
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    width = None if stream.isatty() else PLAIN_WIDTH
    return Console(file=stream, markup=False, highlight=False, emoji=False, width=width)


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)
