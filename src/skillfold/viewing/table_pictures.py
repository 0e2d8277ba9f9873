"""Table I of paper 000 in one picture: the tray's tilt, the excess cost, and the figures."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skillfold.experiments import tray
from skillfold.experiments.pushed_motions import PUSHED_AT, STEPS
from skillfold.experiments.table_one import PAPER, Half
from skillfold.motion import Array
from skillfold.viewing.style import INK, OFF, ON, SOFT, figure, save, style

COLORS = {"naive": OFF, "manifold": ON}
HEADS = ("", "method", "not pushed", "paper", "pushed", "paper")
COLUMNS = (0.0, 0.12, 0.25, 0.44, 0.66, 0.84)


def draw(halves: tuple[Half, Half], path: Path) -> Path:
    """Write the picture.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(table_one(*halves), path)


def table_one(arm: Half, kuka: Half) -> Figure:
    """Above the tray's tilt and the excess cost, below the table."""
    made = figure(12.0, 7.4)
    places = {"tilt": (0.065, 0.575, 0.41, 0.345), "excess": (0.565, 0.575, 0.41, 0.345)}
    axes = {name: made.add_axes(place) for name, place in places.items()}
    _tilts(axes["tilt"], kuka)
    _excess(axes["excess"], (arm, kuka))
    _table(made.add_axes((0.025, 0.02, 0.96, 0.40)), (arm, kuka))
    pushes = " and ".join(f"{half.task.name} pushed by {half.runs[-1].push:g} rad" for half in (arm, kuka))
    titles = {
        (0.025, 0.95): f"KUKA arm: tilt of the tray, pushed by {kuka.runs[-1].push:g} rad",
        (0.525, 0.95): f"excess over the optimum, pushed by {arm.runs[1].push:g} rad",
        (0.025, 0.435): f"mean true cost ± standard deviation, {len(arm.task.ends)} motions; {pushes}",
    }
    for place, title in titles.items():
        made.text(*place, title, fontweight="bold", fontsize=10.5)
    return made


def _tilts(ax: Any, half: Half) -> None:
    """Of every trial over time, and their median."""
    times = np.linspace(0.0, 1.0, STEPS)
    for method, color in COLORS.items():
        motions = half.runs[-1].motions[method]
        tilts = tray.tilt(motions.reshape(-1, motions.shape[-1])).reshape(motions.shape[:2])
        ax.plot(times, tilts.T, color=color, linewidth=0.5, alpha=0.15)
        ax.plot(times, np.median(tilts, axis=0), color=color, linewidth=2.4)
    ax.set(xlim=(0.0, 1.0), ylim=(0.0, None), xlabel="time", ylabel="tilt, rad")
    ax.axvline(PUSHED_AT, color=SOFT, linewidth=0.8, linestyle=":")
    handles = [Line2D([], [], color=color, linewidth=2.4, label=method) for method, color in COLORS.items()]
    ax.legend(handles=handles, loc="upper right", title="median of all trials")


def _excess(ax: Any, halves: tuple[Half, Half]) -> None:
    """Share of trials below an excess, for both systems."""
    ax.set_xscale("log")
    for half, dash in zip(halves, ("-", "--"), strict=True):
        for method, color in COLORS.items():
            means = np.sort(np.nanmean(half.runs[1].excess[method], axis=1))
            shares = np.arange(1, len(means) + 1) / len(means)
            ax.plot(np.maximum(means, 1e-9), shares, color=color, linestyle=dash, drawstyle="steps-post", linewidth=2)
    ax.set(ylim=(0.0, 1.04), xlabel="mean excess cost of a motion", ylabel="share of motions below")
    handles = [Line2D([], [], color=color, label=method) for method, color in COLORS.items()]
    handles += [
        Line2D([], [], color=INK, linestyle=d, label=h.task.name) for h, d in zip(halves, ("-", "--"), strict=True)
    ]
    ax.legend(handles=handles, loc="upper left")


def _table(ax: Any, halves: tuple[Half, Half]) -> None:
    """The table as the paper prints it, its own figures beside."""
    ax.set_axis_off()
    lines = [(half, name) for half in halves for name in half.task.costs]
    rows = [(half, name, method) for half, name in lines for method in COLORS]
    heights = np.linspace(0.92, 0.08, len(rows) + 1)
    for column, head in zip(COLUMNS, HEADS, strict=True):
        ax.text(column, heights[0], head, color=SOFT, fontsize=9.5)
    for height, (half, name, method) in zip(heights[1:], rows, strict=True):
        texts = [f"{half.task.name} {name}" if method == "naive" else "", method]
        for runs in (half.runs[0], half.runs[-1]):
            cost = runs.costs(half.task.costs[name])[method]
            texts += [_figures(cost), PAPER[half.task.name, name, int(runs.push > 0)][method == "manifold"]]
        for i, (column, text) in enumerate(zip(COLUMNS, texts, strict=True)):
            color = SOFT if i in (3, 5) else COLORS[method] if i else INK
            ax.text(column, height, text, color=color, fontsize=9.5)


def _figures(cost: Array) -> str:
    digits = 1 if cost.mean() > 1 else 4
    return f"{cost.mean():.{digits}f} ± {cost.std():.{digits}f}"
