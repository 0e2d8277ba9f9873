"""Figures 13 and 15 of paper 000: one motion of each arm, pushed on the way, brought back, and led on to its goal."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skillfold.experiments import three_link, tray
from skillfold.experiments.pushed_motions import PUSHED_AT, RETURN, STEPS, Runs
from skillfold.experiments.table_one import Half
from skillfold.motion import Array
from skillfold.viewing.arm_pictures import half_disc, joint_space
from skillfold.viewing.style import FAINT, INK, OFF, ON, PLANS, SOFT, bare, figure, save, style

VIEW = (24.0, -62.0)  # degrees
BACK = PLANS[2]
FRAMES = ("base", "link2", "link3", "link4", "link5", "link6", "tool")
POSES = 6  # of the KUKA arm
VIEWS = {"from above": [0, 1], "from the side": [1, 2]}  # the world's axes that are seen


@dataclass(frozen=True)
class Parts:
    """States (n, D) of one trial.

    Attributes:
        planned: the whole motion as it was planned.
        before: what was followed of it.
        push: where it was then, and where the push took it; (2, D).
        back, on: to the manifold, and along it to the goal.
    """

    planned: Array
    before: Array
    push: Array
    back: Array
    on: Array


def draw(halves: tuple[Half, Half], path: Path) -> Path:
    """Write the picture.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(pushed(*halves), path)


def pushed(arm: Half, kuka: Half) -> Figure:
    """Above the three-link arm, in joint space and in the plane; below the KUKA arm, in space and its joints."""
    made = figure(12.0, 9.2)
    told = parts(arm, arm.runs[1], typical(arm))
    space = made.add_axes((-0.01, 0.485, 0.5, 0.47), projection="3d")
    joint_space(space, half_disc(), VIEW, zoom=1.02)
    _follow(space, told, lambda states: states)
    plane = made.add_axes((0.52, 0.53, 0.46, 0.4))
    _plane(plane, told)
    told = parts(kuka, kuka.runs[-1], typical(kuka))
    _kuka(made, told)
    _joints(made, told)
    titles = {
        (0.025, 0.965): f"three-link arm, pushed by {arm.runs[1].push:g} rad: joint space",
        (0.52, 0.965): "the way of its tool",
        (0.025, 0.45): f"KUKA arm, pushed by {kuka.runs[-1].push:g} rad: the way of its tool",
        (0.52, 0.45): "its joints over time, rad",
    }
    for place, title in titles.items():
        made.text(*place, title, fontweight="bold", fontsize=10.5)
    made.legend(handles=_handles(), loc="lower center", ncols=5, bbox_to_anchor=(0.5, -0.004))
    return made


def typical(half: Half) -> int:
    """Of the longer half of all trials, the one with the median excess of the naive planner."""
    long = np.argsort(np.linalg.norm(np.diff(half.task.ends, axis=1)[:, 0], axis=1))[len(half.task.ends) // 2 :]
    means = np.nanmean(half.runs[1].excess["naive"][long], axis=1)
    return int(long[np.argsort(means)[len(long) // 2]])


def parts(half: Half, runs: Runs, trial: int) -> Parts:
    """A trial of the manifold's, under the push of some runs, in its parts."""
    planned, states = (each.motions["manifold"][trial] for each in (half.runs[0], runs))
    first, last = _rows()
    push = np.stack([planned[first], states[first]])
    return Parts(planned, planned[: first + 1], push, states[first : last + 1], states[last:])


def _rows() -> tuple[int, int]:
    """The steps at which the push is over, and at which the way back is."""
    times = np.linspace(0.0, 1.0, STEPS)
    return int(np.argmax(times >= PUSHED_AT)), int(np.argmax(times >= PUSHED_AT + RETURN))


def _follow(ax: Any, told: Parts, seen: Any) -> None:
    """All parts, as `seen` shows states (n, D)."""
    ax.plot(*seen(told.planned).T, color=ON, linewidth=1.6, linestyle="--", zorder=4)
    ax.plot(*seen(told.before).T, color=ON, linewidth=2.4, zorder=5)
    ax.plot(*_straight(seen, told.push).T, color=OFF, linewidth=2.0, zorder=5)
    ax.plot(*seen(told.back).T, color=BACK, linewidth=2.0, zorder=5)
    ax.plot(*seen(told.on).T, color=ON, linewidth=2.4, zorder=6)
    ends: dict[str, Any] = {"linestyle": "none", "marker": "o", "markeredgecolor": ON, "markeredgewidth": 1.5}
    ax.plot(*seen(told.planned[:1]).T, markersize=6.0, markerfacecolor="white", zorder=7, **ends)
    ax.plot(*seen(told.planned[-1:]).T, markersize=5.0, markerfacecolor=ON, zorder=7, **ends)
    stars: dict[str, Any] = {"linestyle": "none", "marker": "*", "color": OFF, "markersize": 10.0, "zorder": 8}
    ax.plot(*seen(told.push).T, markeredgecolor="white", markeredgewidth=0.6, **stars)


def _straight(seen: Any, push: Array) -> Array:
    """The joints go straight while the arm is pushed."""
    return seen(push[0] + np.linspace(0.0, 1.0, 30)[:, None] * (push[1] - push[0]))


def _plane(ax: Any, told: Parts) -> None:
    """The tool's way, and the arm where it starts, where it is pushed to, and where it ends."""
    turn = np.linspace(0.0, np.pi, 200)
    ax.plot(np.cos(turn), np.sin(turn), color=FAINT, linewidth=1.0)
    ax.plot([-1, 1], [0, 0], color=FAINT, linewidth=1.0)
    poses = ((told.planned[0], SOFT), (told.push[1], OFF), (told.on[0], BACK), (told.on[-1], ON))
    for pose, color in poses:
        angles = np.cumsum(pose)
        links = three_link.LINK * np.column_stack([np.cos(angles), np.sin(angles)])
        points = np.vstack([np.zeros(2), np.cumsum(links, axis=0)])
        ax.plot(*points.T, color=color, linewidth=1.6, alpha=0.35, marker="o", markersize=3.0, zorder=2)
    ax.plot(0, 0, marker="o", color=INK, markersize=5.5, zorder=3)
    _follow(ax, told, three_link.forward)
    bare(ax)


def _kuka(made: Figure, told: Parts) -> None:
    """The tool's way from above and from the side, with the arm now and then."""
    for left, (title, seen) in zip((0.01, 0.25), VIEWS.items(), strict=True):
        ax = made.add_axes((left, 0.05, 0.235, 0.35))
        motion = np.vstack([told.before, told.back, told.on])
        for index in np.linspace(0, len(motion) - 1, POSES).astype(int):
            points = np.stack([tray.arm().forward(motion[index], frame)[:3] for frame in FRAMES])[:, seen]
            ax.plot(*points.T, color=INK, linewidth=1.2, alpha=0.12 + 0.3 * index / len(motion), zorder=1)
        _follow(ax, told, lambda states, seen=seen: tray.positions(states)[:, seen])
        bare(ax)
        made.text(left + 0.015, 0.422, title, fontsize=9.5, color=SOFT)


def _joints(made: Figure, told: Parts) -> None:
    """A stripe for each joint."""
    times, (first, last) = np.linspace(0.0, 1.0, STEPS), _rows()
    height = 0.33 / tray.JOINTS
    for joint in range(tray.JOINTS):
        ax = made.add_axes((0.57, 0.415 - (joint + 1) * (height + 0.001), 0.405, 0.86 * height))
        ax.plot(times, told.planned[:, joint], color=ON, linewidth=1.2, linestyle="--")
        ax.plot(times[: first + 1], told.before[:, joint], color=ON, linewidth=1.8)
        ax.plot(times[[first, first]], told.push[:, joint], color=OFF, linewidth=1.8)
        ax.plot(times[first : last + 1], told.back[:, joint], color=BACK, linewidth=1.8)
        ax.plot(times[last:], told.on[:, joint], color=ON, linewidth=1.8)
        ax.set(xlim=(0.0, 1.0))
        ax.margins(y=0.15)
        ax.set_ylabel(f"q{'₁₂₃₄₅₆₇'[joint]}", rotation=0, labelpad=10.0, va="center")
        ax.tick_params(labelsize=7.0)
        ax.locator_params(axis="y", nbins=2)
        if joint < tray.JOINTS - 1:
            ax.set_xticklabels([])
        else:
            ax.set_xlabel("time")


def _handles() -> list[Line2D]:
    return [
        Line2D([], [], color=ON, linewidth=1.6, linestyle="--", label="as planned"),
        Line2D([], [], color=OFF, linewidth=2.0, label="pushed"),
        Line2D([], [], color=OFF, linestyle="none", marker="*", markersize=9.0, label="from and to where"),
        Line2D([], [], color=BACK, linewidth=2.0, label="back to the manifold"),
        Line2D([], [], color=ON, linewidth=2.4, label="followed, and planned anew"),
    ]
