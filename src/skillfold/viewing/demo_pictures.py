"""The pictures of `skillfold demo`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.ndimage import zoom

from skillfold.experiments.demo import FINE, PAPER_RMSE, Chapter, Story
from skillfold.experiments.reaching import GRID_SHAPE, grid
from skillfold.experiments.three_link import LINK, REACHING, forward, optimal
from skillfold.motion import Array
from skillfold.viewing import plots
from skillfold.viewing.style import FAINT, INK, OFF, ON, PLANS, SOFT, SURFACE, TUNNEL, bare, figure, save, style

SMOOTH = 4  # finer than the grid of the field, for its bands
BANDS = 9
SHOWN = 4  # paths of the arm
VIEW = (22.0, -58.0)  # degrees


def draw(story: Story, folder: Path) -> list[Path]:
    """Write every picture that the story has chapters for; returns their paths."""
    drawings = [chapter for chapter in story.chapters if chapter.field is not None]
    arm = story.chapters[-1]
    with style():
        written = [save(handwriting(drawings), folder / "handwriting.png")] if drawings else []
        written.append(save(three_link(arm), folder / "three_link.png"))
        if drawings:
            written.append(save(overview([drawings[0], drawings[-1]], arm), folder / "demo.png"))
    return written


def handwriting(chapters: Sequence[Chapter]) -> Figure:
    """A column for each skill: above, plans in its tunnel; below, its tangents and states brought back."""
    made = figure(12.0, 6.5)
    axes = made.subplots(2, len(chapters), squeeze=False)
    made.subplots_adjust(left=0.03, right=0.99, top=0.94, bottom=0.13, wspace=0.04, hspace=0.06)
    levels = _levels(chapters)
    bands = None
    for column, chapter in zip(axes.T, chapters, strict=True):
        bands = _plane(column[0], chapter, levels)
        plots.paths(column[0], _paths(chapter))
        _plane(column[1], chapter, levels)
        _field_of_tangents(column[1], chapter)
        plots.projections(column[1], chapter.disturbed, chapter.projected)
        column[0].set_title(chapter.name, fontweight="bold")
    for ax, text in zip(axes[:, 0], ("new motions", "pushed off and brought back"), strict=True):
        ax.set_ylabel(text)
    _colour_bar(made, bands, [0.70, 0.055, 0.26, 0.018])
    made.legend(handles=_legend(), loc="lower left", bbox_to_anchor=(0.02, 0.0), ncols=4, columnspacing=1.6)
    return made


def three_link(arm: Chapter) -> Figure:
    """The learnt surface, the same paths as motions, states brought back, and errors beside the paper's."""
    made = figure(12.0, 9.6)
    plans = _paths(arm)[:SHOWN]
    sheet = _sheet(arm)
    spaces = [made.add_axes(place, projection="3d") for place in ([0.0, 0.5, 0.5, 0.46], [0.0, 0.0, 0.5, 0.46])]
    for ax in spaces:
        _space(ax, sheet)
    _learnt(spaces[0], arm, plans)
    plots.projections(spaces[1], arm.disturbed, arm.projected)
    _arms(made.add_axes((0.56, 0.53, 0.42, 0.41)), plans)
    _errors(made.add_axes((0.60, 0.09, 0.36, 0.33)), arm.errors)
    return made


def overview(chapters: Sequence[Chapter], arm: Chapter) -> Figure:
    """Skills of the plane and the arm side by side."""
    made = figure(12.0, 3.9)
    return made


def _plane(ax: Any, chapter: Chapter, levels: Array) -> Any:
    field = chapter.field
    assert field is not None
    x, y = _finer(field.x, SMOOTH), _finer(field.y, SMOOTH)
    bands = plots.distance_field(ax, x, y, np.maximum(zoom(field.distance, SMOOTH, order=1), 0.0), levels)
    plots.tunnel(ax, _finer(field.x, FINE), _finer(field.y, FINE), field.inside)
    plots.demonstrations(ax, chapter.demonstrations)
    bare(ax)
    return bands


def _finer(values: Array, times: int) -> Array:
    return np.linspace(values[0], values[-1], times * len(values))


def _levels(chapters: Sequence[Chapter]) -> Array:
    """Bands that all chapters share, up to a distance that most states of their fields stay below."""
    largest = np.quantile(np.concatenate([c.field.distance.ravel() for c in chapters if c.field]), 0.95)
    return np.linspace(0.0, np.ceil(largest / 2) * 2, BANDS)


def _paths(chapter: Chapter) -> list[Array]:
    return [plan.path.states for plan in chapter.plans if plan.success]


def _field_of_tangents(ax: Any, chapter: Chapter) -> None:
    states = chapter.skill.sample(60, 1)
    field = chapter.field
    assert field is not None
    plots.tangents(ax, states, chapter.skill.tangent(states), 0.05 * float(np.ptp(field.x)))


def _colour_bar(made: Figure, bands: Any, place: list[float]) -> None:
    bar = made.colorbar(bands, cax=made.add_axes(tuple(place)), orientation="horizontal")
    bar.outline.set_visible(False)
    bar.ax.tick_params(length=0)
    bar.ax.set_title("distance from the learnt skill, mm", fontsize=9.5, loc="left", pad=4)


def _legend() -> list[Line2D]:
    dot = {"linestyle": "none", "marker": "o", "markersize": 5}
    return [
        Line2D([], [], color=SOFT, label="demonstrations"),
        Line2D([], [], color=TUNNEL, label="edge of what was demonstrated"),
        Line2D([], [], color=PLANS[0], linewidth=2.2, label="plan"),
        Line2D([], [], color=INK, markerfacecolor="white", label="new start", **dot),
        Line2D([], [], color=INK, label="new goal", **dot),
        Line2D([], [], color=ON, linewidth=1.6, label="learnt tangent"),
        Line2D([], [], color=OFF, label="disturbed state", **dot),
        Line2D([], [], color=ON, label="its projection", **dot),
    ]


def _sheet(arm: Chapter) -> Array:
    """The learnt surface over the paper's grid of positions, (m, n, 3)."""
    return arm.skill.project(optimal(grid(), REACHING)).reshape(*GRID_SHAPE, 3)


def _space(ax: Any, sheet: Array) -> None:
    """Joint space with the learnt surface in it."""
    plots.surface(ax, sheet, SURFACE, 0.45)
    ax.computed_zorder = False
    ax.set_box_aspect(np.ptp(sheet.reshape(-1, 3), axis=0), zoom=1.05)
    ax.view_init(*VIEW)
    for axis, name in zip((ax.xaxis, ax.yaxis, ax.zaxis), ("q₁", "q₂", "q₃"), strict=True):
        axis.set_pane_color("white")
        axis.line.set_color(FAINT)
        axis._axinfo["grid"].update(color=FAINT, linewidth=0.5)
        axis.set_major_locator(_locator())
        axis.label.set_text(f"{name}, rad")


def _locator() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(4)


def _learnt(ax: Any, arm: Chapter, plans: list[Array]) -> None:
    plots.samples(ax, arm.demonstrations[0])
    states = arm.skill.sample(40, 1)
    plots.tangents(ax, states, arm.skill.tangent(states), 0.12)
    plots.paths(ax, plans)
    ax.set_title("the skill in joint space: 100 samples, tangents, geodesics")


def _arms(ax: Any, plans: list[Array]) -> None:
    """Poses along each path, faint at the start, and the way of the tool."""
    positions = grid()
    ax.plot(*positions.T, linestyle="none", marker=".", color=FAINT, markersize=2.0, zorder=0)
    for path, color in zip(plans, PLANS, strict=False):
        for index in np.linspace(0, len(path) - 1, 6).astype(int):
            ax.plot(
                *_links(path[index]).T, color=color, linewidth=1.4, alpha=0.12 + 0.3 * index / len(path), zorder=2
            )
    plots.paths(ax, [forward(path) for path in plans])
    bare(ax)


def _links(joints: Array) -> Array:
    """Base, both middle joints and tool of one pose, (4, 2)."""
    angles = np.cumsum(joints)
    steps = LINK * np.column_stack([np.cos(angles), np.sin(angles)])
    return np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])


def _errors(ax: Any, errors: Array) -> None:
    ordered = np.sort(errors)
    ax.set_xscale("log")
    ax.step(ordered, np.arange(1, len(ordered) + 1) / len(ordered), where="post", color=ON, linewidth=2.0)
    ax.axvline(PAPER_RMSE, color=OFF, linewidth=1.2)
    ax.set_xlabel("error of a path against the optimal poses, rad")
    ax.set_ylabel("share of paths")
