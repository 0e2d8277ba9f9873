"""Section VIII of paper 000 in one picture (its figures 29 to 32): motions from and to the places of cubes, and the
tunnel that the distance from the manifold makes around the recordings.

Three-dimensional sets are seen from the side: along the level way from start to goal, and upward.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skillfold.experiments.pick_place import Cell, Compared
from skillfold.motion import Array
from skillfold.viewing.style import FIELD, INK, OFF, ON, SOFT, bare, figure, save, style

CELLS = 90  # rows and columns of the field
ROOM = 0.15  # around the recordings, of their extent
LEVELS = 12


def draw(compared: Compared, path: Path) -> Path:
    """Write the picture of one set.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(motions(compared), path)


def motions(compared: Compared) -> Figure:
    """The recordings in their tunnel, then a column for each method: starts changed, and goals."""
    methods = list(compared.cells.items())
    side = _Side(compared.motions.start, compared.motions.goal)
    low, high = _extent(compared, side)
    width = 3.4 * (1 + len(methods))
    made = figure(width, 1.1 + 2 * 3.2 * float((high - low)[1] / (high - low)[0]))
    axes = made.subplots(2, 1 + len(methods), squeeze=False)
    made.subplots_adjust(left=0.02, right=0.98, bottom=0.1, top=0.93, wspace=0.04, hspace=0.12)
    _tunnel(axes[0, 0], compared, low, high, side)
    axes[1, 0].legend(handles=_handles(), loc="center")
    for column, (name, cells) in zip(axes.T[1:], methods, strict=True):
        for ax, cell in zip(column, cells[1::2], strict=True):
            _answers(ax, name, cell, side)
    for ax in axes.ravel():
        if ax is not axes[1, 0]:
            _recordings(ax, compared, side)
        bare(ax)
        ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    return made


class _Side:
    """The plane that sets are seen in: along the level way from start to goal, and upward."""

    def __init__(self, start: Array, goal: Array) -> None:
        self.flat = len(start) == 2
        level = np.eye(len(start))[0] if self.flat else np.append((goal - start)[:2], 0.0)
        self.axes = np.stack([level / np.linalg.norm(level), np.eye(len(start))[-1]])
        self.goal = goal

    def __call__(self, states: Array) -> Array:
        return (states - self.goal) @ self.axes.T

    def back(self, points: Array) -> Array:
        """States of the plane."""
        return self.goal + points @ self.axes


def _recordings(ax: Any, compared: Compared, side: _Side) -> None:
    for recording in compared.motions.recordings:
        ax.plot(*side(recording).T, color=SOFT, linewidth=1.2, zorder=2)


def _extent(compared: Compared, side: _Side) -> tuple[Array, Array]:
    """Lowest and highest corner of what is shown."""
    seen = side(np.concatenate(compared.motions.recordings))
    room = ROOM * np.ptp(seen, axis=0).max()
    return seen.min(axis=0) - room, seen.max(axis=0) + room


def _tunnel(ax: Any, compared: Compared, low: Array, high: Array, side: _Side) -> None:
    x, y = (np.linspace(a, b, CELLS) for a, b in zip(low, high, strict=True))
    distance = compared.skill.distance(side.back(np.stack(np.meshgrid(x, y), axis=-1)))
    ax.contourf(x, y, distance, LEVELS, cmap=FIELD, zorder=0)
    ax.set_title("distance from the manifold")


def _answers(ax: Any, name: str, cell: Cell, side: _Side) -> None:
    for path, reached in zip(cell.paths, cell.reached, strict=True):
        ax.plot(*side(path).T, color=ON if reached else OFF, linewidth=0.8, alpha=0.8, zorder=3)
    ends = np.array([path[-1] for path in cell.paths])
    ax.plot(*side(ends).T, linestyle="none", marker="x", color=INK, markersize=4.0, zorder=4)
    ax.set_title(f"{name}, {cell.what}s changed: {int(cell.reached.sum())} of {len(cell.reached)}")


def _handles() -> Sequence[Line2D]:
    return [
        Line2D([], [], color=SOFT, linewidth=1.4, label="recordings"),
        Line2D([], [], color=ON, linewidth=1.4, label="reach their goal"),
        Line2D([], [], color=OFF, linewidth=1.4, label="do not"),
        Line2D([], [], linestyle="none", marker="x", color=INK, markersize=5.0, label="where they end"),
    ]
