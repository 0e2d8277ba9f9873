"""What pictures of the Nao share: its skeleton, its feet, space around it, and snapshots drawn by MuJoCo."""

from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from skillfold.errors import RobotError
from skillfold.experiments.nao_poses import SOLE, Optimiser
from skillfold.experiments.nao_walk import robot as whole_robot
from skillfold.motion import Array
from skillfold.robots.poses import turn
from skillfold.robots.standing import CHAIN, base_of
from skillfold.viewing.envelope_pictures import view
from skillfold.viewing.style import FAINT

MIDDLE = 0.027  # m: of a sole from its ankle
LEG = ("HipYawPitchLink", "KneePitchLink", "AnkleRollLink")
ARM = ("ShoulderPitchLink", "ElbowYawLink")
ELEVATION, AZIMUTH = 12.0, 38.0  # degrees: whence skeletons are seen, from its front and its left
CUT = (slice(30, 450), slice(155, 485))  # rows and columns of a snapshot from the front that are shown
SWINGING, STANDING, THERE = (0.043, 0.478, 0.459), (0.42, 0.45, 0.49), (0.82, 0.29, 0.36)  # legs; obstacles


def foot(optimiser: Optimiser, states: Array) -> Array:
    """Middle of the swing sole (n, 3) along states (n, 12); soles are flat and point ahead."""
    return optimiser.robot.forward(states, optimiser.robot.swing)[..., :3] + np.array([MIDDLE, 0.0, 0.0])


def sole(mirror: float = 1.0) -> Array:
    """Closed outline (5, 2) of a sole about its ankle; mirrored for the right one."""
    return np.vstack([SOLE, SOLE[:1]]) * [1.0, mirror]


@cache
def plane() -> Array:
    """(2, 3) of the view of skeletons."""
    return view(ELEVATION, AZIMUTH)


def skeleton(q: Array) -> list[Array]:
    """Lines (n, 2) of a pose (12,) on the left foot: spine, legs and arms from the torso on, then both soles."""
    robot = Optimiser("left").robot

    def points(names: Sequence[str]) -> Array:
        return np.array([robot.forward(q, name)[:3] for name in names])

    lines = [points(["Torso", "head_top"])]
    lines += [points(["Torso", *(side + name for name in LEG), f"{side.lower()}_sole"]) for side in "LR"]
    lines += [points([*(side + name for name in ARM), f"{side.lower()}_hand"]) for side in "LR"]
    lines[3:] = [np.vstack([points(["head_top"])[:1] * 0.35 + points(["Torso"]) * 0.65, arm]) for arm in lines[3:]]
    return [line @ plane().T for line in [*lines, *(_outline(robot, q, side) for side in "LR")]]


def _outline(robot: Any, q: Array, side: str) -> Array:
    """Closed outline (5, 3) of a sole in the world."""
    pose = robot.forward(q, f"{side.lower()}_sole")
    flat = np.pad(sole(1.0 if side == "L" else -1.0), ((0, 0), (0, 1)))
    return pose[:3] + turn(np.tile(pose[3:], (len(flat), 1)), flat)


def draw_skeleton(ax: Any, q: Array, color: str, width: float) -> None:
    """Bones with round joints, and both soles."""
    *bones, left, right = skeleton(q)
    for line in bones:
        ax.plot(*line.T, color=color, linewidth=width, marker="o", markersize=width + 1.4, markeredgewidth=0.0)
    for outline in (left, right):
        ax.fill(*outline.T, facecolor=color, alpha=0.25, edgecolor=color, linewidth=0.8)


def space(ax: Any, box: tuple[float, float, float] | None = None, ticks: tuple[int, int, int] = (4, 3, 3)) -> None:
    """Three-dimensional axes as quiet as the others: white walls, thin lines, few ticks.

    Args:
        ax: of any figure.
        box: how long its edges are drawn; left out, as the data are.
        ticks: at most, along each axis.
    """
    ax.view_init(22.0, -58.0)
    ax.set_aspect("equal") if box is None else ax.set_box_aspect(box)
    for axis, name, count in zip((ax.xaxis, ax.yaxis, ax.zaxis), "xyz", ticks, strict=True):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.line.set_color(FAINT)
        axis._axinfo["grid"].update(color=FAINT, linewidth=0.5)
        axis.set_major_locator(MaxNLocator(count))
        axis.set_label_text(f"{name}, m", fontsize=8.5)
        axis.labelpad = -1.0 if name == "y" else -4.0
        axis.set_tick_params(labelsize=7.5, pad=-1.0)


def shots(poses: Sequence[Array], side: str = "left", scene: Any = None, view: Any = None) -> list[Any]:
    """The robot on one foot at poses (12,), cut to what matters; none where nothing can be drawn off the screen.

    Args:
        poses: one for each picture.
        side: of the stance foot.
        scene: what stands around.
        view: a `View`, whose whole picture is shown; left out, from the robot's front.
    """
    from skillfold.robots.falling import Falling
    from skillfold.robots.rendering import snapshots

    standing = Optimiser(side).robot
    whole = standing.whole(np.array(poses))
    bases = base_of(whole_robot(), whole, standing.stance)
    try:
        floor = Falling(whole_robot(), scene, visual=True)
        found = list(snapshots(floor, whole, bases, view, _paint(side, scene or ())))
    except RobotError:
        return []
    return found if view else [shot[CUT] for shot in found]


def _paint(side: str, scene: Iterable[Any]) -> dict[str, tuple[float, float, float]]:
    """One colour for the leg that swings, one for the leg that stands, one for what stands around."""
    stance = "L" if side == "left" else "R"
    legs = {f"{leg}{name}Link": STANDING if leg == stance else SWINGING for leg in "LR" for name in CHAIN}
    return {**legs, **{shape.name: THERE for shape in scene}}


def panels(axes: Sequence[Any], found: Sequence[Any], titles: Sequence[str]) -> None:
    """A snapshot on each of the axes, with a small title."""
    for ax, shot, title in zip(axes, found, titles, strict=True):
        ax.imshow(shot)
        ax.set_axis_off()
        ax.set_title(title, fontsize=9.0, pad=3.0)
