"""Figures 6 and 8 of paper 002: five paths of each task in x, y and z, in the whole and in the reduced envelope."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from skillfold.experiments.keyframe_demo import Chapter, Story
from skillfold.experiments.keyframe_runs import ALPHAS
from skillfold.motion import Array
from skillfold.robots.shapes import Box
from skillfold.viewing.envelope_pictures import AZIMUTH, ELEVATION, legend, space, view
from skillfold.viewing.keyframe_pictures import COLORS, LOOKS
from skillfold.viewing.style import INK, figure, save, style

WIDE, HIGH = 5.6, 3.9  # inches of a panel
ROUND = 48  # corners of a cylinder's outline


def draw(story: Story, path: Path) -> Path:
    """Write the picture.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(tasks(story), path)


def tasks(story: Story) -> Figure:
    """A row for each task, a column for each α."""
    rows = len(story.chapters)
    width, height = len(ALPHAS) * WIDE, rows * HIGH + 0.4
    made = figure(width, height)
    for row, chapter in enumerate(story.chapters):
        for column, alpha in enumerate(ALPHAS):
            foot = 0.4 + (rows - 1 - row) * HIGH
            room = (column * WIDE + 0.1, foot, WIDE - 0.2, HIGH - 0.5)
            ax = made.add_axes((room[0] / width, room[1] / height, room[2] / width, room[3] / height))
            _paths(ax, chapter, alpha)
            title = f"task {row + 1}: {chapter.learnt.task.name}, α = {alpha:g} %"
            at = ((room[0] + 0.05) / width, (foot + HIGH - 0.3) / height)
            made.text(*at, title, fontweight="bold", fontsize=10.5)
    made.legend(handles=_legend(), loc="lower center", ncols=5, columnspacing=1.6)
    return made


def _paths(ax: Any, chapter: Chapter, alpha: float) -> None:
    envelope = chapter.learnt.envelope
    space(ax, envelope if alpha == 100.0 else envelope.reduced(alpha))
    plane = view(ELEVATION, AZIMUTH)
    for shape in chapter.learnt.task.scene:
        if shape.name != "table":
            _solid(ax, shape, plane, LOOKS[f"scene: {shape.name}"])
    for path, color in zip(chapter.paths(alpha), COLORS, strict=False):
        ax.plot(*(path @ plane.T).T, color="white", linewidth=3.4, zorder=7)
        ax.plot(*(path @ plane.T).T, color=color, linewidth=2.0, zorder=8)
    ax.plot(*(plane @ chapter.learnt.task.robot.forward(chapter.start)[:3]), marker="o", color=INK, zorder=9)


def _solid(ax: Any, shape: Any, plane: Array, color: str) -> None:
    """What an upright box or cylinder covers, and its rims; there is room for it."""
    rims = [corners @ plane.T for corners in _rims(shape)]
    look: dict[str, Any] = {"facecolor": color, "edgecolor": color, "linewidth": 1.0, "closed": True}
    ax.add_patch(Polygon(_hull(np.concatenate(rims)), alpha=0.3, zorder=5, **look))
    low, high = np.min(np.concatenate(rims), axis=0) - 0.01, np.max(np.concatenate(rims), axis=0) + 0.01
    (left, right), (foot, head) = ax.get_xlim(), ax.get_ylim()
    ax.set(xlim=(min(left, low[0]), max(right, high[0])), ylim=(min(foot, low[1]), max(head, high[1])))
    for rim in rims:
        ax.add_patch(Polygon(rim, closed=True, fill=False, edgecolor=color, linewidth=0.8, alpha=0.7, zorder=6))


def _rims(shape: Any) -> list[Array]:
    """Lower and upper rim (n, 3)."""
    if isinstance(shape, Box):
        flat = 0.5 * np.array(shape.size[:2]) * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        half = 0.5 * shape.size[2]
    else:
        angle = np.linspace(0.0, 2 * np.pi, ROUND, endpoint=False)
        flat, half = shape.radius * np.column_stack([np.cos(angle), np.sin(angle)]), 0.5 * shape.length
    place = np.array(shape.pose)[:3]
    return [place + np.column_stack([flat, np.full(len(flat), high)]) for high in (-half, half)]


def _hull(points: Array) -> Array:
    from scipy.spatial import ConvexHull

    return points[ConvexHull(points).vertices]


def _legend() -> list[Line2D]:
    return [
        *legend(),
        Line2D([], [], color=INK, label="start", linestyle="none", marker="o", markersize=6.0),
        Line2D([], [], color=COLORS[0], linewidth=2.0, label="paths of the tool"),
    ]
