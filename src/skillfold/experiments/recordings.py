"""Skills learnt from recorded motions: one demonstration left out, planned, and compared with it.

Every figure stands over a baseline that knows the ends just as well: the mean of the other demonstrations,
its ends corrected. Ratios are summed up as geometric means over all demonstrations of all tasks.
"""

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np

from skillfold.experiments.leave_one_out import (
    corrected_mean,
    distance_between,
    geometric_mean,
    located_mean,
    nearest_distance,
    random_stretch,
    straight_line,
)
from skillfold.experiments.loaders import RecordedTask, lasa, robot_tasks
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array

STRETCHES = 3  # random stretches of every left-out demonstration
ROBOT_TARGETS = {"positions": 1.00, "orientations": 1.03}
LEFT_OUT = "left out, over the corrected mean"


@dataclass(frozen=True)
class Score:
    """One demonstration left out: distances of the plan over those of a baseline.

    Attributes:
        whole: from its start to its end, over the corrected mean of the others.
        nearest: the same by the distance to the nearest point instead of the point of equal phase.
        line: the straight line from start to end, over the corrected mean.
        stretch: from the ends of random 30–70 % stretches, over the phase-located corrected mean.
        via: with the state half-way given, over the corrected mean, which knows the ends only.
    """

    whole: float
    nearest: float
    line: float
    stretch: float
    via: float


def score_task(task: RecordedTask, settings: Settings, rng: np.random.Generator) -> list[Score]:
    """One score per demonstration of the task."""
    return [
        _score(_fit(others, task, settings), truth, others, task, rng) for truth, others in left_out(task.recordings)
    ]


def left_out(recordings: Sequence[Array]) -> list[tuple[Array, list[Array]]]:
    """Every recording with the list of the others."""
    return [(truth, [other for j, other in enumerate(recordings) if j != i]) for i, truth in enumerate(recordings)]


def measure(settings: Settings) -> list[Row]:
    """The rows about whole recordings; those of the robot tasks need a data folder."""
    rng = np.random.default_rng(settings.seed)
    scores: list[Score] = []
    rows: list[Row] = []
    for name, target, tasks in _sets(settings):
        new = _score_set(name, tasks, settings, rng)
        scores += new
        rows += _set_rows(name, new, target)
    rows += [*_missing(settings), *_conditioned_rows("all sets", scores)]
    return rows


def _sets(settings: Settings) -> list[tuple[str, float, list[RecordedTask]]]:
    """Name, target of the left-out figure, and tasks of every set at hand."""
    sets = [
        ("LASA 26 single-mode shapes", 0.97, lasa(multi_mode=False)),
        ("LASA 4 multi-mode shapes", 0.20, lasa(multi_mode=True)),
    ]
    if settings.data is not None:
        sets += [
            (f"robot tasks, {kind}", target, robot_tasks(settings.data, orientations=kind == "orientations"))
            for kind, target in ROBOT_TARGETS.items()
        ]
    return sets


def _missing(settings: Settings) -> list[Row]:
    """Rows of the sets that need a data folder, where there is none."""
    kinds = ROBOT_TARGETS.items() if settings.data is None else ()
    note = "not measured: no data folder given"
    return [Row(f"robot tasks, {kind}: {LEFT_OUT}", None, "", target, note=note) for kind, target in kinds]


def _score_set(name: str, tasks: list[RecordedTask], settings: Settings, rng: np.random.Generator) -> list[Score]:
    scores: list[Score] = []
    for index, task in enumerate(tasks):
        settings.progress(f"{name}: {task.name}", index / len(tasks))
        scores += score_task(task, settings, rng)
    return scores


def _mean_score(scores: list[Score]) -> Score:
    """Geometric mean of every ratio."""
    return Score(*(geometric_mean(column) for column in zip(*map(astuple, scores), strict=True)))


def _set_rows(name: str, scores: list[Score], target: float) -> list[Row]:
    mean = _mean_score(scores)
    wins = sum(score.whole < 1 for score in scores)
    note = f"closer in {wins} of {len(scores)}; by nearest points {mean.nearest:.2f}"
    return [
        Row(f"{name}: {LEFT_OUT}", mean.whole, "", target, note=note),
        Row(f"{name}: left out, over the straight line", mean.whole / mean.line, "", 1.0, "<"),
        *_conditioned_rows(name, scores),
    ]


def _conditioned_rows(name: str, scores: list[Score]) -> list[Row]:
    mean = _mean_score(scores)
    return [
        Row(f"{name}: random stretch, over the phase-located corrected mean", mean.stretch, "", 1.0),
        Row(f"{name}: one via point given, over the ends-only corrected mean", mean.via, "", 0.6),
    ]


def _score(skill: Any, truth: Array, others: list[Array], task: RecordedTask, rng: np.random.Generator) -> Score:
    start, goal, unit = truth[0], truth[-1], task.quaternions
    mean = corrected_mean(others, start, goal, unit=unit)
    baseline = distance_between(mean, truth, unit=unit)
    path = _path(skill.plan(start, goal), start, unit)
    stretches = [random_stretch(truth, rng) for _ in range(STRETCHES)]
    via = _path(skill.plan(start, goal, via=truth[len(truth) // 2][None]), start, unit)
    return Score(
        whole=distance_between(path, truth, unit=unit) / baseline,
        nearest=nearest_distance(path, truth, unit=unit) / nearest_distance(mean, truth, unit=unit),
        line=distance_between(straight_line(start, goal, unit=unit), truth, unit=unit) / baseline,
        stretch=geometric_mean([_stretch_ratio(skill, part, others, unit) for part in stretches]),
        via=distance_between(via, truth, unit=unit) / baseline,
    )


def _stretch_ratio(skill: Any, truth: Array, others: list[Array], unit: bool) -> float:
    start, goal = truth[0], truth[-1]
    path = _path(skill.plan(start, goal), start, unit)
    baseline = located_mean(others, start, goal, unit=unit)
    return distance_between(path, truth, unit=unit) / distance_between(baseline, truth, unit=unit)


def _path(plan: Any, start: Array, unit: bool) -> Array:
    """The plan's states; a quaternion path may come back with the other sign."""
    states = plan.path.states
    return -states if unit and np.dot(states[0], start) < 0 else states


def _fit(others: list[Array], task: RecordedTask, settings: Settings, **options: Any) -> Any:
    return settings.learn(_as_quaternions(others) if task.quaternions else others, **options)


def _as_quaternions(recordings: list[Array]) -> Any:
    from skillfold.demonstrations import Demonstrations
    from skillfold.spaces import StateSpace

    return Demonstrations(recordings, space=StateSpace(("quaternion",) * 4))
