"""Planning cases for the arm that carries a tray past boxes it was never shown.

In every case both ends are clear, the optimal poses over the straight way run into a box, and a path of optimal
poses is known that stays clear. "Past" has a box in the way and some beside it; "hard" has a low wall across the
way with a tall part, and boxes besides. The planner has no part in making them. Metres and radians.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from skillfold.experiments import tray
from skillfold.experiments.oracle import Oracle, length
from skillfold.motion import Array

if TYPE_CHECKING:
    from skillfold.robots.obstacles import Obstacles
    from skillfold.robots.robot import Robot
    from skillfold.robots.scene import Scene
    from skillfold.robots.shapes import Box

GRID = (0.05, np.radians(6.0), 0.05)  # of radius, azimuth and height
NEIGHBOURS = 3**0.5  # grid steps: 26 directions
LONGEST_EDGE, SPACING = 0.9, 0.02  # rad
CLEAR = 0.02  # m that the known path keeps; ends keep twice that
DEEP = 0.02  # m that the straight way runs into a box
APART = 0.5  # m between start and goal at least
PAIRS = 32  # of ends that are drawn at a time
MIDDLE = (0.35, 0.65)  # of the straight way: where the box is
BOX, BESIDE = (0.08, 0.30), (0.06, 0.20)  # edges of boxes
LOW, TALL = (0.45, 0.60), (0.85, 1.10)  # heights of the hard wall's parts


@dataclass(frozen=True)
class SceneCase:
    """A planning case that can be solved.

    Attributes:
        start, goal: (7,) optimal poses.
        scene: the boxes.
        oracle: (n, 7) optimal poses from start to goal, clear of them.
    """

    start: Array
    goal: Array
    scene: "Scene"
    oracle: Array

    @property
    def length(self) -> float:
        """Of the oracle's path, rad."""
        return length(self.oracle)


Boxes = Callable[[np.random.Generator, Array], "list[Box]"]
"""Boxes in the way of tool positions (n, 3)."""


def past_boxes(
    count: int, rng: np.random.Generator, weight: float = tray.LEVEL_WEIGHT, robot: "Robot | None" = None
) -> list[SceneCase]:
    """Cases with a box in the way and up to three beside it; `robot` is the arm, perhaps with a tray."""
    return _cases(count, rng, weight, _box_and_more, robot or tray.arm())


def hard_cases(count: int, rng: np.random.Generator, weight: float = tray.LEVEL_WEIGHT) -> list[SceneCase]:
    """Cases with a wall, low with a tall part, and two or three boxes."""
    return _cases(count, rng, weight, _wall_and_more, tray.arm())


@cache
def oracle(weight: float) -> Oracle:
    """Optimal poses over a grid of the workspace."""
    ends = (tray.RADIUS, (-tray.AZIMUTH, tray.AZIMUTH), tray.HEIGHT)
    axes = [np.arange(low, high + 1e-9, step) for (low, high), step in zip(ends, GRID, strict=True)]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    lattice = (places - places[0]) / GRID
    places = np.column_stack([places[:, 0] * f(places[:, 1]) for f in (np.cos, np.sin)] + [places[:, 2]])
    inside = tray.in_workspace(places)
    lattice, poses = lattice[inside], tray.optimum(places[inside], weight)
    poses[~tray.inside_limits(poses)] = np.nan
    return Oracle.build(lattice, poses, NEIGHBOURS, LONGEST_EDGE, partial(tray.levelled, weight=weight), SPACING)


def _cases(count: int, rng: np.random.Generator, weight: float, boxes: Boxes, robot: "Robot") -> list[SceneCase]:
    cases: list[SceneCase] = []
    while len(cases) < count:
        pairs = tray.tray_poses(2 * PAIRS, rng, weight).reshape(PAIRS, 2, -1)
        far = np.linalg.norm(np.diff(tray.positions(pairs), axis=1)[:, 0], axis=1) >= APART
        made = (_case(ends, rng, weight, boxes, robot) for ends in pairs[far])
        cases += islice((case for case in made if case), count - len(cases))
    return cases


def _case(ends: Array, rng: np.random.Generator, weight: float, boxes: Boxes, robot: "Robot") -> SceneCase | None:
    """The case, if the ends (2, 7) are clear, the straight way is blocked and there is another."""
    from skillfold.robots.scene import Scene

    start, goal = ends
    direct = oracle(weight).direct(start, goal)
    if direct is None:
        return None
    scene = Scene(boxes(rng, tray.positions(direct)))
    obstacles = robot.obstacles(scene)
    if obstacles.clearance(direct[[0, -1]]).min() < 2 * CLEAR or obstacles.clearance(direct).min() > -DEEP:
        return None
    path = way_round(start, goal, obstacles, weight)
    return None if path is None else SceneCase(start, goal, scene, path)


def way_round(start: Array, goal: Array, obstacles: "Obstacles", weight: float = tray.LEVEL_WEIGHT) -> Array | None:
    """Optimal poses (n, 7) from start to goal that keep `CLEAR`; None where none are known."""
    # A centimetre more at the grid's poses leaves room for what lies between them.
    path = oracle(weight).path(start, goal, obstacles.clearance(oracle(weight).poses) > CLEAR + 0.01)
    known = path is not None and obstacles.clearance(path).min() >= CLEAR and tray.inside_limits(path).all()
    return path if known else None


def _box_and_more(rng: np.random.Generator, way: Array) -> "list[Box]":
    place = way[int(rng.uniform(*MIDDLE) * len(way))] + rng.uniform(-0.04, 0.04, 3)
    return [_box(rng, place, BOX), *_beside(rng, int(rng.integers(4)))]


def _wall_and_more(rng: np.random.Generator, way: Array) -> "list[Box]":
    """A wall from near the arm's base outward, in the azimuth of the middle of the way."""
    middle = way[int(rng.uniform(*MIDDLE) * len(way))]
    turn = float(np.arctan2(middle[1], middle[0]))
    split = rng.uniform(0.4, 0.6)
    parts = [(0.25, split), (split, 0.85)]
    heights = [rng.uniform(*LOW), rng.uniform(*TALL)]
    order = rng.permutation(2)
    thick = rng.uniform(0.04, 0.10)
    wall = [_slab(turn, parts[i], thick, heights[k]) for i, k in enumerate(order)]
    return [*wall, *_beside(rng, int(rng.integers(2, 4)))]


def _beside(rng: np.random.Generator, count: int) -> "list[Box]":
    return [_box(rng, place, BESIDE) for place in tray.workspace(count, rng)]


def _box(rng: np.random.Generator, place: Array, edges: tuple[float, float]) -> "Box":
    """Turned about the vertical."""
    from skillfold.robots.shapes import Box

    half = rng.uniform(0, np.pi) / 2
    return Box(pose=(*place, np.cos(half), 0.0, 0.0, np.sin(half)), size=rng.uniform(*edges, 3))


def _slab(turn: float, radii: tuple[float, float], thick: float, height: float) -> "Box":
    from skillfold.robots.shapes import Box

    radius, half = sum(radii) / 2, turn / 2
    place = (radius * np.cos(turn), radius * np.sin(turn), height / 2)
    return Box(pose=(*place, np.cos(half), 0.0, 0.0, np.sin(half)), size=(radii[1] - radii[0], thick, height))
