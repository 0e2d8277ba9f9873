"""Figures 2, 3 and 9 of paper 002: envelopes whole and reduced, and what a first path costs."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from skillfold.experiments.keyframe_cost import Runs
from skillfold.experiments.keyframe_runs import Learnt
from skillfold.viewing import envelope_pictures as envelopes
from skillfold.viewing.style import FAINT, OFF, ON, figure, save, style

SAMPLES = 500  # poses drawn inside
SHOWN_ALPHAS = (100.0, 90.0)  # as in figure 3
NAMES = {"paper": "as printed", "mended": "mended"}


def draw_envelopes(skills: Sequence[Learnt], path: Path) -> Path:
    """Write figures 2 and 3.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(shapes(skills), path)


def draw_costs(found: Sequence[Runs], path: Path) -> Path:
    """Write figure 9.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(costs(found), path)


def shapes(skills: Sequence[Learnt]) -> Figure:
    """A row for each skill: in the plane and in space, each whole and reduced, with poses drawn inside."""
    made = figure(12.6, 3.55 * len(skills))
    high = 1.0 / len(skills)
    for row, learnt in enumerate(skills):
        foot = 1.0 - (row + 1) * high
        axis = np.abs(learnt.envelope.ends[1, :3] - learnt.envelope.ends[0, :3])
        seen = (int(axis[:2].argmax()), 2)
        for column, alpha in enumerate(SHOWN_ALPHAS):
            envelope = learnt.envelope if alpha == 100.0 else learnt.envelope.reduced(alpha)
            for x in (0.0, 0.5):
                left = x + 0.25 * column
                ax = made.add_axes((left + 0.005, foot + 0.02 * high, 0.24, 0.86 * high))
                if x:
                    envelopes.space(ax, envelope)
                else:
                    envelopes.flat(ax, envelope, seen, envelope.sample(SAMPLES, 1))
                title = f"{learnt.task.name}, α = {alpha:g} %" if left == 0.0 else f"α = {alpha:g} %"
                made.text(left + 0.012, foot + 0.92 * high, title, fontweight="bold", fontsize=10.5)
    return made


def costs(found: Sequence[Runs]) -> Figure:
    """A row for each task: nodes and run time of every run, by variant and α."""
    tasks = list(dict.fromkeys(runs.task for runs in found))
    made = figure(9.0, 2.9 * len(tasks))
    axes = made.subplots(len(tasks), 2, squeeze=False)
    made.subplots_adjust(left=0.09, right=0.985, top=0.94, bottom=0.08, hspace=0.42, wspace=0.22)
    for row, task in zip(axes, tasks, strict=True):
        mine = [runs for runs in found if runs.task == task]
        _runs(row[0], mine, [[a.plan.stats["nodes"] for a in runs.answers] for runs in mine])
        _runs(row[1], mine, [[1e3 * a.seconds for a in runs.answers] for runs in mine])
        row[0].set_title(f"{task}: nodes of the tree", fontweight="bold")
        row[1].set_title("run time, ms", fontweight="bold")
    return made


def _runs(ax: Any, found: Sequence[Runs], values: Sequence[Sequence[float]]) -> None:
    """A dot for each run, hollow where there was no path in time, and a bar at the median."""
    ax.set_yscale("log")
    for at, (runs, some) in enumerate(zip(found, values, strict=True)):
        color = ON if runs.variant == "mended" else OFF
        spread = at + np.linspace(-0.16, 0.16, len(some))
        for x, y, answer in zip(spread, some, runs.answers, strict=True):
            face = (
                color if answer.plan.success or (runs.variant == "paper" and len(answer.plan.path) > 1) else "white"
            )
            ax.plot(x, max(y, 1.0), marker="o", markersize=5.5, color=color, markerfacecolor=face, alpha=0.85)
        middle = max(float(np.median(some)), 1.0)
        ax.plot([at - 0.3, at + 0.3], [middle, middle], color=color, linewidth=2.2, solid_capstyle="butt")
    names = [f"{NAMES[runs.variant]}\nα = {runs.alpha:g}" for runs in found]
    ax.set_xticks(range(len(found)), names)
    ax.set_xlim(-0.6, len(found) - 0.4)
    ax.tick_params(axis="x", length=0)
    ax.grid(axis="y", color=FAINT, linewidth=0.6)
    ax.set_axisbelow(True)
