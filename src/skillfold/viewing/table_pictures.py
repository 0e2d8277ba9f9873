"""Table I of paper 000 in one picture: a pushed motion, the tray's tilt, the excess cost, and the figures."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skillfold.experiments import three_link, tray
from skillfold.experiments.pushed_motions import PUSHED_AT, STEPS
from skillfold.experiments.table_one import PAPER, Half
from skillfold.motion import Array
from skillfold.viewing.style import FAINT, INK, OFF, ON, SOFT, figure, save, style

COLORS = {"naive": OFF, "manifold": ON}
HEADS = ("", "method", "not pushed", "paper", "pushed", "paper")
COLUMNS = (0.0, 0.105, 0.225, 0.415, 0.615, 0.805)


def draw(halves: tuple[Half, Half], path: Path) -> Path:
    """Write the picture.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(table_one(*halves), path)


def table_one(arm: Half, kuka: Half) -> Figure:
    """Above a pushed motion of the three-link arm and the tray's tilt, below the excess cost and the table."""
    made = figure(12.0, 7.6)
    places = {"motion": (0.02, 0.5, 0.44, 0.43), "tilt": (0.55, 0.55, 0.43, 0.37), "excess": (0.07, 0.09, 0.38, 0.32)}
    axes = {name: made.add_axes(place) for name, place in places.items()}
    _motion(axes["motion"], arm)
    _tilts(axes["tilt"], kuka)
    _excess(axes["excess"], (arm, kuka))
    _table(made.add_axes((0.5, 0.04, 0.49, 0.38)), (arm, kuka))
    titles = {
        (0.02, 0.955): "three-link arm: one motion, pushed by 0.5 rad",
        (0.52, 0.955): f"KUKA arm: tilt of the tray, pushed by {kuka.runs[-1].push:g} rad",
        (0.02, 0.445): "excess over the optimum, pushed by 0.5 rad",
        (0.5, 0.445): "mean true cost ± standard deviation",
    }
    for place, title in titles.items():
        made.text(*place, title, fontweight="bold", fontsize=10.5)
    return made


def _motion(ax: Any, half: Half) -> None:
    """The way of the tool in a typical trial."""
    alone, pushed = half.runs[:2]
    trial = _typical(half)
    turn = np.linspace(0.0, np.pi, 200)
    ax.plot(np.cos(turn), np.sin(turn), color=FAINT, linewidth=1.0)
    ax.plot([-1, 1], [0, 0], color=FAINT, linewidth=1.0)
    _way(ax, alone.motions["manifold"][trial], SOFT, linestyle="--")
    first = int(np.ceil(PUSHED_AT * (STEPS - 1)))
    for method, color in COLORS.items():
        _way(ax, pushed.motions[method][trial, first:], color)
    _way(ax, pushed.motions["manifold"][trial, :first], INK)
    for state, marker in ((pushed.motions["manifold"][trial, first], "*"), (half.task.ends[trial, 1], "o")):
        ax.plot(*three_link.forward(state), marker=marker, color=INK, markersize=9.0 if marker == "*" else 5.0)
    ax.set_aspect("equal")
    ax.set_axis_off()
    lines: list[tuple[str, Any, str]] = [
        (INK, "-", "before the push (star)"),
        (ON, "-", "back to the manifold and on"),
    ]
    lines += [(OFF, "-", "naive quintic"), (SOFT, "--", "as it was planned")]
    handles = [Line2D([], [], color=color, linestyle=dash, label=label) for color, dash, label in lines]
    ax.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, -0.17), ncols=2)


def _typical(half: Half) -> int:
    """Of the longer half of all trials, the one with the median excess of the naive planner."""
    long = np.argsort(np.linalg.norm(np.diff(half.task.ends, axis=1)[:, 0], axis=1))[len(half.task.ends) // 2 :]
    means = np.nanmean(half.runs[1].excess["naive"][long], axis=1)
    return int(long[np.argsort(means)[len(long) // 2]])


def _way(ax: Any, states: Array, color: str, **options: Any) -> None:
    ax.plot(*three_link.forward(states).T, color=color, linewidth=1.8, **options)


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
            ax.text(column, height, text.replace(" ± ", "±"), color=color, fontsize=8.0)


def _figures(cost: Array) -> str:
    digits = 1 if cost.mean() > 1 else 4
    return f"{cost.mean():.{digits}f} ± {cost.std():.{digits}f}"
