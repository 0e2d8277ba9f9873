"""Steps of the Nao past what they would hit: figures 22 to 24 of paper 000."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle

from skillfold.experiments.nao_around import Answer
from skillfold.experiments.nao_steps import Stepper, other_side
from skillfold.robots.rendering import View
from skillfold.robots.shapes import Sphere
from skillfold.viewing import nao_bodies as bodies
from skillfold.viewing.style import FAINT, INK, OFF, ON, SOFT, SURFACE, figure, save, style

BOLD: dict[str, Any] = {"fontweight": "bold", "fontsize": 10.5}
SHOWN = 2  # of balls, and of edges
HALF = np.array([-0.068, 0.068])  # m: of a sole, from its middle along the step
TIMES = 6  # snapshots of a step
SIDE = {"left": 110.0, "right": 250.0}  # degrees: from the side of the foot that swings


def draw(answers: Sequence[Answer], folder: Path) -> tuple[Path, Path | None]:
    """Write the pictures: ways from above and from the side; snapshots of one of them, where they can be drawn.

    Raises:
        InputError: a file cannot be written.
    """
    found = stumbling(answers)
    with style():
        return (
            save(ways(answers), folder / "nao_past.png"),
            save(snapshots(*found), folder / "nao_stumble.png") if found[0] else None,
        )


def mixed(answers: Sequence[Answer]) -> list[Answer]:
    """The first balls, then the first edges, as they were drawn."""
    balls = [answer for answer in answers if isinstance(answer.case.obstacle, Sphere)]
    edges = [answer for answer in answers if not isinstance(answer.case.obstacle, Sphere)]
    return [*balls[:SHOWN], *edges[:SHOWN]]


def ways(answers: Sequence[Answer]) -> Figure:
    """Figure 22: the plain geodesic and the way planned around, from the side above, from above below."""
    shown = mixed(answers)
    made = figure(12.0, 3.1)
    wide = 1.0 / len(shown)
    for column, answer in enumerate(shown):
        left = wide * column
        for seen, (foot, high) in enumerate(((0.53, 0.33), (0.13, 0.33))):
            ax = made.add_axes((left + 0.01, foot, wide - 0.02, high))
            _way(ax, answer, (0, 2) if seen == 0 else (0, 1))
        what = "a ball" if isinstance(answer.case.obstacle, Sphere) else "an edge"
        clear = "" if answer.clear else ", not clear"
        made.text(left + 0.02, 0.92, f"past {what}, {other_side(answer.case.side)} foot{clear}", **BOLD)
    handles = [
        Line2D([], [], color=OFF, linestyle="--", label="plain geodesic"),
        Line2D([], [], color=ON, linewidth=2.2, label="planned around"),
        Line2D([], [], color=FAINT, linewidth=2.0, label="the sole now and then"),
    ]
    made.legend(handles=handles, loc="lower right", ncols=3, bbox_to_anchor=(0.995, -0.02))
    return made


def _way(ax: Any, answer: Answer, axes: tuple[int, int]) -> None:
    """The middle of the sole in two coordinates, and the sole itself now and then."""
    optimiser, seen = Stepper(answer.case.side).optimiser, list(axes)
    plain, planned = bodies.foot(optimiser, answer.case.blocked), bodies.foot(optimiser, answer.states)
    _obstacle(ax, answer.case.obstacle, axes)
    for middle in planned[np.linspace(0, len(planned) - 1, 8).astype(int)]:
        ax.plot(middle[0] + HALF, [middle[axes[1]]] * 2, color=FAINT, linewidth=1.4, zorder=1)
    ax.plot(*plain[:, seen].T, color=OFF, linewidth=1.4, linestyle="--", zorder=4)
    ax.plot(*planned[:, seen].T, color=ON, linewidth=2.2, zorder=5)
    ends = {"linestyle": "none", "marker": "o", "color": ON, "zorder": 6}
    ax.plot(*planned[:1, seen].T, markersize=5.5, markerfacecolor="white", **ends)
    ax.plot(*planned[-1:, seen].T, markersize=4.5, **ends)
    ax.set_aspect("equal")
    ax.set(xlim=(-0.17, 0.23), xticks=[], yticks=[])
    for spine in ax.spines.values():
        spine.set_visible(False)
    if axes == (0, 2):
        ax.axhline(0.0, color=SOFT, linewidth=0.8)
        ax.set_ylim(-0.02, 0.1)
    else:
        centre = float(planned[:, 1].mean())
        ax.set_ylim(centre - 0.06, centre + 0.06)
    where = "from the side" if axes == (0, 2) else "from above"
    ax.text(0.01, 0.97, where, transform=ax.transAxes, color=SOFT, fontsize=8.5, va="top")


def _obstacle(ax: Any, shape: Any, axes: tuple[int, int]) -> None:
    look: dict[str, Any] = {"facecolor": SURFACE, "edgecolor": INK, "linewidth": 0.6, "zorder": 3, "alpha": 0.85}
    if isinstance(shape, Sphere):
        place = np.array(shape.center)[list(axes)]
        ax.add_patch(Circle((float(place[0]), float(place[1])), shape.radius, **look))
        return
    place, size = np.array(shape.pose)[list(axes)], np.array(shape.size)[list(axes)]
    ax.add_patch(Rectangle(tuple(place - size / 2), float(size[0]), float(size[1]), **look))


def stumbling(answers: Sequence[Answer]) -> tuple[list[Any], list[Any]]:
    """Snapshots of the first case: the plain geodesic, and the step planned around."""
    answer = mixed(answers)[0]
    rows = []
    for states in (answer.case.blocked, answer.plan.path.states):
        some = states[np.linspace(0, len(states) - 1, TIMES).astype(int)]
        x, y = (float(value) for value in answer.case.obstacle.placed[:2])
        view = View((x, 0.6 * y, 0.13), 0.62, SIDE[answer.case.side], -10.0, (400, 400))
        rows.append(bodies.shots(list(some), answer.case.side, [answer.case.obstacle], view))
    return rows[0], rows[1]


def snapshots(plain: Sequence[Any], planned: Sequence[Any]) -> Figure:
    """Figures 23 and 24: above, the foot goes through what stands there; below, over it."""
    made = figure(12.0, 4.75)
    titles = "the plain geodesic goes through what stands there", "the way planned around it"
    for row, (found, title) in enumerate(zip((plain, planned), titles, strict=True)):
        foot = 0.5 * (1 - row)
        for i, shot in enumerate(found):
            ax = made.add_axes((i / len(found) + 0.002, foot + 0.005, 1 / len(found) - 0.004, 0.42))
            ax.imshow(shot)
            ax.set_axis_off()
        made.text(0.008, foot + 0.445, title, **BOLD)
    return made
