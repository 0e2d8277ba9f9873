"""The arm that carries a tray past boxes in one picture: its tool seen from above and from the side, and the tilt."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.spatial import ConvexHull

from skillfold.experiments import tray
from skillfold.experiments.around_tray import Answer
from skillfold.motion import Array
from skillfold.viewing import plots
from skillfold.viewing.style import FAINT, INK, OFF, ON, SOFT, SURFACE, bare, figure, save, style

POSES = 5  # of the arm along the plan
VIEWS = {"from above": (0, 1), "from the side": (1, 2)}  # the world's axes that are seen
LIMITS = ((-0.35, 1.0), (-0.95, 0.95), (0.0, 1.2))  # m, of each axis
FRAMES = ("base", "link2", "link3", "link4", "link5", "link6", "tool")


def draw(skill: Any, answers: Sequence[Answer], path: Path) -> Path:
    """Write the picture of a few answers.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(past_boxes(skill, answers), path)


def past_boxes(skill: Any, answers: Sequence[Answer]) -> Figure:
    """A column for each answer: the two views, and below them the tray's tilt along the plan."""
    columns = len(answers)
    made = figure(4.0 * columns, 9.0)
    axes = made.subplots(3, columns, squeeze=False, height_ratios=(1.4, 0.9, 0.45))
    made.subplots_adjust(left=0.07, right=0.98, bottom=0.1, top=0.98, hspace=0.12, wspace=0.12)
    for column, answer in zip(axes.T, answers, strict=True):
        shortest = skill.plan(answer.case.start, answer.case.goal, route="geodesic").path.states
        for ax, (title, seen) in zip(column, VIEWS.items(), strict=False):
            _view(ax, answer, shortest, list(seen))
            place = ax.get_position(original=True)
            made.text(place.x0, place.y1 - 0.005, title, fontsize=10.5, va="top")
        _tilt(column[2], answer)
    axes[2, 0].set_ylabel("tilt, mrad")
    made.legend(handles=_handles(), loc="lower center", ncols=4)
    return made


def outline(box: Any, seen: list[int]) -> Array:
    """Corners (n, 2) of a box as it is seen along the third axis."""
    w, z = box.pose[3], box.pose[6]
    cos, sin = w * w - z * z, 2 * w * z  # boxes are turned about the vertical alone
    signs = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3), axis=-1).reshape(-1, 3)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    corners = (np.array(box.pose[:3]) + signs * box.size @ turn.T)[:, seen]
    return corners[ConvexHull(corners).vertices]


def _view(ax: Any, answer: Answer, shortest: Array, seen: list[int]) -> None:
    boxes = [outline(box, seen) for box in answer.case.scene]
    ax.add_collection(PolyCollection(boxes, facecolors=SURFACE, edgecolors="white", alpha=0.6, zorder=1))
    states = answer.plan.path.states
    for index in np.linspace(0, len(states) - 1, POSES).astype(int):
        _arm(ax, states[index], seen, 0.15 + 0.35 * index / len(states))
    ax.plot(*tray.positions(shortest)[:, seen].T, color=OFF, linewidth=1.5, linestyle="--", zorder=4)
    plots.paths(ax, [tray.positions(states)[:, seen]], (ON,))
    bare(ax)
    ax.set(xlim=LIMITS[seen[0]], ylim=LIMITS[seen[1]])


def _arm(ax: Any, q: Array, seen: list[int], alpha: float) -> None:
    points = np.stack([tray.arm().forward(q, frame)[:3] for frame in FRAMES])[:, seen]
    ax.plot(*points.T, color=INK, linewidth=1.4, alpha=alpha, zorder=2)


def _tilt(ax: Any, answer: Answer) -> None:
    shares = np.linspace(0.0, 1.0, len(answer.tilts))
    ax.plot(shares, 1e3 * answer.tilts, color=ON, linewidth=1.8)
    ax.set(xlim=(0.0, 1.0), ylim=(0.0, 12.0), xlabel="share of the path")
    ax.grid(axis="y", color=FAINT, linewidth=0.5)


def _handles() -> list[Line2D]:
    return [
        Line2D([], [], linestyle="none", marker="s", color=SURFACE, markersize=9.0, label="boxes"),
        Line2D([], [], color=OFF, linewidth=1.5, linestyle="--", label="tool, shortest path"),
        Line2D([], [], color=ON, linewidth=2.2, label="tool, planned past them"),
        Line2D([], [], color=SOFT, linewidth=1.4, label="arm"),
    ]
