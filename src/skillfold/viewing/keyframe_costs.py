"""Figures 2, 3 and 9 of paper 002: envelopes whole and reduced, and what a first path costs."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skillfold.experiments.keyframe_cost import NAMES, Runs
from skillfold.experiments.keyframe_runs import Learnt
from skillfold.viewing import envelope_pictures as envelopes
from skillfold.viewing.style import FAINT, INK, OFF, ON, SOFT, figure, save, style

SAMPLES = 500  # poses drawn inside
SHOWN_ALPHAS = (100.0, 90.0)  # as in figure 3


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
        seen = _plane(learnt)
        for column, alpha in enumerate(SHOWN_ALPHAS):
            envelope = learnt.envelope if alpha == 100.0 else learnt.envelope.reduced(alpha)
            for x in (0.0, 0.5):
                left = x + 0.25 * column
                ax = made.add_axes((left + 0.005, foot + 0.02 * high, 0.24, 0.82 * high))
                if x:
                    envelopes.space(ax, envelope)
                else:
                    envelopes.flat(ax, envelope, seen, envelope.sample(SAMPLES, 1))
                title = f"{learnt.task.name}, α = {alpha:g} %" if left == 0.0 else f"α = {alpha:g} %"
                made.text(left + 0.012, foot + 0.92 * high, title, fontweight="bold", fontsize=10.5)
        said = f"{'xyz'[seen[1]]} over {'xyz'[seen[0]]}, with {SAMPLES} poses drawn inside"
        made.text(0.012, foot + 0.865 * high, said, color=SOFT, fontsize=9.0)
        made.text(0.512, foot + 0.865 * high, "in space, with sections across", color=SOFT, fontsize=9.0)
    return made


def _plane(learnt: Learnt) -> tuple[int, int]:
    """The two of the world's axes along which the envelope is largest: the way it goes, and one across."""
    means, covariances = envelopes.positions(learnt.envelope)
    reach = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    size = (means + reach).max(axis=0) - (means - reach).min(axis=0)
    along = int(np.abs(means[-1] - means[0])[:2].argmax())
    across = max((i for i in range(3) if i != along), key=lambda i: size[i])
    return along, across


def costs(found: Sequence[Runs]) -> Figure:
    """A row for each task: nodes and run time of every run, by variant and α."""
    tasks = list(dict.fromkeys(runs.task for runs in found))
    made = figure(9.0, 2.9 * len(tasks) + 0.35)
    axes = made.subplots(len(tasks), 2, squeeze=False)
    made.subplots_adjust(left=0.09, right=0.985, top=0.94, bottom=0.13, hspace=0.42, wspace=0.22)
    for row, task in zip(axes, tasks, strict=True):
        mine = [runs for runs in found if runs.task == task]
        _runs(row[0], mine, [[a.plan.stats["nodes"] for a in runs.answers] for runs in mine])
        _runs(row[1], mine, [[1e3 * a.seconds for a in runs.answers] for runs in mine])
        row[0].set_title(f"{task}: nodes of the tree", fontweight="bold")
        row[1].set_title(f"{task}: run time, ms", fontweight="bold")
    made.legend(handles=_cost_handles(), loc="lower center", ncols=3, columnspacing=1.6)
    return made


def _cost_handles() -> list[Line2D]:
    dot: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 5.5, "color": INK}
    return [
        Line2D([], [], label="a run", **dot),
        Line2D([], [], markerfacecolor="white", label="a run without a path in time", **dot),
        Line2D([], [], color=INK, linewidth=2.2, label="median"),
    ]


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
