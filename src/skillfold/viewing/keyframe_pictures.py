"""Both keyframe tasks in pictures: the scenes with robot, envelope and paths, and the paths at α 100 and 85.

As figures 5 to 8 of paper 002.
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon

from skillfold.errors import RobotError
from skillfold.experiments.keyframe_demo import Chapter, Story
from skillfold.experiments.keyframe_runs import ALPHAS
from skillfold.motion import Array
from skillfold.robots.shapes import Box
from skillfold.viewing.envelope_pictures import CHILD, PARENT, flat, legend, positions
from skillfold.viewing.style import INK, PLANS, TUNNEL, figure, save, style

COLORS = (*PLANS, "#7a3b8f")
SIZE = (1000, 760)  # pixels of a scene
CAMERA: dict[str, Any] = {"distance": 1.12, "azimuth": 152.0, "elevation": -24.0, "size": SIZE}
TOWARD = (0.37, -0.02, 0.27)
FOG = 26  # ellipsoids that an envelope is drawn by
SHOWN = 0.5  # share of the first path at which the arm is drawn
LOOKS = {"scene: table": "#f4f1ec", "scene: wine glass": "#9cc7e3", "scene: cracker box": "#d0533f"}
LOOKS |= {"scene: coffee can": "#c98b3c", "held: cherry": "#b3122f", "held: parcel": "#5b7f5a"}
VIEWS = {"from the side": (0, 2), "from above": (0, 1)}


def draw(story: Story, path: Path) -> tuple[Path, str]:
    """Write the picture; returns its path, and a note where the scenes could not be drawn.

    Raises:
        InputError: the file cannot be written.
    """
    scenes, note = _scenes(story)
    with style():
        return save(tasks(story, scenes), path), note


def tasks(story: Story, scenes: list[Any]) -> Figure:
    """A row for each task: the scene, where there is one, and the paths at each α from the side and from above."""
    left = 0.36 if scenes else 0.01
    made = figure(12.6 if scenes else 8.4, 7.4)
    width = (0.995 - left) / 2
    for row, chapter in enumerate(story.chapters):
        foot = 0.525 - 0.475 * row
        if scenes:
            ax = made.add_axes((0.005, foot, left - 0.015, 0.43))
            ax.imshow(scenes[row])
            ax.set_axis_off()
        title = f"task {row + 1}: {chapter.learnt.task.name}"
        if scenes:
            made.text(0.012, foot + 0.44, title, fontweight="bold", fontsize=10.5)
        for column, alpha in enumerate(ALPHAS):
            x = left + column * width
            made.text(
                x + 0.012,
                foot + 0.44,
                f"α = {alpha:g} %" if scenes else f"{title}, α = {alpha:g} %",
                fontweight="bold",
                fontsize=10.5,
            )
            _paths(made, chapter, alpha, (x, foot, width, 0.43))
    made.legend(handles=_legend(), loc="lower left", bbox_to_anchor=(0.005, -0.004), ncols=6, columnspacing=1.6)
    return made


def _paths(made: Figure, chapter: Chapter, alpha: float, room: tuple[float, float, float, float]) -> None:
    x, y, width, height = room
    axes = {"side": (0, 2), "above": (0, 1)} if _outward(chapter) else {"side": (1, 2), "above": (1, 0)}
    for k, seen in enumerate(axes.values()):
        ax = made.add_axes((x + 0.008, y + height * (0.5 - 0.5 * k), width - 0.016, 0.49 * height))
        envelope = chapter.learnt.envelope if alpha == 100.0 else chapter.learnt.envelope.reduced(alpha)
        flat(ax, envelope, seen)
        for shape in chapter.learnt.task.scene:
            if shape.name != "table":
                _shape(ax, shape, seen, LOOKS[f"scene: {shape.name}"])
        for path, color in zip(chapter.paths(alpha), COLORS, strict=False):
            ax.plot(*path[:, seen].T, color="white", linewidth=3.4, zorder=7)
            ax.plot(*path[:, seen].T, color=color, linewidth=2.0, zorder=8)
        ax.autoscale_view()


def _outward(chapter: Chapter) -> bool:
    """Whether the task goes away from the base rather than across."""
    away = np.abs(chapter.learnt.envelope.ends[1, :3] - chapter.learnt.envelope.ends[0, :3])
    return bool(away[0] > away[1])


def _shape(ax: Any, shape: Any, seen: tuple[int, int], color: str) -> None:
    """Outline of an upright box or cylinder along the world's axes."""
    size = shape.size if isinstance(shape, Box) else (2 * shape.radius, 2 * shape.radius, shape.length)
    middle, half = np.array(shape.pose)[list(seen)], 0.5 * np.array(size)[list(seen)]
    look: dict[str, Any] = {"facecolor": color, "alpha": 0.35, "edgecolor": color, "linewidth": 1.0, "zorder": 6}
    if not isinstance(shape, Box) and 2 not in seen:
        ax.add_patch(Circle(tuple(middle), half[0], **look))
    else:
        corners = middle + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        ax.add_patch(Polygon(corners, closed=True, **look))


def _scenes(story: Story) -> tuple[list[Any], str]:
    """A picture of each scene, none where nothing can be drawn off the screen."""
    try:
        return [scene(chapter) for chapter in story.chapters], ""
    except RobotError as error:
        return [], f"{error} The picture of the keyframe tasks has no scenes."


def scene(chapter: Chapter) -> Any:
    """The robot on its way among what stands around, the envelope as fog, the tree thin and the paths thick."""
    from skillfold.robots.rendering import View, picture
    from skillfold.robots.world import World

    task = chapter.learnt.task
    world = World(task.robot, task.scene, visual=True)
    for name, color in LOOKS.items():
        if any(world.model.geom(i).name == name for i in range(world.model.ngeom)):
            world.model.geom(name).rgba = (*rgb(color), 0.45 if "glass" in name else 1.0)
    plans = [a.plan for a in chapter.answers[100.0] if a.plan.success]
    q = plans[0].path.states[int(SHOWN * len(plans[0].path))] if plans else chapter.start
    return picture(world, q, View(TOWARD, **CAMERA), _marks(chapter))


def _marks(chapter: Chapter) -> list[Any]:
    from skillfold.robots.rendering import Mark

    means, covariances = positions(chapter.learnt.envelope, FOG)
    marks = [Mark(means[1:-1], (*rgb(TUNNEL), 0.018), shapes=covariances[1:-1])]
    marks += [Mark(means[[k]], (*rgb(c), 0.13), shapes=covariances[[k]]) for k, c in ((0, PARENT), (-1, CHILD))]
    for edge in tree_edges(chapter):
        marks.append(Mark(edge, (*rgb(INK), 0.5), 0.001))
    for path, color in zip(chapter.paths(100.0), COLORS, strict=False):
        marks.append(Mark(path[::3], (*rgb(color), 1.0), 0.0035))
    return marks


def tree_edges(chapter: Chapter) -> list[Array]:
    """Tool positions (n, 3) along each edge of the tree of the first plan, none where it was not kept."""
    tree = next((t for a in chapter.answers[100.0] if (t := a.plan.stats.get("tree")) is not None), None)
    if tree is None:
        return []
    states, parents = tree
    share = np.linspace(0.0, 1.0, 5)[:, None]
    robot = chapter.learnt.task.robot
    pairs = [(states[p], states[i]) for i, p in enumerate(parents) if p >= 0]
    return [robot.forward((1.0 - share) * a + share * b)[:, :3] for a, b in pairs]


def rgb(color: str) -> tuple[float, float, float]:
    """Red, green and blue, 0 to 1."""
    from matplotlib.colors import to_rgb

    return to_rgb(color)


def _legend() -> list[Line2D]:
    return [
        *legend(),
        Line2D([], [], color=INK, linewidth=2.0, label="paths of the tool"),
        Line2D([], [], color=INK, linewidth=0.9, alpha=0.6, label="tree"),
    ]
