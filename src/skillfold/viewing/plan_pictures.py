"""A plan in one picture: where it leads, its coordinates beside the demonstrations, and how well it holds."""

from collections.abc import Iterator
from math import ceil
from os import PathLike
from pathlib import Path as File
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from skillfold.errors import InputError, RobotError
from skillfold.experiments.demo import distance_field, square
from skillfold.manifold.inputs import check_obstacles
from skillfold.motion import Array, Plan
from skillfold.planning.point_obstacles import FORBIDDEN, PointObstacles
from skillfold.viewing import plots
from skillfold.viewing.planes import levels, plane
from skillfold.viewing.style import FAINT, INK, OFF, ON, PLANS, SOFT, figure, save, style

KINDS = (".png", ".svg", ".pdf")
COLUMNS = 4  # of curves
WIDTH, SHOT, PLANE, CURVE, HEAD = (
    12.0,
    2.35,
    4.6,
    1.75,
    0.5,
)  # inches: of all; heights of what stands below each other
POSES = 4  # of a robot along the plan
COLOR = PLANS[1]
TRACE = (0.043, 0.478, 0.459, 0.9)  # the same, of a line in a scene
LONGEST = 160  # characters of the reason
STILL = 0.05  # of the largest range of a coordinate, that is shown of each


class Curve(NamedTuple):
    """Numbers along a plan.

    Attributes:
        title: what they are.
        values: (n,) of the plan's states.
        shown: the same of the demonstrations, each (m,).
        limit: what they should keep to; None where there is nothing.
        below: whether they should keep below the limit.
        least: that is shown of the numbers' range: less of it is rounding.
    """

    title: str
    values: Array
    shown: tuple[Array, ...] = ()
    limit: float | None = None
    below: bool = True
    least: float = 0.0


def draw_plan(skill: Any, plan: Plan, file: str | PathLike[str], obstacles: Any = None) -> File:
    """Draw a plan and write the picture; one that failed is drawn as it is, with the reason.

    Args:
        skill: that it was planned on, a `SkillManifold` or a `KeyframeSkill`.
        plan: to draw.
        file: to write; its suffix tells the kind: .png, .svg, .pdf.
        obstacles: that it was planned among; a robot's are drawn with the robot.

    Raises:
        InputError: the file cannot be written or is of another kind, or obstacles that are none.
    """
    path = File(file)
    if path.suffix.lower() not in KINDS:
        raise InputError(f"{path}: ends in {path.suffix or 'nothing'}; possible: {', '.join(KINDS)}.")
    if obstacles is not None:
        check_obstacles(obstacles, plan.path.states.shape[1])
    with style():
        return save(picture(skill, plan, obstacles), path)


def picture(skill: Any, plan: Plan, obstacles: Any = None) -> Figure:
    """The same as a figure."""
    demonstrations, curves = shown_of(skill), list(along(skill, plan, obstacles))
    shots, note = _shots(plan, obstacles)
    flat = not shots and plan.path.states.shape[1] in (2, 3) and hasattr(skill, "distance")
    top = SHOT if shots else PLANE if flat else 0.0
    rows = ceil(len(curves) / COLUMNS)
    made = figure(WIDTH, HEAD + top + CURVE * rows)
    height = made.get_figheight()
    _head(made, plan, note)
    for i, shot in enumerate(shots):
        ax = made.add_axes((i / POSES, 1.0 - (HEAD + SHOT) / height, 0.99 / POSES, 0.97 * SHOT / height))
        ax.imshow(shot)
        ax.set_axis_off()
    if flat:
        _place(
            made, (0.02, 1.0 - (HEAD + PLANE) / height, 0.96, PLANE / height), skill, plan, obstacles, demonstrations
        )
    for i, curve in enumerate(curves):
        row, column = divmod(i, COLUMNS)
        foot = height - HEAD - top - CURVE * (row + 1)
        box = (0.045 + 0.245 * column, (foot + 0.45) / height, 0.195, (CURVE - 0.8) / height)
        ax = made.add_axes(box)
        _curve(ax, curve, phases_of(plan))
        if i == (rows - 1) * COLUMNS:
            ax.set_xlabel("share of the way", fontsize=8.5)
    return made


def shown_of(skill: Any) -> tuple[Array, ...]:
    """Demonstrations (m, D) that a skill knows whole, read at the same phases; none of others."""
    route = getattr(skill, "route", None)
    return () if route is None else tuple(route.curves * route.scale + route.centre)


def phases_of(plan: Plan) -> tuple[float, float]:
    """Where along whole demonstrations a plan begins and ends; 0 and 1 where it tells nothing else."""
    return float(plan.stats.get("start_phase", 0.0)), float(plan.stats.get("goal_phase", 1.0))


def along(skill: Any, plan: Plan, obstacles: Any) -> Iterator[Curve]:
    """Every coordinate, then how far the plan lies from what it should hold and keep clear of."""
    states, demonstrations = plan.path.states, shown_of(skill)
    names = plan.path.names or tuple(f"x{c}" for c in range(states.shape[1]))
    least = STILL * float(np.ptp(states, axis=0).max())
    for c, name in enumerate(names):
        yield Curve(name, states[:, c], tuple(shown[:, c] for shown in demonstrations), least=least)
    if hasattr(skill, "distance"):
        yield Curve("distance from the manifold; tolerance", skill.distance(states), limit=skill.tolerance)
    if obstacles is not None:
        yield Curve("clearance; margin", np.asarray(obstacles.clearance(states)), limit=obstacles.margin, below=False)


def _head(made: Figure, plan: Plan, note: str) -> None:
    text = plan.reason if len(plan.reason) <= LONGEST else f"{plan.reason[:LONGEST]} …"
    y = 1.0 - 0.22 / made.get_figheight()
    verdict = "plan" if plan.success else "no plan"
    made.text(0.012, y, verdict, color=ON if plan.success else OFF, fontweight="bold", fontsize=10.5)
    made.text(0.075, y, text, color=INK, fontsize=9.0)
    if note:
        made.text(0.075, y - 0.2 / made.get_figheight(), note[:LONGEST], color=SOFT, fontsize=8.0)


def _shots(plan: Plan, obstacles: Any) -> tuple[list[Any], str]:
    """The robot at a few states of the plan, in its scene; or none, and why they could not be drawn."""
    robot = getattr(obstacles, "robot", None)
    if robot is None or robot.floating:
        return [], ""
    from skillfold.robots.rendering import Mark, pictures
    from skillfold.robots.world import World

    states = plan.path.states
    chosen = states[np.linspace(0, len(states) - 1, POSES).round().astype(int)]
    trace = Mark(robot.forward(states)[:, :3], TRACE, 0.004)
    time = 0.0 if obstacles.time is None else obstacles.time
    try:
        world = World(robot, obstacles.scene, visual=True)
        nothing = np.empty((POSES, 0, 7))
        return list(pictures(world, np.full(POSES, time), chosen, nothing, marks=[[trace]] * POSES)), ""
    except RobotError as error:
        return [], str(error)


def _place(
    made: Figure, box: tuple[float, float, float, float], skill: Any, plan: Plan, obstacles: Any, shown: Any
) -> None:
    """A plan of two or three coordinates where it is, among what the skill was learnt from."""
    states, samples = plan.path.states, np.vstack(shown) if shown else skill.sample(500)
    points, radius = _balls(obstacles, states.shape[1])
    if states.shape[1] == 2:
        ax = made.add_axes(box)
        field = distance_field(skill, *square(np.vstack([samples, states])))
        plane(ax, field, shown, levels([field]))
        for point in points:
            ax.add_patch(Circle(tuple(point), radius, color=OFF, alpha=0.35, linewidth=0, zorder=4))
    else:
        ax = made.add_axes(box, projection="3d")
        plots.demonstrations(ax, shown)
        ax.plot(*points.T, linestyle="none", marker="o", color=OFF, markersize=4.0, alpha=0.5)
        ax.set_aspect("equal")
    if not shown:
        plots.samples(ax, samples)
    plots.paths(ax, [states], (COLOR,))


def _balls(obstacles: Any, dims: int) -> tuple[Array, float]:
    """Centres (n, D) and radius of what no path may enter, where obstacles are such; else none."""
    if isinstance(obstacles, PointObstacles):
        return obstacles.points, FORBIDDEN * obstacles.reach
    return np.empty((0, dims)), 0.0


def _curve(ax: Any, curve: Curve, phases: tuple[float, float]) -> None:
    for values in curve.shown:
        ax.plot(np.linspace(0.0, 1.0, len(values)), values, color=SOFT, linewidth=0.8, alpha=0.7)
    ax.plot(np.linspace(*phases, len(curve.values)), curve.values, color=COLOR, linewidth=2.0)
    if curve.limit is not None:
        ax.axhline(curve.limit, color=OFF, linewidth=0.9, linestyle="--")
        most = max(1.25 * curve.limit, 1.1 * float(curve.values.max()))
        ax.set_ylim(min(0.0, 1.1 * float(curve.values.min())), most if curve.below else None)
    low, high = ax.get_ylim()
    if high - low < curve.least:
        ax.set_ylim(0.5 * (low + high - curve.least), 0.5 * (low + high + curve.least))
    ax.set_xlim(0.0, 1.0)
    ax.set_title(curve.title, fontsize=9.5, loc="left")
    ax.grid(axis="y", color=FAINT, linewidth=0.5)
