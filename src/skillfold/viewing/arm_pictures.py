"""The three-link arm of paper 000 in pictures: its skill as a surface in joint space, its motions in the plane."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from skillfold.experiments.demo import Chapter
from skillfold.experiments.reaching import GRID_SHAPE, grid
from skillfold.experiments.three_link import LINK, REACHING, WEIGHTED_REACHING, forward, optimal
from skillfold.motion import Array
from skillfold.viewing import plots
from skillfold.viewing.style import FAINT, INK, OFF, ON, PLANS, SURFACE, bare

SHOWN = 4  # paths
POSES = 7  # of each path
FACING, ALONG = (20.0, -86.0), (14.0, -128.0)  # degrees: views of the surface
RINGS, SPOKES = (0.05, 0.95, 25), (0.02, np.pi - 0.02, 64)  # m and rad: where the surface of section V-B is drawn
ROOM = 0.08  # around the surface, of its extent


def sheet(skill: Any) -> Array:
    """The learnt surface over the paper's grid of positions, (m, n, 3)."""
    return skill.project(optimal(grid(), REACHING)).reshape(*GRID_SHAPE, 3)


def half_disc() -> Array:
    """Optimal poses of section V-B over a half ring of tool positions, (m, n, 3)."""
    rings, spokes = np.meshgrid(np.linspace(*RINGS), np.linspace(*SPOKES), indexing="ij")
    places = np.stack([rings * np.cos(spokes), rings * np.sin(spokes)], axis=-1)
    return optimal(places.reshape(-1, 2), WEIGHTED_REACHING).reshape(*rings.shape, 3)


def joint_space(
    ax: Any, surface: Array, view: tuple[float, float] = FACING, labels: bool = True, zoom: float | None = None
) -> None:
    """Axes of joint space with a surface (m, n, 3) in it, seen from `view`; closer with a larger `zoom`."""
    ax.computed_zorder = False
    plots.surface(ax, surface, SURFACE)
    ax.set_proj_type("ortho")
    flat = surface.reshape(-1, 3)
    room = ROOM * np.ptp(flat, axis=0)
    low, high = flat.min(axis=0) - room, flat.max(axis=0) + room
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect(high - low, zoom=zoom or (1.1 if labels else 1.2))
    ax.view_init(*view)
    for axis, name in zip((ax.xaxis, ax.yaxis, ax.zaxis), ("q₁", "q₂", "q₃"), strict=True):
        _joint_axis(axis, f"{name}, rad" if labels else "")


def learnt(ax: Any, arm: Chapter, surface: Array) -> None:
    """Samples, tangents on every few lines of the surface, and paths."""
    plots.samples(ax, arm.demonstrations[0])
    states = surface[2::4, 3::4].reshape(-1, 3)
    plots.tangents(ax, states, arm.skill.tangent(states), 0.1)
    plots.paths(ax, arm.paths[:SHOWN])


def motions(ax: Any, paths: Sequence[Array]) -> None:
    """Poses along each path, ever stronger toward the goal, and the way of the tool."""
    ax.plot(*grid().T, linestyle="none", marker="o", color=FAINT, markersize=1.6, markeredgewidth=0.0, zorder=0)
    for path, color in zip(paths[:SHOWN], PLANS, strict=False):
        for index in np.linspace(0, len(path) - 1, POSES).astype(int)[:-1]:
            _pose(ax, path[index], color, 1.1, 0.10 + 0.15 * index / len(path))
        _pose(ax, path[-1], color, 2.0, 0.75)
    ax.plot(0, 0, marker="o", color=INK, markersize=7.0, zorder=7)
    plots.paths(ax, [forward(path) for path in paths[:SHOWN]])
    bare(ax)


def errors(ax: Any, found: Array, paper: float) -> None:
    """Share of paths below an error, beside the paper's mean."""
    ordered = np.sort(found)
    shares = np.arange(1, len(ordered) + 1) / len(ordered)
    ax.set_xscale("log")
    ax.plot(np.append(ordered, 1.0), np.append(shares, 1.0), color=ON, linewidth=2.2, drawstyle="steps-post")
    ax.axvline(paper, color=OFF, linewidth=1.6)
    ax.set_xlim(ordered[0] / 2, 5 * paper)
    ax.set_ylim(0.0, 1.04)
    total = float(np.sqrt(np.mean(found**2)))
    place = 1.5 * float(np.median(ordered))
    ax.text(place, 0.44, f"skillfold: {len(found)} paths,\n{total:.1e} rad in all", color=ON, va="center")
    ax.text(0.88 * paper, 0.06, f"paper: {paper:.1e} rad in all", color=OFF, ha="right")
    ax.set_xlabel("RMSE of a path against the optimal poses, rad")
    ax.set_ylabel("share of paths below")


def _joint_axis(axis: Any, label: str) -> None:
    axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
    axis.line.set_color(FAINT)
    axis._axinfo["grid"].update(color=FAINT, linewidth=0.5)
    axis._axinfo["tick"].update(inward_factor=0.0, outward_factor=0.0)
    axis.set_major_locator(MaxNLocator(4))
    axis.label.set_text(label)
    axis.labelpad = 2.0
    axis.set_tick_params(pad=1.0)
    if not label:
        axis.set_ticklabels([])


def _pose(ax: Any, joints: Array, color: str, width: float, alpha: float) -> None:
    """Base, both middle joints and tool."""
    angles = np.cumsum(joints)
    steps = LINK * np.column_stack([np.cos(angles), np.sin(angles)])
    points = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    ax.plot(*points.T, color=color, linewidth=width, alpha=alpha, zorder=2)
    ax.plot(*points[1:-1].T, linestyle="none", marker="o", color=color, markersize=2 * width, alpha=alpha, zorder=3)
