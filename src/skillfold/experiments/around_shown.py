"""What the picture of plans around obstacles shows: shortest paths into patches or a wall, and the ways around."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from skillfold.experiments import around_arm
from skillfold.experiments.patch_cases import ENDS_CLEAR, disc, wall_cases
from skillfold.experiments.reaching import upper_half_disc
from skillfold.experiments.rows import Settings
from skillfold.experiments.three_link import WEIGHTED_REACHING, forward, optimal
from skillfold.motion import Array
from skillfold.planning.point_obstacles import PointObstacles

BETA = 0.7
DISCS = ((-0.42, 0.42, 0.10), (0.05, 0.62, 0.11), (0.48, 0.40, 0.10))  # m: centre and radius
PAIRS = 4
DRAWN = 2000  # ends at most, of which some are shown
APART = 0.45  # m between the ends of a path, and half of it between those of two


@dataclass(frozen=True)
class Scene:
    """Obstacles on the manifold and plans among them.

    Attributes:
        skill: learnt from poses of section V-B.
        points: (m, 3) obstacle points.
        reach: rad, of each.
        through: shortest paths (n, 3), which do not keep clear.
        around: paths between the same ends that do.
    """

    skill: Any
    points: Array
    reach: float
    through: list[Array]
    around: list[Array]


def scenes(settings: Settings, pairs: int = PAIRS) -> tuple[Scene, Scene]:
    """Among three patches, and through the gap of a wall."""
    rng = np.random.default_rng(settings.seed)
    skill = around_arm.learn(settings, rng)
    reach = BETA * skill.model.step * skill.model.scale
    patches = np.vstack([disc(np.array(place), radius, reach) for *place, radius in DISCS])
    wall = wall_cases(1, reach, rng)[0].points
    return tuple(_scene(skill, points, reach, pairs, rng) for points in (patches, wall))  # type: ignore[return-value]


def _scene(skill: Any, points: Array, reach: float, pairs: int, rng: np.random.Generator) -> Scene:
    obstacles, through, around = PointObstacles(points, reach), [], []
    for start, goal in _ends(points, reach, rng):
        if len(around) == pairs:
            break
        taken = [end for path in around for end in path[[0, -1]]]
        # From the cheapest question to the dearest.
        if not _alone(np.stack([start, goal]), taken):
            continue
        shortest = skill.plan(start, goal, obstacles=obstacles, method="geodesic")
        if shortest.success:
            continue
        plan = skill.plan(start, goal, obstacles=obstacles)
        if plan.success and around_arm.rmse(plan.path.states) < around_arm.OFF:
            through.append(shortest.path.states)
            around.append(plan.path.states)
    return Scene(skill, points, reach, through, around)


def _ends(points: Array, reach: float, rng: np.random.Generator) -> Iterator[tuple[Array, Array]]:
    """Pairs of poses far from each other and from all obstacle points."""
    poses = optimal(upper_half_disc(DRAWN, rng), WEIGHTED_REACHING).reshape(-1, 2, 3)
    clear = KDTree(points).query(poses)[0].min(axis=1) > ENDS_CLEAR * reach
    far = np.linalg.norm(np.diff(forward(poses), axis=1)[:, 0], axis=1) > APART
    yield from poses[clear & far]


def _alone(ends: Array, taken: list[Array]) -> bool:
    """Whether tool positions at both ends keep away from those of other paths."""
    if not taken:
        return True
    return float(KDTree(forward(np.array(taken))).query(forward(ends))[0].min()) > APART / 2
