"""Section VIII of paper 000: pick-and-place by a skill manifold, learnt dynamics (GMM/GMR) and primitives (DMP).

Every method learns from the same recordings and is asked for motions from and to the places of cubes about start and
goal (equations 26 and 27). A motion reaches its goal if it ends within a hundredth of the way there, and its shape is
compared with that of the recordings: the paper calls it "qualitatively similar", here it is a number.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.baselines.dmp import Primitive
from skillfold.baselines.gmr_dynamics import REACHED, Dynamics
from skillfold.errors import MissingExtraError
from skillfold.experiments.pick_place_sets import (
    LARGE,
    SMALL,
    START,
    MotionSet,
    cube,
    made,
    recorded,
    shape_distances,
)
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array

KERNELS, DIM = 5, 1  # the paper's, where training is timed
PAPER = {("start", "small"): "27; GMM/GMR 12", ("start", "large"): "27; GMM/GMR 8"}
PAPER |= {("goal", "small"): "27; GMM/GMR –", ("goal", "large"): "27; GMM/GMR –"}

Method = Callable[[Array, Array], Array]
"""Given start (D,) and goal (D,), a motion (n, D)."""


@dataclass(frozen=True)
class Counts:
    """How many sets are made, and trainings that are timed."""

    made: int = 2
    trainings: int = 20


@dataclass(frozen=True)
class Cell:
    """Motions of one method to the places of one cube.

    Attributes:
        what: "start" or "goal" is changed.
        size: of the cube, "small" or "large".
        paths: each (n, D).
        reached: (n,) whether each ends at its goal.
        shapes: (n, 2) distances of each one's shape from all the recordings', and from the nearest.
        seconds: of a motion, median.
    """

    what: str
    size: str
    paths: list[Array]
    reached: np.ndarray[Any, Any]
    shapes: Array
    seconds: float


@dataclass(frozen=True)
class Compared:
    """All cells of one set, by method."""

    motions: MotionSet
    skill: Any
    cells: dict[str, list[Cell]]


def measure(settings: Settings, counts: Counts | None = None) -> list[Row]:
    """Tables III and IV."""
    counts = counts or Counts()
    return rows(compare(settings, counts)) + training_rows(settings, counts.trainings)


def compare(settings: Settings, counts: Counts | None = None) -> list[Compared]:
    """Every method on every set."""
    counts = counts or Counts()
    rng = np.random.default_rng(settings.seed)
    sets = [made(rng) for _ in range(counts.made)] + recorded(settings.data)
    found = []
    for index, motions in enumerate(sets):
        settings.progress(f"pick and place: {motions.name}", 0.8 * index / len(sets))
        skill = settings.learn(list(motions.recordings))
        methods = {"manifold": _planned(skill), **_others(motions, settings.seed)}
        found.append(Compared(motions, skill, {name: ask(motions, method) for name, method in methods.items()}))
    return found


def ask(motions: MotionSet, method: Method) -> list[Cell]:
    """One method's motions for all cubes."""
    scale = motions.reach / float(np.linalg.norm(START))
    cells = []
    for what in ("start", "goal"):
        for size, half in (("small", SMALL), ("large", LARGE)):
            places = cube(motions.start if what == "start" else motions.goal, half * scale)
            ends = [(p, motions.goal) if what == "start" else (motions.start, p) for p in places]
            cells.append(_cell(what, size, motions, method, ends))
    return cells


def rows(compared: Sequence[Compared]) -> list[Row]:
    """Table IV, with what the paper leaves out: shapes, and the other methods at changed goals."""
    return [row for each in compared for row in (*_reached_rows(each), *_shape_rows(each))]


def training_rows(settings: Settings, trainings: int) -> list[Row]:
    """Table III: both methods with five kernels on the set that is made."""
    settings.progress("pick and place: training", 0.85)
    motions = made(np.random.default_rng(settings.seed))
    taken: dict[str, list[float]] = {"manifold": [], "GMM/GMR": []}
    made_in: dict[str, list[float]] = {"manifold": [], "GMM/GMR": []}
    places = cube(motions.start, SMALL)
    for i in range(trainings + 1):  # the first compiles
        trained: dict[str, Callable[[], Method]] = {
            "manifold": lambda: _planned(settings.learn(list(motions.recordings), dim=DIM, kernels=KERNELS)),
            "GMM/GMR": lambda i=i: Dynamics.fit(motions.recordings, settings.seed + i, KERNELS).path,
        }
        for name, train in trained.items():
            method, seconds = _timed(train)
            taken[name].append(seconds)
            made_in[name].append(_timed(lambda method=method, i=i: method(places[i % len(places)], motions.goal))[1])
    return [
        _time_row("training, 5 kernels", taken, "1.38; GMM/GMR 2.35"),
        _time_row("generation", made_in, "0.0817; GMM/GMR 0.0853"),
    ]


def _time_row(name: str, taken: dict[str, list[float]], paper: str) -> Row:
    ours, theirs = (float(np.mean(taken[method][1:])) for method in ("manifold", "GMM/GMR"))
    note = f"mean of {len(taken['manifold']) - 1}; target: GMM/GMR here"
    return Row(f"Table III: {name}", ours, "s", theirs, "<", paper, note)


def _planned(skill: Any) -> Method:
    def path(start: Array, goal: Array) -> Array:
        plan = skill.plan(start, goal)
        return plan.path.states if plan.success else np.stack([start, start])

    return path


def _others(motions: MotionSet, seed: int) -> dict[str, Method]:
    """What the manifold is compared with, as far as it is installed."""
    found: dict[str, Method] = {}
    makers: dict[str, Callable[[], Method]] = {
        "GMM/GMR": lambda: Dynamics.fit(motions.recordings, seed).path,
        "DMP": lambda: Primitive.fit(motions.recordings).path,
    }
    for name, make in makers.items():
        try:
            found[name] = make()
        except MissingExtraError:
            continue
    return found


def _cell(what: str, size: str, motions: MotionSet, method: Method, ends: list[tuple[Array, Array]]) -> Cell:
    paths, taken = zip(*(_timed(lambda a=a, b=b: method(a, b)) for a, b in ends), strict=True)
    near = [np.linalg.norm(path[-1] - b) / np.linalg.norm(b - a) for path, (a, b) in zip(paths, ends, strict=True)]
    shapes = np.array([shape_distances(path, motions.recordings) for path in paths])
    # A hair's breadth beyond what makes learnt dynamics stop.
    return Cell(what, size, list(paths), np.array(near) <= 1.001 * REACHED, shapes, float(np.median(taken)))


def _timed(call: Callable[[], Any]) -> tuple[Any, float]:
    begun = perf_counter()
    result = call()
    return result, perf_counter() - begun


def _reached_rows(each: Compared) -> list[Row]:
    found = []
    for index, cell in enumerate(each.cells["manifold"]):
        others = [
            f"{name} {int(cells[index].reached.sum())}" for name, cells in each.cells.items() if name != "manifold"
        ]
        name = f"Table IV: {each.motions.name}, {cell.what} changed, {cell.size} cube: reached"
        count = len(cell.reached)
        reached = int(cell.reached.sum())
        paper = PAPER[cell.what, cell.size]
        found.append(Row(name, reached, f"of {count}", count, ">=", paper, "; ".join(others)))
    return found


def _shape_rows(each: Compared) -> list[Row]:
    """Mean shape distances at changed starts, where dynamics can be asked too; the others' least is the target."""
    return [
        _shape_row(each, index, words) for index, words in enumerate(("the recordings", "the recording most alike"))
    ]


def _shape_row(each: Compared, index: int, words: str) -> Row:
    means = {
        name: float(np.mean([cell.shapes[:, index].mean() for cell in cells if cell.what == "start"]))
        for name, cells in each.cells.items()
    }
    ours = means.pop("manifold")
    note = "; ".join(f"{name} {mean:.3f}" for name, mean in means.items()) or "nothing to compare with is installed"
    name = f"{each.motions.name}: shape distance from {words}"
    return Row(name, ours, "", min(means.values(), default=None), "<", "", note)
