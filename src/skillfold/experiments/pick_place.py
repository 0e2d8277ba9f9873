"""Section VIII of paper 000: pick-and-place by a skill manifold, learnt dynamics (GMM/GMR) and primitives (DMP).

Every method learns from the same recordings and is asked for motions from and to the places of cubes about start and
goal (equations 26 and 27). A motion reaches its goal if it ends within a hundredth of the way there, and its shape is
compared with that of the recordings: the paper calls it "qualitatively similar", here it is a number. A second number
tells what a demonstrator would have done: each recording is left out in turn, and asked for between its own ends.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from skillfold.baselines.dmp import Primitive, from_rest
from skillfold.baselines.gmr_dynamics import REACHED, Dynamics
from skillfold.errors import MissingExtraError
from skillfold.experiments.parallel import in_parallel
from skillfold.experiments.pick_place_sets import (
    LARGE,
    SHAPES,
    SMALL,
    START,
    MotionSet,
    cube,
    made,
    own,
    recorded,
    shape_distance,
    shape_distances,
)
from skillfold.experiments.rows import Settings
from skillfold.motion import Array

KERNELS = 5  # Gaussians, as in the paper; where all is measured, as many as the data ask for
MADE = ("pick and place (made)", "pick and place (made anew)")

Method = Callable[[Array, Array], list[Array]]
"""Given starts (m, D) and goals (m, D), motions (n, D)."""
Make = Callable[[Sequence[Array]], Method]
"""Given recordings, a method that has learnt them."""


@dataclass(frozen=True)
class Cell:
    """Motions of one method to the places of one cube.

    Attributes:
        what: "start" or "goal" is changed.
        size: of the cube, "small" or "large".
        ends: (m, 2, D) start and goal of each.
        paths: each (n, D).
        reached: (m,) whether each ends at its goal.
        shapes: (m, 2) distances of each one's shape from all the recordings', and from the nearest.
    """

    what: str
    size: str
    ends: Array
    paths: list[Array]
    reached: np.ndarray[Any, Any]
    shapes: Array


@dataclass(frozen=True)
class Compared:
    """All that was asked about one set.

    Attributes:
        motions: the set.
        skill: that was learnt from it.
        cells: by method.
        left_out: by method, (n,) shape distances from each recording, learnt from the others.
        missing: what could not be compared with, and what to install.
    """

    motions: MotionSet
    skill: Any
    cells: dict[str, list[Cell]]
    left_out: dict[str, Array] = field(default_factory=dict)
    missing: tuple[str, ...] = ()


def compare(settings: Settings) -> list[Compared]:
    """Every method on every set, the sets in parallel."""
    cases = [(motions, replace(settings, progress=_silent)) for motions in sets(settings)]
    label = "pick and place: starts and goals"
    settings.progress(label, 0.0)
    return list(in_parallel(compare_set, cases, settings.progress, label, (0.0, 0.7)))


def sets(settings: Settings) -> list[MotionSet]:
    """First recordings of one's own or those that are made in their place, then others."""
    rng = np.random.default_rng(settings.seed)
    mine = own(settings.data)
    first = [mine] if mine else [made(rng, name) for name in MADE[: settings.few(len(MADE), 1)]]
    others = recorded(settings.data, SHAPES[: settings.few(len(SHAPES), 1)])
    return first + others[: settings.few(len(others), 1)]


def compare_set(motions: MotionSet, settings: Settings) -> Compared:
    """Every method that is installed, on one set."""
    cells, left_out, missing = {}, {}, []
    skill = settings.learn(list(motions.recordings))
    for name, make in makers(motions, settings).items():
        try:
            method = planned(skill) if name == "manifold" else make(motions.recordings)
            cells[name] = ask(motions, method)
            left_out[name] = leave_out(motions, make)
        except MissingExtraError as error:
            missing.append(str(error))
    return Compared(motions, skill, cells, left_out, tuple(missing))


def makers(motions: MotionSet, settings: Settings) -> dict[str, Make]:
    """The manifold, and what it is compared with."""

    @cache
    def gaussians() -> int:
        return KERNELS if settings.quick else Dynamics.fit(motions.recordings, settings.seed).components

    return {
        "manifold": lambda shown: planned(settings.learn(list(shown))),
        "GMM/GMR": lambda shown: Dynamics.fit(shown, settings.seed, gaussians()).paths,
        "DMP": lambda shown: Primitive.fit(at_rest(motions, shown)).paths,
    }


def at_rest(motions: MotionSet, shown: Sequence[Array]) -> list[Array]:
    """Recordings of a set as a primitive can imitate them."""
    return list(shown) if motions.timed else [from_rest(recording) for recording in shown]


def ask(motions: MotionSet, method: Method) -> list[Cell]:
    """One method's motions for all cubes."""
    scale = motions.reach / float(np.linalg.norm(START))
    cells = []
    for what in ("start", "goal"):
        for size, half in (("small", SMALL), ("large", LARGE)):
            places = cube(motions.start if what == "start" else motions.goal, half * scale)
            still = np.broadcast_to(motions.goal if what == "start" else motions.start, places.shape)
            ends = np.stack([places, still] if what == "start" else [still, places], axis=1)
            cells.append(_cell(what, size, motions, method, ends))
    return cells


def leave_out(motions: MotionSet, make: Make) -> Array:
    """Shape distances (n,) of a method's motions from each recording, which it was not shown, between its ends."""
    found = []
    for i, recording in enumerate(motions.recordings):
        method = make([other for j, other in enumerate(motions.recordings) if j != i])
        path = method(recording[:1], recording[-1:])[0]
        found.append(shape_distance(path, recording, motions.recordings))
    return np.array(found)


def planned(skill: Any) -> Method:
    """A skill's plans; one that fails stays where it starts."""

    def path(start: Array, goal: Array) -> Array:
        plan = skill.plan(start, goal)
        return plan.path.states if plan.success else np.stack([start, start])

    return lambda starts, goals: [path(a, b) for a, b in zip(starts, goals, strict=True)]


def _cell(what: str, size: str, motions: MotionSet, method: Method, ends: Array) -> Cell:
    paths = method(ends[:, 0], ends[:, 1])
    near = [np.linalg.norm(path[-1] - b) / np.linalg.norm(b - a) for path, (a, b) in zip(paths, ends, strict=True)]
    shapes = np.array([shape_distances(path, motions.recordings) for path in paths])
    # A hair's breadth beyond what makes learnt dynamics stop.
    return Cell(what, size, ends, paths, np.array(near) <= 1.001 * REACHED, shapes)


def _silent(label: str, share: float) -> None:
    """Progress of one set among many is not told."""
