"""A tray with tumblers carried past a box and pushed: its way in space, tilts over time, distance and modes."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from skillfold.control.rollout import Rollout
from skillfold.errors import RobotError
from skillfold.experiments import tray
from skillfold.experiments.tray_demo import Carrying, distance
from skillfold.experiments.tumbler_runs import TRAY
from skillfold.motion import Array
from skillfold.viewing.style import FAINT, INK, OFF, ON, PLANS, SOFT, bare, figure, save, style

SHOTS = (0.0, 0.42, 0.62, 1.0)  # share of the run at which it is drawn
CUT = (slice(70, 430), slice(110, 560))  # rows and columns of a snapshot that are shown
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))
LEAST, LEVEL, LARGEST = 1e-4, 2e-3, 2.0  # rad: least distance, ends of the tilts that are shown
MODES = {"tracking": FAINT, "returning": OFF, "replanned": "#cfe5e3", "holding": PLANS[2]}


def draw(carrying: Carrying, path: Path) -> tuple[Path, str]:
    """Write the picture; returns its path, and a note where the simulation could not be drawn.

    Raises:
        InputError: the file cannot be written.
    """
    shots, note = _shots(carrying)
    with style():
        return save(tumblers(carrying, shots), path), note


def tumblers(carrying: Carrying, shots: list[Any]) -> Figure:
    """Above snapshots, where there are any; below the way from two sides, and what happened over time."""
    top = 0.62 if shots else 0.93
    made = figure(12.0, 8.6 if shots else 5.6)
    for i, shot in enumerate(shots):
        ax = made.add_axes((0.005 + 0.2485 * i, 0.67, 0.245, 0.32))
        ax.imshow(shot[CUT])
        ax.set_axis_off()
    side, above = (
        made.add_axes(place) for place in ((0.03, 0.52 * top, 0.38, 0.45 * top), (0.03, 0.02, 0.38, 0.45 * top))
    )
    _way(side, carrying, (1, 2))
    _way(above, carrying, (1, 0))
    heights = {"tray": (0.70, 0.30), "tumblers": (0.38, 0.26), "distance": (0.09, 0.22)}
    axes = {name: made.add_axes((0.49, y * top, 0.49, h * top)) for name, (y, h) in heights.items()}
    _tray_tilt(axes["tray"], carrying)
    _tumbler_tilts(axes["tumblers"], carrying)
    _distance(axes["distance"], carrying)
    made.text(0.03, 1.015 * top, "way of the tray, from the side and from above", fontweight="bold", fontsize=10.5)
    made.text(0.45, 1.015 * top, "over time, with the push shaded", fontweight="bold", fontsize=10.5)
    made.legend(handles=_legend(), loc="lower left", bbox_to_anchor=(0.02, -0.005), ncols=3, columnspacing=1.2)
    return made


def _shots(carrying: Carrying) -> tuple[list[Any], str]:
    """Pictures of the run, none where nothing can be drawn off the screen."""
    from skillfold.robots.rendering import pictures
    from skillfold.robots.world import World

    run = carrying.skilled
    rows = [min(int(share * len(run)), len(run) - 1) for share in SHOTS]
    world = World(tray.arm(), carrying.scene, TRAY, visual=True)
    try:
        return list(pictures(world, run.times[rows], run.states[rows], run.tumblers[rows])), ""
    except RobotError as error:
        return [], f"{error} The picture of the tray has no snapshots."


def _way(ax: Any, carrying: Carrying, axes: tuple[int, int]) -> None:
    """The tool's way in a plane, the box before and after it moved, the tray now and then."""
    box: Any = carrying.scene.shapes[0]
    for pose, line in zip(box.motion.poses, (":", "-"), strict=True):
        _box(ax, np.array([pose[a] for a in axes]), np.array([box.size[a] for a in axes]), line)
    planned = tray.positions(np.asarray(carrying.plan.path.states))
    ax.plot(*planned[:, axes].T, color=SOFT, linewidth=1.4, linestyle="--", zorder=3)
    for run, color in ((carrying.naive, OFF), (carrying.skilled, ON)):
        ax.plot(*run.tool_poses[:, axes].T, color=color, linewidth=2.0, zorder=4)
        if run is carrying.skilled:
            for row in np.linspace(0, len(run) - 1, 9).astype(int):
                _tray(ax, run.tool_poses[row], axes)
    pushed = carrying.skilled.times.searchsorted(carrying.trial.push.time if carrying.trial.push else 0.0)
    ax.plot(*carrying.skilled.tool_poses[pushed, axes].T, marker="*", color=INK, markersize=10.0, zorder=6)
    ax.autoscale_view()
    bare(ax)


def _box(ax: Any, middle: Array, size: Array, line: str) -> None:
    corners = middle + 0.5 * size * np.array(CORNERS)
    look = {"facecolor": FAINT, "alpha": 0.45, "edgecolor": SOFT, "linestyle": line}
    ax.add_patch(Polygon(corners, closed=True, linewidth=1.0, zorder=1, **look))


def _tray(ax: Any, pose: Array, axes: tuple[int, int]) -> None:
    """Outline of the tray, with standing tumblers seen from the side."""
    from skillfold.robots.poses import place_points

    half = 0.5 * np.array(TRAY.size)
    places = np.array([[x * half[0], y * half[1], TRAY.height] for x, y in CORNERS])
    corners = place_points(pose, places)[:, axes]
    ax.add_patch(Polygon(corners, closed=True, fill=False, edgecolor=ON, linewidth=0.8, alpha=0.5, zorder=2))


def _shaded(ax: Any, carrying: Carrying) -> None:
    push = carrying.trial.push
    if push:
        ax.axvspan(push.time, push.end, color=PLANS[2], alpha=0.25, linewidth=0.0)
    ax.set_xlim(0.0, max(carrying.skilled.times[-1], carrying.naive.times[-1]))


def _tray_tilt(ax: Any, carrying: Carrying) -> None:
    _shaded(ax, carrying)
    for run, color in ((carrying.naive, OFF), (carrying.skilled, ON)):
        ax.plot(run.times, tray.tilt(run.states), color=color, linewidth=2.0)
    ax.set(ylim=(0.0, None), ylabel="tilt of the tray, rad")
    ax.set_xticklabels([])


def _tumbler_tilts(ax: Any, carrying: Carrying) -> None:
    _shaded(ax, carrying)
    ax.set_yscale("log")
    for run, color in ((carrying.naive, OFF), (carrying.skilled, ON)):
        ax.plot(run.times, np.maximum(run.tilts, LEVEL), color=color, linewidth=1.3)
    ax.set(ylim=(LEVEL, LARGEST), ylabel="tumblers, rad")
    ax.set_xticklabels([])


def _distance(ax: Any, carrying: Carrying) -> None:
    """Distance from the manifold over the controller's modes."""
    _shaded(ax, carrying)
    ax.set_yscale("log")
    for run, color in ((carrying.naive, OFF), (carrying.skilled, ON)):
        times, away = distance(run, carrying.skill)
        ax.plot(times, np.maximum(away, LEAST), color=color, linewidth=1.6)
    ax.set(ylabel="from manifold, rad", xlabel="time, s")
    _modes(ax, carrying.skilled)


def _modes(ax: Any, run: Rollout) -> None:
    """A stripe above the axes in the colours of the modes, with the first of each named."""
    starts = np.flatnonzero(np.r_[True, run.modes[1:] != run.modes[:-1]])
    ends = np.r_[run.times[starts[1:]], run.times[-1]]
    place: dict[str, Any] = {"transform": ax.get_xaxis_transform(), "clip_on": False}
    for start, end in zip(starts, ends, strict=True):
        mode, first = str(run.modes[start]), run.times[start]
        ax.fill_between([first, end], 1.02, 1.14, color=MODES.get(mode, SOFT), linewidth=0.0, **place)
        if end - first > 0.08 * run.times[-1]:
            ax.text(first + 0.02, 1.08, mode, va="center", fontsize=8.0, color=INK, transform=place["transform"])


def _legend() -> list[Line2D]:
    return [
        Line2D([], [], color=ON, linewidth=2.0, label="skill"),
        Line2D([], [], color=OFF, linewidth=2.0, label="naive, no box in its way"),
        Line2D([], [], color=SOFT, linestyle="--", label="as planned at first"),
        Line2D([], [], color=INK, linestyle="none", marker="*", markersize=9.0, label="pushed"),
        Line2D([], [], color=SOFT, linestyle=":", label="box at first"),
        Line2D([], [], color=SOFT, linestyle="-", label="box, risen"),
    ]
