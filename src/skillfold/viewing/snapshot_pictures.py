"""Figure 16 of paper 000: pushed runs of the KUKA arm, drawn at several times from left to right."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skillfold.errors import RobotError
from skillfold.experiments import tray
from skillfold.experiments.tumbler_runs import TRAY
from skillfold.experiments.tumbler_shown import Example
from skillfold.motion import Array
from skillfold.viewing.style import INK, OFF, PLANS, bare, figure, save, style

SHOTS = 5  # of a run
VIEW: dict[str, Any] = {"toward": (0.1, 0.0, 0.5), "distance": 1.9, "azimuth": 180.0, "elevation": -16.0}
PIXELS = (500, 400)
LEGEND, LINE, HEADING = 0.5, 2.3, 0.36  # inches: below, of a run, of that for its title
EVERY = 20  # of the steps of a run whose tool is drawn
RED, YELLOW = (0.82, 0.29, 0.36, 1.0), (0.85, 0.52, 0.07, 1.0)
RADIUS = 0.007  # m, of a way that is drawn
FRAMES = ("base", "link2", "link3", "link4", "link5", "link6", "tool")


def draw(examples: Sequence[Example], path: Path) -> tuple[Path, str]:
    """Write the picture; returns its path, and a note where the simulation could not be drawn.

    Raises:
        InputError: the file cannot be written.
    """
    shots, note = shots_of(examples)
    with style():
        return save(snapshots(examples, shots), path), note


def shots_of(examples: Sequence[Example]) -> tuple[list[list[Any]], str]:
    """Pictures of each run; none, and why, where nothing can be drawn off the screen."""
    try:
        return [_shots(example) for example in examples], ""
    except RobotError as error:
        return [], f"{error} The pushed runs are drawn as lines."


def snapshots(examples: Sequence[Example], shots: Sequence[Sequence[Any]]) -> Figure:
    """A line of pictures for each run; where there are no `shots`, the arm as lines, seen from the front."""
    inches = LEGEND + LINE * len(examples)
    made, row, heading = figure(12.0, inches), LINE / inches, HEADING / inches
    for index, example in enumerate(examples):
        top = 1.0 - index * row
        made.text(0.008, top - 0.75 * heading, f"{'ab'[index]}) {example.title}", fontweight="bold", fontsize=10.5)
        for shot in range(SHOTS):
            ax = made.add_axes((0.005 + shot * 0.99 / SHOTS, top - row, 0.985 / SHOTS, row - heading))
            if shots:
                ax.imshow(shots[index][shot])
            else:
                _lines(ax, example, rows_of(example)[shot])
            ax.set_axis_off()
    made.legend(handles=_handles(), loc="lower center", ncols=2)
    return made


def rows_of(example: Example) -> list[int]:
    """The steps that are drawn: even along the tool's way."""
    steps = np.linalg.norm(np.diff(example.rollout.tool_poses[:, :3], axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    rows = np.searchsorted(along, np.linspace(0.0, along[-1], SHOTS))
    return np.minimum(rows, len(along) - 1).tolist()


def _shots(example: Example) -> list[Any]:
    from skillfold.robots.rendering import View, pictures
    from skillfold.robots.world import World

    run, rows = example.rollout, rows_of(example)
    marks = [_marks(example, row) for row in rows]
    world = World(tray.arm(), None, TRAY, visual=True)
    view = View(**VIEW, size=PIXELS)
    return list(pictures(world, run.times[rows], run.states[rows], run.tumblers[rows], view, marks))


def _marks(example: Example, row: int) -> list[Any]:
    """The tool's way up to a step, and the part of it that it was pushed along."""
    from skillfold.robots.rendering import Mark

    way, pushed = _ways(example, row)
    marks = [Mark(way, RED, RADIUS)] if len(way) > 1 else []
    return [*marks, Mark(pushed, YELLOW, 1.4 * RADIUS)] if len(pushed) > 1 else marks


def _ways(example: Example, row: int) -> tuple[Array, Array]:
    """Tool positions (n, 3) up to a step, and those of them while it was pushed."""
    run, push = example.rollout, example.trial.push
    rows = np.arange(0, row + 1, EVERY)
    way, times = run.tool_poses[rows, :3], run.times[rows]
    during = (times >= push.time) & (times <= push.end) if push else np.zeros(len(rows), bool)
    return way, way[during]


def _lines(ax: Any, example: Example, row: int) -> None:
    q = example.rollout.states[row]
    points = np.stack([tray.arm().forward(q, frame)[:3] for frame in FRAMES])
    ax.plot(*points[:, 1:].T, color=INK, linewidth=2.0, marker="o", markersize=3.0)
    for way, color, width in zip(_ways(example, row), (OFF, PLANS[2]), (1.4, 2.6), strict=True):
        ax.plot(*way[:, 1:].T, color=color, linewidth=width)
    bare(ax)
    ax.set(xlim=(-0.8, 0.8), ylim=(0.0, 1.2))


def _handles() -> list[Line2D]:
    return [
        Line2D([], [], color=OFF, linewidth=2.4, label="way of the tool"),
        Line2D([], [], color=PLANS[2], linewidth=3.0, label="while it was pushed"),
    ]
