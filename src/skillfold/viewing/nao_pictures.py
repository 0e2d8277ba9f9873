"""The Nao in two pictures, after figures 18 to 27 of paper 000: balance on one leg, and steps."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle

from skillfold.errors import RobotError
from skillfold.experiments import nao_walk
from skillfold.experiments.nao_around import Answer
from skillfold.experiments.nao_balance import Table, Trial
from skillfold.experiments.nao_poses import SOLE, Optimiser
from skillfold.experiments.nao_stepping import Stepping
from skillfold.experiments.nao_steps import Stepper
from skillfold.motion import Array
from skillfold.robots.shapes import Sphere
from skillfold.robots.standing import base_of
from skillfold.viewing import plots
from skillfold.viewing.style import FAINT, INK, OFF, ON, PLANS, SOFT, SURFACE, bare, figure, save, style

SHOWN = 6  # poses, steps, obstacles
SPINE = ("Torso", "head_top")
LEG = ("HipYawPitchLink", "KneePitchLink", "AnkleRollLink")
SLANT = 0.35  # of x, as it is seen from the front
MIDDLE = 0.027  # m: of a sole from its ankle
CUT = (slice(40, 440), slice(150, 490))  # rows and columns of a snapshot that are shown


def draw_balance(table: Table, path: Path) -> Path:
    """Write the picture of Table II.

    Raises:
        InputError: the file cannot be written.
    """
    shots = _shots([trial.projected for trial in table.trials[:SHOWN]])
    with style():
        return save(balance(table, shots), path)


def draw_stepping(stepping: Stepping, path: Path) -> Path:
    """Write the picture of steps.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(steps(stepping), path)


def balance(table: Table, shots: Sequence[Any]) -> Figure:
    """Where the foot goes, random states and their projections, and, where they can be drawn, the robot there."""
    rows = 3 if shots else 2
    made = figure(12.0, 2.9 * rows)
    grid = made.add_gridspec(rows, 2 * SHOWN, left=0.06, right=0.985, bottom=0.02, top=0.95, hspace=0.3, wspace=0.3)
    for column, (a, b, title) in enumerate(((0, 1, "from above"), (0, 2, "from the side"))):
        _reach(made.add_subplot(grid[0, 4 * column : 4 * column + 3]), table, (a, b), title)
    _errors(made.add_subplot(grid[0, 8:]), table)
    for i, trial in enumerate(table.trials[:SHOWN]):
        _pair(made.add_subplot(grid[1, 2 * i : 2 * i + 2]), trial)
    for i, shot in enumerate(shots):
        ax = made.add_subplot(grid[2, 2 * i : 2 * i + 2])
        ax.imshow(shot[CUT])
        ax.set_axis_off()
    return made


def steps(stepping: Stepping) -> Figure:
    """Swing paths shown and new, times, ways past obstacles, and the walk from above."""
    made = figure(12.0, 10.4)
    grid = made.add_gridspec(
        4,
        6,
        left=0.06,
        right=0.985,
        bottom=0.05,
        top=0.93,
        hspace=0.4,
        wspace=0.7,
        height_ratios=(1.2, 0.75, 0.75, 1.3),
    )
    for column, side in enumerate(stepping.skills):
        _swings(made.add_subplot(grid[0, 2 * column : 2 * column + 2]), stepping, side)
    _times(made.add_subplot(grid[0, 4:]), stepping)
    for i, answer in enumerate(_mixed(stepping.around)):
        _around(made.add_subplot(grid[1 + i // 3, 2 * (i % 3) : 2 * (i % 3) + 2]), answer)
    _walk(made.add_subplot(grid[3, :]), stepping.walk)
    handles = [
        Line2D([], [], color=OFF, linestyle="--", label="plain geodesic"),
        Line2D([], [], color=ON, linewidth=2.2, label="planned"),
        Line2D([], [], linestyle="none", marker="o", markersize=3.0, color=SOFT, label="demonstrated"),
    ]
    made.legend(handles=handles, loc="upper right", ncols=3, bbox_to_anchor=(0.99, 1.0))
    return made


def _mixed(answers: Sequence[Answer]) -> list[Answer]:
    """Balls above, edges below."""
    balls = [answer for answer in answers if isinstance(answer.case.obstacle, Sphere)]
    edges = [answer for answer in answers if not isinstance(answer.case.obstacle, Sphere)]
    return [*balls[: SHOWN // 2], *edges[: SHOWN // 2]]


def foot(optimiser: Optimiser, states: Array) -> Array:
    """Middle of the swing sole (n, 3) along states (n, 12); soles are flat and point ahead."""
    return optimiser.robot.forward(states, optimiser.robot.swing)[:, :3] + np.array([MIDDLE, 0.0, 0.0])


def _shots(poses: Sequence[Array]) -> list[Any]:
    """The robot on its left foot, nothing where nothing can be drawn off the screen."""
    from skillfold.robots.falling import Falling
    from skillfold.robots.rendering import snapshots

    robot, nao = Optimiser("left").robot, nao_walk.robot()
    whole = robot.whole(np.array(poses))
    try:
        return list(snapshots(Falling(nao, visual=True), whole, base_of(nao, whole, robot.stance)))
    except RobotError:
        return []


def _reach(ax: Any, table: Table, seen: tuple[int, int], title: str) -> None:
    """Where the swing foot is in the demonstrations, and in the projections."""
    optimiser, axes = Optimiser("left"), list(seen)
    shown = foot(optimiser, table.demonstrations)[:, axes]
    found = foot(optimiser, np.array([trial.projected for trial in table.trials]))[:, axes]
    ax.plot(*shown.T, linestyle="none", marker="o", markersize=2.0, color=SOFT, markeredgewidth=0.0)
    ax.plot(*found.T, linestyle="none", marker="o", markersize=3.6, color=ON, markeredgewidth=0.0)
    sole = np.pad(np.vstack([SOLE, SOLE[:1]]), ((0, 0), (0, 1)))[:, axes]
    ax.plot(*sole.T, color=OFF, linewidth=1.4)
    ax.set_aspect("equal")
    ax.set(title=f"swing foot {title}", xlabel="x, m", ylabel="y, m" if seen[1] == 1 else "z, m")


def _errors(ax: Any, table: Table) -> None:
    """Share of projections below an error, beside the paper's mean."""
    errors = np.sort([max(trial.error, 1e-6) for trial in table.trials])
    ax.set_xscale("log")
    ax.plot(errors, np.arange(1, len(errors) + 1) / len(errors), color=ON, linewidth=2.2, drawstyle="steps-post")
    ax.axvline(0.01, color=OFF, linewidth=1.6)
    ax.set(
        title="projections below an error; red: paper",
        xlabel="RMSE to the optimum, rad",
        ylim=(0.0, 1.04),
    )


def _pair(ax: Any, trial: Trial) -> None:
    """A random state, and what it is projected to, as skeletons from the front."""
    for q, color, width in ((trial.state, SOFT, 1.2), (trial.projected, INK, 1.8)):
        for line in skeleton(q):
            ax.plot(*line.T, color=color, linewidth=width, marker="o", markersize=2.5)
    bare(ax)
    ax.set(xlim=(-0.32, 0.32), ylim=(-0.12, 0.58))


def skeleton(q: Array) -> list[Array]:
    """Lines (n, 2) through the joints of a pose (12,) on the left foot, seen from the front, a little aside."""
    robot = Optimiser("left").robot

    def points(names: Sequence[str]) -> Array:
        places = np.array([robot.forward(q, name)[:3] for name in names])
        return np.stack([places[:, 1] + SLANT * places[:, 0], places[:, 2] + 0.3 * SLANT * places[:, 0]], axis=1)

    legs = [points(["Torso", *(side + name for name in LEG), f"{side.lower()}_sole"]) for side in "LR"]
    return [points(SPINE), *legs]


def _swings(ax: Any, stepping: Stepping, side: str) -> None:
    """Foot positions that were shown, and a few new swings, from the side."""
    optimiser = Stepper(side).optimiser
    shown = np.concatenate([example.swing for example in stepping.skills[side].examples])
    ax.plot(*foot(optimiser, shown)[:, [0, 2]].T, linestyle="none", marker="o", markersize=2.2, color=SOFT)
    mine = [trial for trial in stepping.trials if trial.example.step.side == side][: len(PLANS)]
    plots.paths(ax, [foot(optimiser, trial.plans[0].path.states)[:, [0, 2]] for trial in mine])
    ax.set(title=f"new swings, {side} foot stands", xlabel="x, m", ylabel="z, m")


def _times(ax: Any, stepping: Stepping) -> None:
    """Planning against optimising, every step a point."""
    planning, optimising = 1e3 * np.array([trial.seconds for trial in stepping.trials]).T
    ax.loglog(optimising, planning, linestyle="none", marker="o", markersize=3.5, color=ON, markeredgewidth=0.0)
    low, high = 0.7 * min(planning.min(), optimising.min()), 1.4 * max(planning.max(), optimising.max())
    ax.plot([low, high], [low, high], color=FAINT)
    ax.set(title="a step's time", xlabel="optimised, ms", ylabel="planned, ms", xlim=(low, high), ylim=(low, high))


def _around(ax: Any, answer: Answer) -> None:
    """A swing past an obstacle from the side: the sole's middle, and the sole itself now and then."""
    optimiser, shape = Stepper(answer.case.side).optimiser, answer.case.obstacle
    if isinstance(shape, Sphere):
        ax.add_patch(Circle((shape.center[0], shape.center[2]), shape.radius, color=SURFACE))
    else:
        (x, _, z), size = shape.pose[:3], shape.size
        ax.add_patch(Rectangle((x - size[0] / 2, z - size[2] / 2), size[0], size[2], color=SURFACE))
    plain, planned = foot(optimiser, answer.case.blocked), foot(optimiser, answer.states)
    ax.plot(*plain[:, [0, 2]].T, color=OFF, linewidth=1.3, linestyle="--")
    for middle in planned[np.linspace(0, len(planned) - 1, 7).astype(int)]:
        ax.plot(middle[0] + np.array([-0.068, 0.068]), [middle[2]] * 2, color=FAINT, linewidth=1.2, zorder=1)
    plots.paths(ax, [planned[:, [0, 2]]], (ON,))
    ax.axhline(0.0, color=SOFT, linewidth=0.8)
    ax.set_aspect("equal")
    ax.set(xlim=(-0.16, 0.22), ylim=(-0.025, 0.095), xticks=[], yticks=[])
    ax.set_title("past a ball" if isinstance(shape, Sphere) else "past an edge", fontsize=9.5)


def _walk(ax: Any, walk: nao_walk.Walk) -> None:
    """Places of the feet from above, and the way of the torso in dynamics."""
    sides = [step.side for step in walk.steps]
    for index, place in enumerate(walk.feet):
        left = (sides[index] if index < len(sides) else ("right" if sides[-1] == "left" else "left")) == "left"
        sole = place + np.vstack([SOLE, SOLE[:1]]) * [1.0, 1.0 if left else -1.0]
        ax.plot(*sole.T, color=PLANS[3] if left else PLANS[2], linewidth=1.4)
        ax.text(place[0] + 0.02, place[1], str(index), color=SOFT, ha="center", va="center", fontsize=8.0)
    ax.plot(*walk.bases[:, :2].T, color=ON, linewidth=1.6)
    ax.set_aspect("equal")
    up = "stays up" if walk.up else "falls"
    ax.set(title=f"a walk of {len(walk.steps)} random steps: {up}; green: the torso in dynamics", xlabel="x, m")
