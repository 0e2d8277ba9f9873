"""Sections V and VI: the three-link arm and the KUKA arm."""

from pathlib import Path

import numpy as np

from skillfold.experiments import (
    around_arm,
    around_shown,
    around_tray,
    reaching,
    reaching_shown,
    table_one,
    tray_demo,
    tumblers,
)
from skillfold.experiments.rows import Settings
from skillfold.viewing import around_pictures, reaching_pictures, table_pictures, tray_pictures, tumbler_pictures
from skillfold.viewing.reproduced.result import Experiment, Picture, Result

PAST, HARD = 40, 20  # cases past boxes
COLUMNS = (1, 2)  # of the picture: so many with boxes, so many with walls


def reach(settings: Settings, folder: Path) -> Result:
    """Paths of the three-link arm against optimal poses, inside the data and beyond; random states brought back."""
    rows = reaching.measure(settings, settings.few(10, 2), settings.few(50, 20))
    settings.progress("drawing", 0.9)
    shown = reaching_shown.run(settings)
    files = reaching_pictures.draw(shown, folder)
    return Result(
        [*rows, *reaching_shown.rows(shown)],
        [
            Picture(
                files[0], "figures 8 and 9", "What is learnt from a grid, paths inside it and beyond, errors, times."
            ),
            Picture(
                files[1], "figure 10", "Samples, tangents at the kernels' centres, and geodesics in joint space."
            ),
            Picture(files[2], "figure 12", "Random states and their projections, from two sides."),
        ],
    )


def patches(settings: Settings, folder: Path) -> Result:
    """Geodesics of the three-link arm around patches and through the gap of a wall."""
    rows = around_arm.measure(settings)
    settings.progress("drawing", 0.9)
    file = around_pictures.draw(around_shown.scenes(settings), folder / "patches.png")
    return Result(rows, [Picture(file, "figure 11", "Geodesics bent around patches and led through gaps.")])


def table(settings: Settings, folder: Path) -> Result:
    """Table I, the cost of motions left alone and pushed."""
    halves = table_one.table(settings)
    rows = [row for half in halves for row in table_one.rows(half)]
    settings.progress("drawing", 0.9)
    file = table_pictures.draw(halves, folder / "table_one.png")
    caption = "A pushed motion of the three-link arm, the tilt of the KUKA's tray, the excess cost, and Table I."
    return Result(rows, [Picture(file, "figure 13", caption)])


def boxes(settings: Settings, folder: Path) -> Result:
    """The LWR4 carries a tray past boxes that it was never shown."""
    task = around_tray.prepare(settings, PAST, HARD)
    runs = around_tray.run(task, settings)
    settings.progress("drawing", 0.9)
    shown = [answer for run, count in zip((runs[0], runs[2]), COLUMNS, strict=True) for answer in run.answers[:count]]
    file = tray_pictures.draw(runs[0].skill, shown, folder / "boxes.png")
    return Result(around_tray.rows(task, runs), [Picture(file, "", "The tray past boxes and over low walls.")])


def pushed(settings: Settings, folder: Path) -> Result:
    """Three tumblers on a carried tray, pushed, and past boxes that move."""
    rows = tumblers.measure(settings)
    settings.progress("drawing", 0.95)
    story = tray_demo.run(np.random.default_rng(settings.seed))
    file, _ = tumbler_pictures.draw(story, folder / "tumblers.png")
    return Result(rows, [Picture(file, "figure 16", "The tray carried past a box that rises, and pushed.")])


ARMS = {
    "reaching": Experiment("Sections V-A and V-B: reaching, against optimal poses", "000", reach),
    "patches": Experiment("Section V-B3: geodesics around patches and walls", "000", patches),
    "table-one": Experiment("Sections V-C and VI: motions left alone and pushed (Table I)", "000", table),
    "boxes": Experiment("Section VI among obstacles: a tray past boxes", "000", boxes),
    "tumblers": Experiment("Section VI in dynamics: tumblers on a tray, pushed", "000", pushed),
}
