"""Steps of the Nao, a picture for each of figures 18 to 21 of paper 000."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d.art3d import Line3DCollection

from skillfold.experiments.nao_stepping import Stepping, Trial
from skillfold.experiments.nao_steps import Stepper, other_side
from skillfold.experiments.nao_walk import Walk
from skillfold.manifold.graph import build_graph
from skillfold.motion import Array
from skillfold.viewing import nao_bodies as bodies
from skillfold.viewing.style import INK, OFF, ON, PLANS, SOFT, TUNNEL, figure, save, style

BOLD: dict[str, Any] = {"fontweight": "bold", "fontsize": 10.5}
NEIGHBORS = 10  # that a fit of twelve coordinates gives each sample to start with
NEW = 10  # swings of each leg
PAPER_SECONDS, PAPER_ERROR = (45.0, 1.5), 0.1  # section VII-A3 and VII-B2: optimisation and geodesic; RMSE
LEFT, RIGHT = PLANS[3], PLANS[2]  # feet
VIEWS = 6  # snapshots of the walk
DARK = "#06302e"
TIME = LinearSegmentedColormap.from_list("time", ["#9fd8d2", ON, DARK])  # of the torso's way
BOX = (3.0, 1.8, 1.7)  # edges of space, in which a step is narrow


def draw(stepping: Stepping, folder: Path) -> tuple[Path, Path, Path, Path]:
    """Write the pictures: graphs, new swings, errors and times, the walk.

    Raises:
        InputError: a file cannot be written.
    """
    shots = walking(stepping.walk)
    with style():
        return (
            save(graphs(stepping), folder / "nao_graphs.png"),
            save(swings(stepping), folder / "nao_swings.png"),
            save(compared(stepping), folder / "nao_times.png"),
            save(walked(stepping.walk, *shots), folder / "nao_walk.png"),
        )


def graphs(stepping: Stepping) -> Figure:
    """Figure 18: the neighbourhood graph of each swing leg's samples where the foot is; inset, the swings shown."""
    made = figure(12.0, 5.6)
    for column, (side, skills) in enumerate(stepping.skills.items()):
        optimiser = Stepper(side).optimiser
        samples = np.concatenate([example.swing for example in skills.examples])
        places = bodies.foot(optimiser, samples)
        edges = build_graph(samples, NEIGHBORS).edges
        ax: Any = made.add_axes((0.5 * column - 0.02, -0.06, 0.52, 0.9), projection="3d")
        ax.add_collection3d(Line3DCollection(places[edges].tolist(), colors=TUNNEL, linewidths=0.35, alpha=0.35))
        ax.plot(*places.T, linestyle="none", marker="o", markersize=2.2, color=INK, mew=0.0)
        bodies.space(ax, BOX)
        title = f"{other_side(side)} foot swings: {len(samples)} samples, {len(edges)} edges"
        made.text(0.5 * column + 0.03, 0.93, title, **BOLD)
        inset = made.add_axes((0.5 * column + 0.32, 0.68, 0.18, 0.32), projection="3d")
        for example in skills.examples:
            inset.plot(*bodies.foot(optimiser, example.swing).T, color=SOFT, linewidth=0.7)
        inset.patch.set_alpha(0.0)
        bodies.space(inset, BOX)
        _nameless(inset)
    return made


def _nameless(ax: Any) -> None:
    """Without numbers and names on its axes."""
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_ticklabels([])
        axis.set_label_text("")


def swings(stepping: Stepping) -> Figure:
    """Figure 19: new swings of both legs in space, beside the samples."""
    made = figure(12.0, 4.9)
    for column, (side, skills) in enumerate(stepping.skills.items()):
        optimiser = Stepper(side).optimiser
        mine = [trial for trial in stepping.trials if trial.example.step.side == side][:NEW]
        ax = made.add_axes((0.5 * column - 0.02, -0.1, 0.52, 1.04), projection="3d")
        shown = bodies.foot(optimiser, np.concatenate([example.swing for example in skills.examples]))
        ax.plot(*shown.T, linestyle="none", marker="o", markersize=1.8, color=SOFT, alpha=0.6, mew=0.0)
        for index, trial in enumerate(mine):
            path, color = bodies.foot(optimiser, trial.plans[0].path.states), PLANS[index % len(PLANS)]
            ax.plot(*path.T, color=color, linewidth=1.8)
            ax.plot(*path[:1].T, marker="o", color=color, markerfacecolor="white", markersize=4.5)
            ax.plot(*path[-1:].T, marker="o", color=color, markersize=4.0)
        bodies.space(ax, BOX)
        stable = sum(trial.verdicts[0].stable for trial in mine)
        title = f"{other_side(side)} foot swings: {len(mine)} new ones, {stable} of them stable"
        made.text(0.5 * column + 0.03, 0.93, title, **BOLD)
    return made


def compared(stepping: Stepping) -> Figure:
    """Figure 20: how far new steps are from optimal ones along their way, and how long each takes."""
    made = figure(12.0, 3.7)
    error, taken = made.add_axes((0.06, 0.2, 0.4, 0.62)), made.add_axes((0.66, 0.2, 0.32, 0.62))
    _along(error, stepping.trials)
    _taken(taken, stepping.trials)
    return made


def _along(ax: Any, trials: Sequence[Trial]) -> None:
    """Mean and spread of the RMSE at each state that was compared, of swing and shift in a row."""
    along = np.maximum(np.array([trial.along for trial in trials]), 1e-7)
    shares = np.linspace(0.0, 1.0, along.shape[2])
    for phase, (name, color) in enumerate((("swing", ON), ("weight shift", TUNNEL))):
        low, middle, high = np.percentile(along[:, phase], [5, 50, 95], axis=0)
        ax.fill_between(phase + shares, low, high, color=color, alpha=0.18, linewidth=0.0)
        ax.plot(phase + shares, middle, color=color, linewidth=2.2)
        ax.text(phase + 0.5, 0.04, name, transform=ax.get_xaxis_transform(), color=color, ha="center")
    ax.axhline(PAPER_ERROR, color=OFF, linewidth=1.4)
    ax.text(0.02, PAPER_ERROR * 0.8, "paper's mean", color=OFF, va="top", fontsize=9.0)
    ax.set_yscale("log")
    ax.set(xlim=(0.0, 2.0), xticks=[0.0, 1.0, 2.0], ylabel="RMSE to the optimum, rad")
    ax.set_xticklabels(["start", "landed", "shifted"])
    ax.set_title(f"{len(trials)} new steps along their way: median, and from 5 to 95 %", pad=8.0, **BOLD)


def _taken(ax: Any, trials: Sequence[Trial]) -> None:
    """Seconds of a step, each trial a dot, with the paper's."""
    seconds = [trial.seconds for trial in trials]
    rows = (
        ("optimised,\nfinite differences", [s.differencing for s in seconds], PAPER_SECONDS[0]),
        ("optimised,\nanalytic derivatives", [s.optimising for s in seconds], None),
        ("planned on the manifold", [s.planning for s in seconds], PAPER_SECONDS[1]),
    )
    for row, (_, values, paper) in enumerate(rows):
        spread = -row + np.linspace(-0.18, 0.18, len(values))
        ax.plot(values, spread, linestyle="none", marker="o", color=ON, markersize=3.5, alpha=0.7, mew=0.0)
        ax.plot([np.median(values)] * 2, [-row - 0.3, -row + 0.3], color=INK, linewidth=1.6)
        if paper is not None:
            ax.plot(paper, -row, color=OFF, marker="D", markersize=5.5)
    ax.set_xscale("log")
    ax.set_yticks([0, -1, -2], [name for name, _, _ in rows])
    ax.tick_params(axis="y", length=0, labelcolor=INK)
    ax.spines["left"].set_visible(False)
    ax.set(ylim=(-2.6, 0.6), xlabel="seconds a step; diamonds: paper")
    ax.set_title("time of a step", pad=8.0, **BOLD)


def walking(walk: Walk) -> tuple[list[Any], list[str]]:
    """Snapshots of swings in their middle, spread over the walk, and their titles."""
    chosen = np.linspace(0, len(walk.steps) - 1, min(VIEWS, len(walk.steps))).astype(int)
    found: list[Any] = []
    for step in chosen:
        states = walk.plans[step][0].path.states
        found += bodies.shots([states[len(states) // 2]], walk.steps[step].side)
    return found, [f"step {step + 1}" for step in chosen][: len(found)]


def walked(walk: Walk, found: Sequence[Any], titles: Sequence[str]) -> Figure:
    """Figure 21: places of the feet from above, the way of the torso in dynamics, and snapshots of swings."""
    high = 1.9 if found else 0.0
    low = np.min(walk.feet, axis=0) - 0.06
    extent = np.max(walk.feet, axis=0) + np.array([0.1, 0.06]) - low
    plan = min(10.6 * float(extent[1] / extent[0]), 4.2)
    whole = high + plan + 1.35
    made = figure(12.0, whole)
    foot, tall = 1.0 - (0.35 + high) / whole, (high - 0.3) / whole
    width = 1.0 / max(len(found), 1)
    axes = [made.add_axes((width * i + 0.003, foot, width - 0.006, tall)) for i in range(len(found))]
    bodies.panels(axes, found, titles)
    ax = made.add_axes((0.06, 0.55 / whole, 0.92, plan / whole))
    _feet(ax, walk)
    up = "stays up" if walk.up else "falls"
    made.text(0.008, 1.0 - 0.22 / whole, f"a walk of {len(walk.steps)} random steps, which {up}", **BOLD)
    names = ((LEFT, "left foot"), (RIGHT, "right foot"), (ON, "torso in dynamics, darker with time"))
    handles = [Line2D([], [], color=color, linewidth=2.0, label=name) for color, name in names]
    made.legend(handles=handles, loc="upper right", ncols=3, bbox_to_anchor=(0.995, (plan + 0.98) / whole))
    return made


def _feet(ax: Any, walk: Walk) -> None:
    """Soles from above, numbered, and the torso's way."""
    sides = [step.side for step in walk.steps]
    for index, (place, side) in enumerate(zip(walk.feet, [*sides, other_side(sides[-1])], strict=True)):
        left = side == "left"
        outline: Array = place + bodies.sole(1.0 if left else -1.0)
        color = LEFT if left else RIGHT
        ax.fill(*outline.T, facecolor=(color, 0.1), edgecolor=color, linewidth=1.3)
        ax.text(place[0] + 0.062, place[1], str(index), color=color, ha="center", va="center", fontsize=9.0)
    way = walk.bases[::5, :2]
    pieces = np.stack([way[:-1], way[1:]], axis=1)
    times = LineCollection(pieces.tolist(), cmap=TIME, array=np.linspace(0.0, 1.0, len(pieces)), linewidths=2.0)
    times.set_capstyle("round")
    ax.add_collection(times)
    ax.plot(*way[0], marker="o", markersize=6.0, color=ON, markerfacecolor="white", zorder=6)
    ax.plot(*way[-1], marker="o", markersize=5.0, color=DARK, zorder=6)
    ax.set_aspect("equal")
    ax.set(xlabel="x, m", ylabel="y, m")
