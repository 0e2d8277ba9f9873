"""The paper's experiments repeated: each gives rows beside the paper's figures, and a picture of the same data."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from skillfold.experiments import (
    around_arm,
    around_shown,
    around_tray,
    nao_balance,
    nao_stepping,
    table_one,
    tray_demo,
    tumblers,
)
from skillfold.experiments.rows import Row, Settings
from skillfold.viewing import around_pictures, nao_pictures, table_pictures, tray_pictures, tumbler_pictures

Reproduced = Callable[[Settings, Path], tuple[list[Row], Path]]
"""Given settings and a folder for the picture."""

PAST, HARD = 40, 20  # cases past boxes
COLUMNS = (1, 2)  # of the picture: so many with boxes, so many with walls


def patches(settings: Settings, folder: Path) -> tuple[list[Row], Path]:
    """Section V-B3: geodesics of the three-link arm around patches and through the gap of a wall."""
    rows = around_arm.measure(settings)
    settings.progress("drawing", 0.9)
    return rows, around_pictures.draw(around_shown.scenes(settings), folder / "patches.png")


def table(settings: Settings, folder: Path) -> tuple[list[Row], Path]:
    """Sections V-C and VI: Table I, the cost of motions left alone and pushed."""
    halves = table_one.table(settings)
    rows = [row for half in halves for row in table_one.rows(half)]
    settings.progress("drawing", 0.9)
    return rows, table_pictures.draw(halves, folder / "table_one.png")


def boxes(settings: Settings, folder: Path) -> tuple[list[Row], Path]:
    """Section VI among obstacles: the LWR4 carries a tray past boxes that it was never shown."""
    task = around_tray.prepare(settings, PAST, HARD)
    runs = around_tray.run(task, settings)
    settings.progress("drawing", 0.9)
    shown = [answer for run, count in zip((runs[0], runs[2]), COLUMNS, strict=True) for answer in run.answers[:count]]
    return around_tray.rows(task, runs), tray_pictures.draw(runs[0].skill, shown, folder / "boxes.png")


def pushed(settings: Settings, folder: Path) -> tuple[list[Row], Path]:
    """Section VI in dynamics: three tumblers on a carried tray, pushed, and past boxes that move."""
    rows = tumblers.measure(settings)
    settings.progress("drawing", 0.95)
    picture, _ = tumbler_pictures.draw(tray_demo.run(np.random.default_rng(settings.seed)), folder / "tumblers.png")
    return rows, picture


def balance(settings: Settings, folder: Path) -> tuple[list[Row], Path]:
    """Section VII-C: Table II, a Nao that balances on one leg."""
    tables = nao_balance.run(settings, nao_balance.Counts())
    rows = nao_balance.rows(tables, settings)
    settings.progress("drawing", 0.95)
    return rows, nao_pictures.draw_balance(tables[0], folder / "nao_balance.png")


def stepping(settings: Settings, folder: Path) -> tuple[list[Row], Path]:
    """Sections VII-A and VII-B: steps of a Nao, past obstacles, and ten in a row."""
    found = nao_stepping.run(settings, nao_stepping.Counts())
    settings.progress("drawing", 0.95)
    return nao_stepping.rows(found), nao_pictures.draw_stepping(found, folder / "nao_stepping.png")


EXPERIMENTS: dict[str, Reproduced] = {
    "patches": patches,
    "table-one": table,
    "boxes": boxes,
    "tumblers": pushed,
    "nao-balance": balance,
    "nao-stepping": stepping,
}
