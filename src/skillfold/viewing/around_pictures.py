"""Section V-B3 of paper 000 in one picture: shortest paths through obstacles on the manifold, and the ways around."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skillfold.experiments.around_shown import Scene
from skillfold.experiments.three_link import forward
from skillfold.viewing import plots
from skillfold.viewing.arm_pictures import half_disc, joint_space
from skillfold.viewing.style import FAINT, INK, OFF, ON, bare, figure, save, style

VIEW = (24.0, -62.0)  # degrees
TITLES = ("around patches", "through the gap of a wall")


def draw(scenes: tuple[Scene, Scene], path: Path) -> Path:
    """Write the picture.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(around(*scenes), path)


def around(patches: Scene, wall: Scene) -> Figure:
    """Joint space with the optimal poses as a surface for each scene; the plane of the tool as an inset."""
    made = figure(12.0, 6.8)
    for left, scene, title in zip((0.0, 0.5), (patches, wall), TITLES, strict=True):
        joints = made.add_axes((left - 0.02, 0.055, 0.51, 0.78), projection="3d")
        joint_space(joints, half_disc(), VIEW, zoom=1.06)
        _paths(joints, scene, lambda states: states)
        _plane(made.add_axes((left + 0.27, 0.735, 0.21, 0.25)), scene)
        made.text(left + 0.02, 0.945, title, fontweight="bold", fontsize=10.5)
    made.legend(handles=_handles(), loc="lower center", ncols=4)
    return made


def _plane(ax: Any, scene: Scene) -> None:
    """Ways of the tool."""
    turn = np.linspace(0.0, np.pi, 200)
    ax.plot(np.cos(turn), np.sin(turn), color=FAINT, linewidth=1.0)
    ax.plot([-1, 1], [0, 0], color=FAINT, linewidth=1.0)
    ax.plot(0, 0, marker="o", color=INK, markersize=3.5)
    _paths(ax, scene, forward, 0.6)
    bare(ax)
    ax.patch.set_alpha(0.0)
    ax.set(xlim=(-1.05, 1.05), ylim=(-0.5, 1.05))


def _paths(ax: Any, scene: Scene, seen: Any, size: float = 1.0) -> None:
    """Obstacle points, the paths through them and the ways around, as `seen` shows states (n, 3)."""
    dots: dict[str, Any] = {
        "linestyle": "none",
        "marker": "o",
        "markerfacecolor": "none",
        "markeredgewidth": 0.8 * size,
    }
    ax.plot(*seen(scene.points).T, markeredgecolor=OFF, markersize=4.5 * size, zorder=3, **dots)
    for path in scene.through:
        ax.plot(*seen(path).T, color=OFF, linewidth=1.5 * size, linestyle="--", zorder=4)
    plots.paths(ax, [seen(path) for path in scene.around], (ON,), 2.2 * size)


def _handles() -> list[Line2D]:
    hollow: dict[str, Any] = {"linestyle": "none", "marker": "o", "markerfacecolor": "none"}
    return [
        Line2D([], [], markeredgecolor=OFF, markersize=4.5, label="obstacle points", **hollow),
        Line2D([], [], color=OFF, linewidth=1.5, linestyle="--", label="shortest paths"),
        Line2D([], [], color=ON, linewidth=2.2, label="planned around them"),
        Line2D([], [], markeredgecolor=ON, markersize=6.0, label="start", **hollow),
    ]
