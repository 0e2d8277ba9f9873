"""The paper's experiments repeated: each gives rows beside the paper's figures, and a picture of the same data."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from skillfold.experiments import (
    around_arm,
    around_shown,
    around_tray,
    keyframe_cost,
    keyframe_demo,
    keyframe_motions,
    keyframe_runs,
    keyframes,
    nao_balance,
    nao_stepping,
    pick_place,
    pick_place_poses,
    table_one,
    tray_demo,
    tumblers,
)
from skillfold.experiments.rows import Row, Settings
from skillfold.viewing import (
    around_pictures,
    keyframe_costs,
    keyframe_pictures,
    nao_pictures,
    pick_place_pictures,
    table_pictures,
    tray_pictures,
    tumbler_pictures,
)

Reproduced = Callable[[Settings, Path], tuple[list[Row], Path]]
"""Given settings and a folder for the picture."""

PAST, HARD = 40, 20  # cases past boxes
DRAWS, STARTS = 12, 4  # of demonstrations, and on each, of keyframe tasks
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


def shapes(settings: Settings, folder: Path) -> tuple[list[Row], Path]:
    """Paper 002, figures 2 and 3: envelopes in the plane and in space, whole and reduced; what the gates hold."""
    rows = keyframes.learning(settings)
    settings.progress("drawing", 0.95)
    return rows, keyframe_costs.draw_envelopes(keyframes.learn(settings, 1), folder / "envelopes.png")


def paths(settings: Settings, folder: Path) -> tuple[list[Row], Path]:
    """Paper 002, figures 5 to 8: both tasks, planned in the whole and in the reduced envelope."""
    skills = keyframes.learn(settings, DRAWS)
    found = keyframe_runs.answers(skills, STARTS, settings)
    rows = [*keyframe_runs.first_rows(found), *keyframe_runs.inside_rows(found)]
    rows += keyframe_motions.turned_rows(skills, STARTS, settings)
    settings.progress("drawing", 0.9)
    picture, _ = keyframe_pictures.draw(keyframe_demo.run(settings.seed), folder / "keyframes.png")
    return rows, picture


def first_paths(settings: Settings, folder: Path) -> tuple[list[Row], Path]:
    """Paper 002, figure 9: nodes and run time of the algorithm as printed and as it is here."""
    found = keyframe_cost.run(keyframes.learn(settings, 1), settings)
    return keyframe_cost.rows(found), keyframe_costs.draw_costs(found, folder / "keyframe_cost.png")


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


def carried(settings: Settings, folder: Path) -> tuple[list[Row], Path]:
    """Section VIII: Tables III and IV, pick-and-place against learnt dynamics and primitives, orientations too."""
    compared = pick_place.compare(settings)
    rows = pick_place.rows(compared) + pick_place.training_rows(settings, pick_place.Counts().trainings)
    rows += pick_place_poses.measure(settings)
    settings.progress("drawing", 0.95)
    return rows, pick_place_pictures.draw(compared[0], folder / "pick_place.png")


EXPERIMENTS: dict[str, Reproduced] = {
    "patches": patches,
    "table-one": table,
    "boxes": boxes,
    "tumblers": pushed,
    "envelopes": shapes,
    "keyframes": paths,
    "keyframe-cost": first_paths,
    "nao-balance": balance,
    "nao-stepping": stepping,
    "pick-place": carried,
}
