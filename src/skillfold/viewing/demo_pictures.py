"""The pictures of `skillfold demo`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from skillfold.experiments.demo import PAPER_RMSE, Chapter, Story
from skillfold.viewing import arm_pictures as arms
from skillfold.viewing import plots
from skillfold.viewing.planes import levels, plane
from skillfold.viewing.style import INK, OFF, ON, PLANS, SOFT, TUNNEL, figure, save, style

DOT: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 5.5}


def draw(story: Story, folder: Path) -> list[Path]:
    """Write every picture that the story has chapters for; returns their paths."""
    drawings = [chapter for chapter in story.chapters if chapter.field is not None]
    arm = story.chapters[-1]
    with style():
        figures = {"three_link.png": three_link(arm)}
        if drawings:
            figures["handwriting.png"] = handwriting(drawings)
            figures["demo.png"] = overview(drawings[0], drawings[-1], arm)
        return [save(made, folder / name) for name, made in figures.items()]


def handwriting(chapters: Sequence[Chapter]) -> Figure:
    """A column for each skill: above, new motions in its tunnel; below, states pushed off and brought back."""
    made = figure(12.0, 6.9)
    axes = made.subplots(2, len(chapters), squeeze=False)
    made.subplots_adjust(left=0.025, right=0.995, top=0.95, bottom=0.105, wspace=0.03, hspace=0.03)
    bands = [_planes(row, chapters)[0] for row in axes]
    for (above, below), chapter in zip(axes.T, chapters, strict=True):
        plots.paths(above, chapter.paths)
        plots.projections(below, chapter.disturbed, chapter.projected)
        above.set_title(chapter.name, fontweight="bold")
    for ax, text in zip(axes[:, 0], ("new motions", "pushed off, brought back"), strict=True):
        ax.set_ylabel(text, fontsize=10.5)
    _colour_bar(made, bands[0], (0.735, 0.04, 0.25, 0.016))
    made.legend(handles=_legend(), loc="lower left", bbox_to_anchor=(0.015, -0.005), ncols=4, columnspacing=1.6)
    return made


def three_link(arm: Chapter) -> Figure:
    """The learnt surface, the same paths as motions, states brought back, and errors beside the paper's."""
    made = figure(12.0, 9.0)
    sheet = arms.sheet(arm.skill)
    spaces = [made.add_axes((0.0, y, 0.56, 0.46), projection="3d") for y in (0.505, 0.02)]
    for ax, view in zip(spaces, (arms.FACING, arms.ALONG), strict=True):
        arms.joint_space(ax, sheet, view)
    arms.learnt(spaces[0], arm, sheet)
    plots.projections(spaces[1], arm.disturbed, arm.projected, size=4.5)
    motions = made.add_axes((0.57, 0.5, 0.4, 0.46))
    arms.motions(motions, arm.paths)
    errors = made.add_axes((0.61, 0.1, 0.36, 0.32))
    arms.errors(errors, arm.errors, PAPER_RMSE)
    count = len(arm.demonstrations[0])
    titles = {
        (0.03, 0.965): f"learnt from {count} poses (dots): surface, tangents (crosses), paths",
        (0.03, 0.465): "pushed off (red), brought back (green)",
        (0.57, 0.965): "the same paths as motions",
        (0.57, 0.465): "how far from optimal they are",
    }
    _titles(made, titles)
    return made


def overview(first: Chapter, second: Chapter, arm: Chapter) -> Figure:
    """Two skills of the plane and the arm, side by side."""
    made = figure(12.0, 3.45)
    planes = [made.add_axes((left, 0.02, 0.245, 0.86)) for left in (0.005, 0.258)]
    _planes(planes, (first, second))
    for ax, chapter in zip(planes, (first, second), strict=True):
        plots.paths(ax, chapter.paths)
    space = made.add_axes((0.50, -0.02, 0.265, 0.95), projection="3d")
    sheet = arms.sheet(arm.skill)
    arms.joint_space(space, sheet, labels=False)
    arms.learnt(space, arm, sheet)
    arms.motions(made.add_axes((0.765, 0.02, 0.23, 0.86)), arm.paths)
    titles = ("learnt from seven strokes", "two ways, one skill", "a skill of three joints", "and its motions")
    _titles(made, {(x, 0.92): title for x, title in zip((0.005, 0.258, 0.525, 0.775), titles, strict=True)})
    return made


def _titles(made: Figure, titles: dict[tuple[float, float], str]) -> None:
    for place, title in titles.items():
        made.text(*place, title, fontweight="bold", fontsize=10.5)


def _planes(axes: Sequence[Any], chapters: Sequence[Chapter]) -> Any:
    """Demonstrations in their tunnels, over distance fields in the same bands, which it returns."""
    fields = [chapter.field for chapter in chapters if chapter.field is not None]
    shared = levels(fields)
    return [
        plane(ax, field, chapter.demonstrations, shared)
        for ax, chapter, field in zip(axes, chapters, fields, strict=True)
    ]


def _colour_bar(made: Figure, bands: Any, place: tuple[float, float, float, float]) -> None:
    bar = made.colorbar(bands, cax=made.add_axes(place), orientation="horizontal", ticks=bands.levels[::2])
    bar.outline.set_visible(False)  # type: ignore[operator]
    bar.ax.tick_params(length=0)
    bar.ax.set_title("distance from the learnt skill, mm", fontsize=9.5, loc="left", pad=4)


def _legend() -> list[Line2D]:
    return [
        Line2D([], [], color=SOFT, label="demonstrations"),
        Line2D([], [], color=TUNNEL, label="edge of what was demonstrated"),
        Line2D([], [], color=PLANS[0], linewidth=2.2, label="plan"),
        Line2D([], [], color=INK, markerfacecolor="white", markeredgewidth=1.5, label="new start", **DOT),
        Line2D([], [], color=INK, label="new goal", **DOT),
        Line2D([], [], color=INK, linewidth=0.8, alpha=0.6, label="projection"),
        Line2D([], [], color=OFF, label="disturbed state", **DOT),
        Line2D([], [], color=ON, label="brought back", **DOT),
    ]
