"""Sections V-A to V-C of paper 000 in three pictures: what is learnt, paths on it, and states brought back to it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skillfold.experiments.reaching import GRID_HALF, GRID_SHAPE, grid
from skillfold.experiments.reaching_shown import Learnt, Paths, Shown, beyond
from skillfold.experiments.three_link import REACHING, forward, optimal
from skillfold.motion import Array
from skillfold.viewing import plots
from skillfold.viewing.arm_pictures import half_disc, joint_space
from skillfold.viewing.style import FAINT, INK, OFF, ON, PLANS, SOFT, TUNNEL, bare, figure, save, style

VIEW, OTHER = (24.0, -62.0), (16.0, -158.0)  # degrees
DRAWN = 12  # paths of a panel
STATES = 90  # random ones of a picture
STROKE = 0.16  # rad: of a tangent
PAPER = {"inside the data": 1.8935e-4, "beyond the data": 6.84e-2}  # section V-A, rad
KINDS = {"inside the data": ON, "beyond the data": OFF}
LEARNT, USED = ((-0.06, 0.80), (-0.52, 0.52)), ((-0.06, 0.96), (-0.72, 0.72))  # m: of the plane, that is drawn


def draw(shown: Shown, folder: Path) -> tuple[Path, Path, Path]:
    """Write the pictures after figures 8 and 9, 10, and 12.

    Raises:
        InputError: a file cannot be written.
    """
    with style():
        return (
            save(reaching(shown), folder / "reaching.png"),
            save(weighted(shown), folder / "reaching_weighted.png"),
            save(projections(shown), folder / "projections.png"),
        )


def reaching(shown: Shown) -> Figure:
    """Above what is learnt, from the plane to tangents in joint space; below paths, their errors and times."""
    made = figure(12.0, 7.4)
    planes = [made.add_axes((left, low, 0.19, 0.38)) for low in (0.55, 0.055) for left in (0.01, 0.215)]
    _grid(planes[0])
    _points(planes[0], forward(shown.grid.samples), TUNNEL, 3.8)
    _graph(planes[1], shown.grid)
    for ax, paths in zip(planes[2:], (shown.inside, shown.outside), strict=True):
        _grid(ax)
        _ways(ax, paths)
    for ax, limits in zip(planes, (LEARNT, LEARNT, USED, USED), strict=True):
        _framed(ax, limits)
    _spaces(made, shown.grid)
    _errors(made.add_axes((0.495, 0.095, 0.205, 0.32)), shown)
    _times(made.add_axes((0.775, 0.095, 0.205, 0.32)), shown)
    _titles(made, 0.955, (0.01, 0.215, 0.435, 0.735), _ABOVE)
    _titles(made, 0.455, (0.01, 0.215, 0.435, 0.735), _BELOW)
    return made


_ABOVE = ("100 samples of the grid", "their neighbourhood graph", "the optimal poses", "the learnt tangents")
_BELOW = ("paths inside the data", "and beyond them", "error over distance", "time of a plan")


def weighted(shown: Shown) -> Figure:
    """Joint space thrice: samples, tangents at the kernels' centres, geodesics; the tool's plane beside each."""
    made = figure(12.0, 5.4)
    surface, learnt = half_disc(), shown.half_disc
    for index, title in enumerate(("100 samples", "graph and tangents", "geodesics")):
        space = made.add_axes((0.333 * index - 0.015, -0.05, 0.35, 0.86), projection="3d")
        plane = made.add_axes((0.333 * index + 0.155, 0.745, 0.165, 0.22))
        joint_space(space, surface, VIEW, labels=False, zoom=1.02)
        _plane(plane)
        _thing(space, plane, index, shown, learnt)
        made.text(0.333 * index + 0.012, 0.945, title, fontweight="bold", fontsize=10.5)
    return made


def projections(shown: Shown) -> Figure:
    """Random states and the states that they are brought to, from two sides."""
    made = figure(12.0, 5.6)
    off, on = shown.random[:STATES], shown.projected[:STATES]
    for left, view in ((0.0, VIEW), (0.5, OTHER)):
        ax = made.add_axes((left, 0.06, 0.48, 0.9), projection="3d")
        joint_space(ax, half_disc(), view, zoom=1.05)
        plots.projections(ax, off, on, 3.2)
    ends: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 5.0}
    handles = [
        Line2D([], [], color=OFF, label="random states", **ends),
        Line2D([], [], color=ON, label="brought to the learnt manifold", **ends),
    ]
    made.legend(handles=handles, loc="lower center", ncols=2)
    made.text(0.02, 0.945, "random states and their projections, from two sides", fontweight="bold", fontsize=10.5)
    return made


def _titles(made: Figure, height: float, lefts: Sequence[float], titles: Sequence[str]) -> None:
    for left, title in zip(lefts, titles, strict=True):
        made.text(left, height, title, fontweight="bold", fontsize=10.5)


def _grid(ax: Any) -> None:
    ax.plot(*grid().T, linestyle="none", marker="o", color=FAINT, markersize=1.6, markeredgewidth=0.0, zorder=0)


def _framed(ax: Any, limits: tuple[tuple[float, float], tuple[float, float]]) -> None:
    """The arm's base, and a piece of the plane."""
    ax.plot(0, 0, marker="o", color=INK, markersize=5.0, zorder=7)
    bare(ax)
    ax.set(xlim=limits[0], ylim=limits[1])


def _points(ax: Any, states: Array, color: str, size: float) -> None:
    ax.plot(*states.T, linestyle="none", marker="o", color=color, markersize=size, markeredgewidth=0.0, zorder=3)


def _graph(ax: Any, learnt: Learnt, size: float = 3.0) -> None:
    states, edges = learnt.graph
    places = forward(states)
    ax.add_collection(LineCollection(list(places[edges]), colors=SOFT, linewidths=0.7, zorder=2))
    _points(ax, places, TUNNEL, size)


def _ways(ax: Any, paths: Paths, size: float = 1.0) -> None:
    plots.paths(ax, [forward(states) for states in paths.states[:DRAWN]], PLANS, 1.5 * size)
    for line in ax.lines:
        line.set_markersize(min(line.get_markersize(), 4.5 * size))


def _spaces(made: Figure, learnt: Learnt) -> None:
    """Joint space of section V-A: the truth with the samples, and the learnt tangents at poses of the grid."""
    truth = optimal(grid(), REACHING).reshape(*GRID_SHAPE, 3)
    first, second = (made.add_axes((left, 0.48, 0.3, 0.5), projection="3d") for left in (0.42, 0.71))
    for ax in (first, second):
        joint_space(ax, truth, labels=False)
    _points(first, learnt.samples, TUNNEL, 3.0)
    states = truth[1::3, 1::3].reshape(-1, 3)
    plots.tangents(second, states, learnt.skill.tangent(states), 0.12)


def _thing(space: Any, plane: Any, index: int, shown: Shown, learnt: Learnt) -> None:
    """Samples; the graph and tangents; or geodesics, in joint space and in the plane."""
    if index == 0:
        _points(space, learnt.samples, INK, 2.8)
        _points(plane, forward(learnt.samples), INK, 2.2)
    elif index == 1:
        plots.tangents(space, learnt.centres, learnt.skill.tangent(learnt.centres), STROKE)
        _graph(plane, learnt, 1.6)
    else:
        plots.paths(space, shown.geodesics.states[:DRAWN], PLANS, 1.8)
        _ways(plane, shown.geodesics, 0.6)


def _plane(ax: Any) -> None:
    """The upper half of what the tool reaches."""
    turn = np.linspace(0.0, np.pi, 200)
    ax.plot(np.cos(turn), np.sin(turn), color=FAINT, linewidth=1.0)
    ax.plot([-1, 1], [0, 0], color=FAINT, linewidth=1.0)
    ax.plot(0, 0, marker="o", color=INK, markersize=3.0)
    bare(ax)
    ax.set(xlim=(-1.05, 1.05), ylim=(-0.12, 1.05))


def _errors(ax: Any, shown: Shown) -> None:
    """Every state's error over its tool's distance from the grid's edge, and the paper's means."""
    ax.set_yscale("log")
    pieces = {"inside the data": shown.inside, "beyond the data": shown.outside}
    for (name, paths), color in zip(pieces.items(), KINDS.values(), strict=True):
        away = np.concatenate([beyond(forward(states[1:-1])) for states in paths.states])
        errors = np.concatenate(paths.errors)
        ax.plot(
            away, errors, linestyle="none", marker="o", color=color, markersize=1.6, markeredgewidth=0, alpha=0.35
        )
        ax.axhline(PAPER[name], color=color, linewidth=1.0, linestyle="--")
        ax.text(-float(GRID_HALF.min()), 1.25 * PAPER[name], f"paper, {name}", color=color, fontsize=8.0)
    ax.axvline(0.0, color=SOFT, linewidth=0.8, linestyle=":")
    ax.set(xlabel="m outside the grid", ylabel="RMSE of a state, rad", ylim=(1e-8, 0.3))


def _times(ax: Any, shown: Shown) -> None:
    """Share of plans done in so many milliseconds, inside and beyond."""
    for paths, (name, color) in zip((shown.inside, shown.outside), KINDS.items(), strict=True):
        times = 1e3 * np.sort(paths.seconds)
        shares = np.arange(1, len(times) + 1) / len(times)
        ax.plot(times, shares, color=color, linewidth=2.0, drawstyle="steps-post", label=name)
    ax.set(ylim=(0.0, 1.04), xlim=(0.0, None), xlabel="ms", ylabel="share of plans")
    ax.legend(loc="lower right", fontsize=8.5)
