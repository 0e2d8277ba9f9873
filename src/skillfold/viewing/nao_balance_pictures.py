"""The Nao on one leg, a picture for each of figures 25, 26 and 27 and of Table II of paper 000."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skillfold.experiments.nao_balance import Table
from skillfold.experiments.nao_poses import Optimiser
from skillfold.experiments.nao_stability import Verdict
from skillfold.viewing import nao_bodies as bodies
from skillfold.viewing.style import FAINT, INK, OFF, ON, SOFT, TUNNEL, bare, figure, save, style

SHOWN = 10  # poses, as in the paper
BOLD: dict[str, Any] = {"fontweight": "bold", "fontsize": 10.5}
PAPER_SECONDS = (38.35, None, 1.707, 0.0254)  # Table II
PAPER_STABLE = (48, 0, 47, 42)


def draw(table: Table, folder: Path) -> tuple[Path, Path, Path | None, Path]:
    """Write the pictures: where feet go, projections, the motion through them (where it can be drawn), Table II.

    Raises:
        InputError: a file cannot be written.
    """
    found = moving(table)
    with style():
        return (
            save(reach(table), folder / "nao_reach.png"),
            save(projections(table), folder / "nao_projections.png"),
            save(motion(*found), folder / "nao_motion.png") if found[0] else None,
            save(judged(table), folder / "nao_balance.png"),
        )


def reach(table: Table) -> Figure:
    """Figure 25: foot positions that were drawn, in space, from above and from the side."""
    made = figure(12.0, 3.7)
    optimiser = Optimiser("left")
    clouds = (
        (table.missed + np.array([bodies.MIDDLE, 0.0, 0.0]), FAINT, 1.6),
        (bodies.foot(optimiser, table.demonstrations), TUNNEL, 2.4),
        (bodies.foot(optimiser, np.array([trial.projected for trial in table.trials])), ON, 4.2),
    )
    space = made.add_axes((-0.05, -0.1, 0.48, 1.2), projection="3d")
    above, beside = made.add_axes((0.5, 0.2, 0.21, 0.66)), made.add_axes((0.78, 0.2, 0.21, 0.66))
    for ax, axes in ((space, (0, 1, 2)), (above, (0, 1)), (beside, (0, 2))):
        for points, color, size in clouds:
            ax.plot(*points[:, list(axes)].T, linestyle="none", marker="o", color=color, markersize=size, mew=0.0)
        ax.plot(*np.pad(bodies.sole(), ((0, 0), (0, 1)))[:, list(axes)].T, color=OFF, linewidth=2.0)
    bodies.space(space)
    for ax, second, title in ((above, "y", "from above"), (beside, "z", "from the side")):
        ax.set_aspect("equal")
        ax.set(xlabel="x, m", ylabel=f"{second}, m")
        ax.set_title(title, **BOLD)
    made.text(0.02, 0.93, "where the swing foot is asked to be", **BOLD)
    names = ("drawn, out of reach", "drawn and optimised", "of projected random states")
    handles = [
        Line2D([], [], linestyle="none", marker="o", color=color, markersize=5.0, mew=0.0, label=name)
        for (_, color, _), name in zip(clouds, names, strict=True)
    ]
    handles.append(Line2D([], [], color=OFF, linewidth=2.0, label="the foot that stands"))
    made.legend(handles=handles, loc="lower right", ncols=4, bbox_to_anchor=(0.99, 0.0), columnspacing=1.4)
    return made


def projections(table: Table) -> Figure:
    """Figure 26: random poses in grey, their projections in black."""
    made = figure(12.0, 5.7)
    for i, trial in enumerate(table.trials[:SHOWN]):
        ax = made.add_axes((0.2 * (i % 5) + 0.005, 0.49 - 0.48 * (i // 5), 0.19, 0.46))
        bodies.draw_skeleton(ax, trial.state, SOFT, 1.4)
        bodies.draw_skeleton(ax, trial.projected, INK, 2.4)
        bare(ax)
        ax.set(xlim=(-0.36, 0.4), ylim=(-0.19, 0.61))
        ax.text(0.04, 0.93, str(i + 1), transform=ax.transAxes, color=SOFT, fontsize=9.5)
    made.text(0.01, 0.96, "random poses (grey) and their projections onto the learnt manifold (black)", **BOLD)
    return made


def moving(table: Table) -> tuple[list[Any], list[str]]:
    """Snapshots at ten projected poses and half way to each next one, and their titles."""
    poses, titles = [], []
    for i, trial in enumerate(table.trials[:SHOWN]):
        states = trial.plan.path.states
        poses += [states[len(states) // 2], states[-1]]
        titles += [f"to {i + 1}", f"pose {i + 1}"]
    return bodies.shots(poses), titles


def motion(found: Sequence[Any], titles: Sequence[str]) -> Figure:
    """Figure 27: the geodesics through the projected poses of the picture before."""
    columns = 10 if len(found) >= 10 else max(len(found), 1)
    rows = -(-len(found) // columns)
    whole = 0.45 + 1.66 * rows
    made, high = figure(12.0, whole), 1.66 / whole
    axes = []
    for i in range(len(found)):
        left, foot = (i % columns) / columns, high * (rows - 1 - i // columns)
        axes.append(made.add_axes((left + 0.002, foot, 1.0 / columns - 0.004, 0.86 * high)))
    bodies.panels(axes, found, titles)
    made.text(0.005, 1.0 - 0.28 / whole, "the motion through these poses, geodesic by geodesic", **BOLD)
    return made


def judged(table: Table) -> Figure:
    """Table II: errors, times, and who stands, beside the paper's."""
    made = figure(12.0, 3.9)
    axes = [made.add_axes((left, 0.2, width, 0.62)) for left, width in ((0.05, 0.22), (0.405, 0.17), (0.775, 0.215))]
    _errors(axes[0], table)
    _times(axes[1], table)
    _stable(axes[2], table)
    handles = [
        Line2D([], [], color=ON, linewidth=5.0, label="here"),
        Line2D([], [], color=OFF, linewidth=0.0, marker="D", markersize=5.0, label="paper"),
        Line2D([], [], color=SOFT, linewidth=5.0, label="stable, but parts of the robot overlap"),
    ]
    made.legend(handles=handles, loc="lower right", ncols=3, bbox_to_anchor=(0.995, -0.01))
    return made


def _errors(ax: Any, table: Table) -> None:
    """Share of projections below an error, beside the paper's mean."""
    errors = np.sort([max(trial.error, 1e-6) for trial in table.trials])
    ax.set_xscale("log")
    ax.plot(errors, np.arange(1, len(errors) + 1) / len(errors), color=ON, linewidth=2.2, drawstyle="steps-post")
    mean = float(errors.mean())
    ax.axvline(mean, color=ON, linewidth=1.4, linestyle="--")
    ax.plot(0.01, 0.03, color=OFF, marker="D", markersize=5.0, clip_on=False)
    ax.text(mean, 1.06, f"mean {mean:.3f}", color=ON, fontsize=9.0, ha="center")
    ax.set(xlabel="RMSE to the optimum, rad", ylim=(0.0, 1.04))
    ax.set_title("share of projections below an error", pad=16.0, **BOLD)


def _times(ax: Any, table: Table) -> None:
    """Seconds of each call, with the paper's."""
    found = [(s.differencing, s.optimising, s.projecting, s.planning) for s in (t.seconds for t in table.trials)]
    names = ("optimisation,\nfinite differences", "optimisation,\nanalytic derivatives", "projection", "geodesic")
    middles = np.median(found, axis=0)
    for row, (seconds, paper) in enumerate(zip(middles, PAPER_SECONDS, strict=True)):
        ax.plot([1e-4, seconds], [-row, -row], color=ON, linewidth=9.0, solid_capstyle="butt")
        if paper is not None:
            ax.plot(paper, -row, color=OFF, marker="D", markersize=5.0)
    ax.set_xscale("log")
    ax.set(xlim=(1e-4, 100.0), ylim=(-3.6, 0.6), xlabel="seconds, median")
    _named(ax, names, "time of one call")


def _stable(ax: Any, table: Table) -> None:
    """What share stands by both judges, and which part of it overlaps with itself."""
    trials = table.trials
    kinds: list[tuple[str, list[Verdict], int]] = [
        ("optimised", table.shown, PAPER_STABLE[0]),
        ("random", [trial.random for trial in trials], PAPER_STABLE[1]),
    ]
    for ground, where in enumerate(("pedestal", "floor")):
        held = [pair[ground] for trial in trials for pair in trial.held]
        kinds += [
            (f"projected, {where}", [trial.verdicts[0][ground] for trial in trials], PAPER_STABLE[2]),
            (f"geodesics' poses, {where}", held, PAPER_STABLE[3]),
            (f"geodesics played, {where}", [trial.verdicts[1][ground] for trial in trials], PAPER_STABLE[3]),
        ]
    kinds += [
        ("projected, floor known", [trial.floor.verdicts[0] for trial in trials], PAPER_STABLE[2]),
        ("geodesics played, floor known", [trial.floor.verdicts[1] for trial in trials], PAPER_STABLE[3]),
    ]
    for row, (_, verdicts, paper) in enumerate(kinds):
        stable = np.mean([verdict.stable for verdict in verdicts])
        alone = np.mean([verdict.stable and not verdict.collides for verdict in verdicts])
        ax.plot([0, stable], [-row, -row], color=SOFT, linewidth=6.0, solid_capstyle="butt")
        ax.plot([0, alone], [-row, -row], color=ON, linewidth=6.0, solid_capstyle="butt")
        ax.plot(paper / 50, -row, color=OFF, marker="D", markersize=4.5, clip_on=False)
    ax.set(xlim=(0, 1.02), ylim=(-len(kinds) + 0.4, 0.6), xlabel="share that both judges call stable")
    _named(ax, [name for name, _, _ in kinds], "who stands")


def _named(ax: Any, names: Sequence[str], title: str) -> None:
    """A name on the left of each bar."""
    ax.set_yticks(-np.arange(len(names)), names)
    ax.tick_params(axis="y", length=0, labelcolor=INK, pad=7.0)
    ax.spines["left"].set_visible(False)
    ax.set_title(title, pad=16.0, **BOLD)
