"""Section V-B3 of paper 000: planning cases with no-go patches on the manifold of the three-link arm.

Obstacles are points in joint space, true optimal poses over a disc or a wall with one gap in task space; each is to
be passed at a distance, βℓ in the paper. Every case has a path known to exist that keeps that distance, while the
optimal poses over the straight way come nearer than half of it. The planner has no part in making them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.spatial import KDTree

from skillfold.experiments.oracle import Oracle, length
from skillfold.experiments.reaching import REACH, upper_half_disc
from skillfold.experiments.three_link import WEIGHTED_REACHING, forward, optimal
from skillfold.motion import Array

GRID_STEP = 0.02  # m
NEIGHBOURS = 5**0.5  # grid steps: sixteen directions
LONGEST_EDGE, SPACING = 0.6, 0.02  # rad
NEARER = 0.5  # of the reach: what counts as blocked
DENSE = 0.4  # of the reach: spacing of obstacle points
STEEP = 4.0  # rad per metre that poses change by, about
DISC_RADIUS = (0.04, 0.14)  # m
GAP = (1.0, 1.8)  # in reaches: what is left open of a wall's gap, at least
ENDS_CLEAR = 1.1  # reaches
MIDDLE = (0.35, 0.65)  # of the straight way: where the patch lies


@dataclass(frozen=True)
class PatchCase:
    """A planning case that can be solved.

    Attributes:
        start, goal: (3,) optimal poses, rad.
        points: (n, 3) obstacle points on the manifold.
        reach: rad to keep from every point.
        oracle: (m, 3) optimal poses from start to goal that keep it.
    """

    start: Array
    goal: Array
    points: Array
    reach: float
    oracle: Array

    @property
    def length(self) -> float:
        """Of the oracle's path, rad."""
        return length(self.oracle)

    def clearance(self, states: Array) -> Array:
        """Distance (n,) of states (n, 3) from the nearest obstacle point, less `reach`."""
        return KDTree(self.points).query(states)[0] - self.reach


Patch = Callable[[np.random.Generator, Array, Array, float], Array]
"""Obstacle points in the way between a start and a goal, for a reach."""


def disc_cases(count: int, reach: float, rng: np.random.Generator) -> list[PatchCase]:
    """Cases with one disc between start and goal."""
    return _cases(count, reach, rng, _disc)


def wall_cases(count: int, reach: float, rng: np.random.Generator) -> list[PatchCase]:
    """Cases with a wall between start and goal, across all that the arm reaches but for one gap."""
    return _cases(count, reach, rng, _wall)


def disc(centre: Array, radius: float, reach: float) -> Array:
    """Obstacle points (n, 3): optimal poses over a disc of tool positions, dense enough for a reach."""
    count = int(np.ceil(np.pi * (STEEP * radius / (DENSE * reach)) ** 2))
    # A sunflower's seeds: evenly spread over the disc.
    turns, share = np.pi * (3 - 5**0.5) * np.arange(count), np.sqrt((np.arange(count) + 0.5) / count)
    places = centre + radius * share[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])
    return optimal(places[_reachable(places)], WEIGHTED_REACHING)


@cache
def oracle() -> Oracle:
    """Optimal poses over a grid of the upper half disc."""
    steps = round(1 / GRID_STEP)
    lattice = np.stack(np.meshgrid(np.arange(-steps, steps + 1), np.arange(steps + 1), indexing="ij"), axis=-1)
    lattice = lattice.reshape(-1, 2).astype(np.float64)
    lattice = lattice[np.linalg.norm(lattice, axis=1) * GRID_STEP <= REACH]
    places = lattice * GRID_STEP + [0.0, 1e-6]  # on the x axis itself two mirrored poses are equally good
    poses = optimal(places, WEIGHTED_REACHING)
    return Oracle.build(lattice, poses, NEIGHBOURS, LONGEST_EDGE, _truth, SPACING)


def _truth(states: Array) -> Array:
    places = forward(states)
    places[:, 1] = np.maximum(places[:, 1], 1e-6)
    return optimal(places, WEIGHTED_REACHING)


def _cases(count: int, reach: float, rng: np.random.Generator, patch: Patch) -> list[PatchCase]:
    cases: list[PatchCase] = []
    while len(cases) < count:
        start, goal = optimal(upper_half_disc(2, rng), WEIGHTED_REACHING)
        case = _case(start, goal, patch(rng, start, goal, reach), reach)
        cases += [case] if case else []
    return cases


def _case(start: Array, goal: Array, points: Array, reach: float) -> PatchCase | None:
    """The case, if the ends are clear, the straight way is blocked and there is another."""
    direct = oracle().direct(start, goal)
    if direct is None or not len(points):
        return None
    tree = KDTree(points)
    ends_clear = tree.query([start, goal])[0].min() > ENDS_CLEAR * reach
    if not ends_clear or tree.query(direct)[0].min() > NEARER * reach:
        return None
    path = oracle().path(start, goal, tree.query(oracle().poses)[0] > reach + SPACING, 2 * reach)
    if path is None or tree.query(path)[0].min() < reach:
        return None
    return PatchCase(start, goal, points, reach, path)


def _disc(rng: np.random.Generator, start: Array, goal: Array, reach: float) -> Array:
    radius = rng.uniform(*DISC_RADIUS)
    return disc(_between(rng, start, goal) + rng.uniform(-0.5, 0.5, 2) * radius, radius, reach)


def _wall(rng: np.random.Generator, start: Array, goal: Array, reach: float) -> Array:
    way = np.subtract(*forward(np.stack([goal, start])))
    turn = np.arctan2(way[1], way[0]) + np.pi / 2 + rng.uniform(-0.5, 0.5)
    line = np.linspace(-2.0, 2.0, 1201)[:, None] * [np.cos(turn), np.sin(turn)] + _between(rng, start, goal)
    poses = optimal(line[_reachable(line)], WEIGHTED_REACHING)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(poses, axis=0), axis=1))])
    chosen = np.searchsorted(along, np.arange(0.0, along[-1], DENSE * reach))
    poses, along = poses[chosen], along[chosen]
    half = reach * (1 + rng.uniform(*GAP) / 2)
    gap = rng.uniform(half, max(along[-1] - half, half))
    return np.vstack([*_beyond(poses, reach), poses[np.abs(along - gap) > half]])


def _beyond(poses: Array, reach: float) -> list[Array]:
    """A wall's poses (n, 3) carried on straight beyond both ends, where the arm was never shown."""
    steps = np.arange(1, 12)[:, None] * DENSE * reach
    outward = [ends[0] - ends[1] for ends in (poses[:2], poses[:-3:-1])]
    ends = zip((poses[0], poses[-1]), outward, strict=True)
    return [end + steps * out / np.linalg.norm(out) for end, out in ends]


def _between(rng: np.random.Generator, start: Array, goal: Array) -> Array:
    """A tool position (2,) in the middle of the straight way."""
    share = rng.uniform(*MIDDLE)
    return forward((1 - share) * start + share * goal)


def _reachable(places: Array) -> np.ndarray:
    return (places[:, 1] >= 1e-6) & (np.linalg.norm(places, axis=1) < 0.98)
