"""Section VIII of paper 000 in pictures: the recordings and their graph (figure 28), and motions from and to the
places of cubes, by every method (figures 29 to 31).
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skillfold.experiments.pick_place import Cell, Compared
from skillfold.manifold.graph import build_graph
from skillfold.motion import Array
from skillfold.viewing.motion_views import CORNERS, Seen
from skillfold.viewing.style import INK, OFF, ON, PLANS, SOFT, TUNNEL, figure, save, style

COLORS = (*PLANS, "#7a3b8f")  # a colour for each recording
WIDE = 4.1  # inches of a panel
HEAD, FOOT = 0.34, 0.42  # inches above each row of panels, and below all for the legend
CLOSE = 0.26  # of a panel's width: the cube seen from near
NEAR = 1.7  # half the width of what is seen from near, in halves of the cube's edge
TANGENTS, AROUND, LONG = 70, 0.07, 0.045  # how many, how far from the recordings and how long, of the way


def draw_data(compared: Compared, path: Path) -> Path:
    """Write the picture of the recordings.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(data(compared), path)


def draw_moved(compared: Compared, what: str, path: Path) -> Path:
    """Write the picture of changed starts, or goals.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(moved(compared, what), path)


def data(compared: Compared) -> Figure:
    """The neighbourhood graph beside the recordings, every state a dot."""
    motions = compared.motions
    seen = Seen.of(motions.recordings)
    made, ((left, right),) = _panels(1, 2, seen)
    _graph(left, motions.recordings, seen)
    left.set_title("neighbourhood graph", fontweight="bold")
    for recording, color in zip(motions.recordings, COLORS * len(motions.recordings), strict=False):
        right.plot(*seen(recording).T, color=color, linewidth=0.9, alpha=0.8, zorder=3)
        right.plot(*seen(recording).T, linestyle="none", marker=".", markersize=3.0, color=color, zorder=4)
    _ends(right, seen, np.array([r[0] for r in motions.recordings]), motions.goal[None])
    right.set_title(f"{motions.name}: {len(motions.recordings)} recordings", fontweight="bold")
    seen.axes(right, seen.free_corner(motions.recordings))
    legend = [Line2D([], [], color=INK, linewidth=0.9, label="in time"), *_end_handles()]
    legend.insert(1, Line2D([], [], color=TUNNEL, linewidth=0.9, alpha=0.6, label="neighbours"))
    made.legend(handles=legend, loc="lower center", ncols=len(legend))
    return made


def moved(compared: Compared, what: str) -> Figure:
    """A row for each cube, a column for each method."""
    recordings = compared.motions.recordings
    seen = Seen.of(recordings)
    methods = list(compared.cells.items())
    made, axes = _panels(2, len(methods), seen)
    for column, (name, cells) in enumerate(methods):
        for row, cell in enumerate(each for each in cells if each.what == what):
            ax = axes[row, column]
            _shown(ax, recordings, seen)
            if name == "manifold":
                _tangents(ax, compared, seen)
            _answers(ax, cell, seen)
            count = f"{int(cell.reached.sum())} of {len(cell.reached)}"
            ax.set_title(f"{name}, {cell.size} cube: {count} reach the goal", fontweight="bold")
            _near(ax, cell, recordings, seen)
    legend = _handles()
    made.legend(handles=legend, loc="lower center", ncols=len(legend), columnspacing=1.5)
    return made


def _panels(rows: int, columns: int, seen: Seen) -> tuple[Figure, Any]:
    """Frames as high as what is shown is, room for titles above each and for the legend below."""
    high = WIDE * seen.ratio
    width, height = columns * (WIDE + 0.15) + 0.1, rows * (high + HEAD) + FOOT
    made = figure(width, height)
    axes = np.empty((rows, columns), dtype=object)
    for i in range(rows):
        for j in range(columns):
            foot = FOOT + (rows - 1 - i) * (high + HEAD)
            room = (0.1 + j * (WIDE + 0.15), foot, WIDE, high)
            axes[i, j] = made.add_axes((room[0] / width, room[1] / height, room[2] / width, room[3] / height))
            seen.frame(axes[i, j])
    return made, axes


def _graph(ax: Any, recordings: Sequence[Array], seen: Seen) -> None:
    """Edges between neighbours, and those in time."""
    states = np.concatenate(recordings)
    groups = np.repeat(np.arange(len(recordings)), [len(recording) for recording in recordings])
    edges = build_graph(states, min(max(6, 2 * states.shape[1]), 10), groups).edges  # as the fit does
    timely = (np.diff(edges, axis=1)[:, 0] == 1) & (groups[edges[:, 0]] == groups[edges[:, 1]])
    for which, color, alpha in ((~timely, TUNNEL, 0.35), (timely, INK, 0.9)):
        ax.add_collection(LineCollection(list(seen(states[edges[which]])), colors=color, linewidths=0.7, alpha=alpha))


def _shown(ax: Any, recordings: Sequence[Array], seen: Seen) -> None:
    for recording in recordings:
        ax.plot(*seen(recording).T, color=SOFT, linewidth=1.6, alpha=0.75, zorder=2)


def _tangents(ax: Any, compared: Compared, seen: Seen) -> None:
    """Tangent spaces about the recordings: the direction in each that the recordings go in there."""
    motions = compared.motions
    rng = np.random.default_rng(0)
    states = np.concatenate([recording[:-1] for recording in motions.recordings])
    ways = np.concatenate([np.diff(recording, axis=0) for recording in motions.recordings])
    chosen = rng.choice(len(states), min(TANGENTS, len(states)), replace=False)
    at = states[chosen] + AROUND * motions.reach * rng.standard_normal((len(chosen), states.shape[1]))
    frames = np.asarray(compared.skill.tangent(at))
    along = np.einsum("nij,nkj,nk->ni", frames, frames, ways[chosen])
    size = np.linalg.norm(along, axis=1, keepdims=True)
    tips = at + LONG * motions.reach * along / np.maximum(size, 1e-12)
    for a, b in zip(seen(at), seen(tips), strict=True):
        if (np.minimum(a, b) < seen.low).any() or (np.maximum(a, b) > seen.high).any():
            continue
        look = {"arrowstyle": "-|>,head_width=0.1,head_length=0.2", "color": TUNNEL, "linewidth": 0.7, "alpha": 0.55}
        ax.annotate("", b, a, arrowprops=look | {"shrinkA": 0.0, "shrinkB": 0.0}, zorder=1)


def _answers(ax: Any, cell: Cell, seen: Seen, width: float = 0.8) -> None:
    for path, reached in zip(cell.paths, cell.reached, strict=True):
        finite = path[np.isfinite(path).all(axis=1)]
        ax.plot(*seen(finite).T, color=ON if reached else OFF, linewidth=width, alpha=0.8, zorder=3)
    last = np.array([path[-1] for path in cell.paths])
    ax.plot(*seen(last).T, linestyle="none", marker="x", color=INK, markersize=4.0, markeredgewidth=0.9, zorder=5)
    _ends(ax, seen, cell.ends[:, 0], cell.ends[:, 1])


def _ends(ax: Any, seen: Seen, starts: Array, goals: Array) -> None:
    for states, marker in ((starts, "o"), (goals, "s")):
        places = np.unique(states, axis=0)
        look: dict[str, Any] = {"markersize": 2.6 if len(places) > 1 else 5.5, "markerfacecolor": OFF}
        ax.plot(*seen(places).T, linestyle="none", marker=marker, markeredgecolor="none", zorder=6, **look)


def _near(ax: Any, cell: Cell, recordings: Sequence[Array], seen: Seen) -> None:
    """The cube from near, in the corner that is free."""
    moved = cell.ends[:, 0 if cell.what == "start" else 1]
    middle, half = seen(moved.mean(axis=0)), 0.5 * np.ptp(seen(moved), axis=0).max()
    tall = CLOSE / seen.ratio
    x, y = np.array(CORNERS[seen.free_corner(recordings)]) * (1.0 - np.array([CLOSE, tall]))
    window = [(m - NEAR * half, m + NEAR * half) for m in middle]
    close = ax.inset_axes((x, y, CLOSE, tall), xlim=window[0], ylim=window[1], xticks=[], yticks=[])
    for spine in close.spines.values():
        spine.set(visible=True, color=SOFT, linewidth=0.8)
    close.set_aspect("equal")
    _shown(close, recordings, seen)
    _answers(close, cell, seen)
    ax.indicate_inset_zoom(close, edgecolor=SOFT, linewidth=0.8, alpha=0.9)


def _handles() -> list[Line2D]:
    return [
        Line2D([], [], color=SOFT, linewidth=1.6, label="recordings"),
        Line2D([], [], color=ON, linewidth=1.4, label="reach their goal"),
        Line2D([], [], color=OFF, linewidth=1.4, label="do not"),
        *_end_handles(),
        Line2D([], [], linestyle="none", marker="x", color=INK, markersize=5.0, label="end"),
        Line2D([], [], color=TUNNEL, linewidth=1.0, alpha=0.6, label="tangents"),
    ]


def _end_handles() -> list[Line2D]:
    look: dict[str, Any] = {"linestyle": "none", "markerfacecolor": OFF, "markeredgecolor": "none"}
    return [
        Line2D([], [], marker="o", markersize=4.5, label="start", **look),
        Line2D([], [], marker="s", markersize=5.5, label="goal", **look),
    ]
