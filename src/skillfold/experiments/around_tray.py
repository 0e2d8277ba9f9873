"""Section VI of paper 000 among obstacles: seven joints carry a tray past boxes that were never shown.

Skills learnt with the defaults that a user gets. A plan counts as valid if it says success and if, at fine steps and
judged by obstacles built anew, it is clear, within the joint limits, and level: the tilt is known from the robot's
kinematics, not from what was learnt.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import thread_time
from typing import Any

import numpy as np

from skillfold.experiments import tray
from skillfold.experiments.oracle import finely
from skillfold.experiments.rows import Row, Settings
from skillfold.experiments.tray_cases import SceneCase, hard_cases, past_boxes
from skillfold.motion import Array

POSES = (400, 100)  # demonstrated
FINE = 0.005  # rad between the states that are judged
LEVEL = 0.02  # rad: the most that a valid plan may tilt the tray; the demonstrations tilt it by .008
WARM = 20  # plans that are not timed: the first compile
Clock = Callable[[], float]


@dataclass(frozen=True)
class Answer:
    """A plan and the truth about it.

    Attributes:
        case, plan: what was asked and answered.
        seconds: that it took, by the clock that was asked for.
        clearance: smallest of its states, m.
        tilts: (n,) of the tray along it, rad.
        within: whether it keeps the joint limits.
    """

    case: SceneCase
    plan: Any
    seconds: float
    clearance: float
    tilts: Array
    within: bool

    @property
    def valid(self) -> bool:
        """Whether it says success, and rightly."""
        return self.plan.success and self.holds

    @property
    def holds(self) -> bool:
        """Whether it is clear, within the limits and level."""
        return self.clearance > 0.0 and self.within and float(self.tilts.max()) < LEVEL


@dataclass(frozen=True)
class Run:
    """Cases of one kind, asked of one skill."""

    name: str
    target: float
    skill: Any
    answers: list[Answer]


@dataclass(frozen=True)
class Task:
    """What is learnt, and the cases that are asked."""

    skills: dict[int, Any]
    demonstrations: dict[int, Array]
    past: list[SceneCase]
    hard: list[SceneCase]


def prepare(settings: Settings, past: int, hard: int) -> Task:
    """Skills learnt from fresh poses, and fresh cases."""
    rng = np.random.default_rng(settings.seed)
    settings.progress("past boxes: learning", 0.4)
    poses = {count: tray.tray_poses(count, rng, tray.LEVEL_WEIGHT) for count in POSES}
    skills = {count: settings.learn(demos) for count, demos in poses.items()}
    settings.progress("past boxes: making cases", 0.45)
    cases: list[list[SceneCase]] = []
    kinds: tuple[tuple[Callable[..., list[SceneCase]], int], ...] = ((past_boxes, past), (hard_cases, hard))
    for make, count in kinds:
        cases.append(make(count, rng))
    return Task(skills, poses, *cases)


def run(task: Task, settings: Settings) -> list[Run]:
    """Every case asked; the cases past boxes of both skills."""
    many, few = (task.skills[count] for count in POSES)
    asked = [
        (f"past boxes, {POSES[0]} poses", 0.99, many, task.past),
        (f"past boxes, {POSES[1]} poses", 0.95, few, task.past),
        (f"past walls and boxes, {POSES[0]} poses", 0.97, many, task.hard),
    ]
    runs = []
    for index, (name, target, skill, cases) in enumerate(asked):
        settings.progress(f"planning {name}", 0.6 + 0.1 * index)
        runs.append(Run(name, target, skill, ask(skill, cases)))
    return runs


def ask(skill: Any, cases: Sequence[SceneCase]) -> list[Answer]:
    """A plan for each case, with the defaults."""
    for case in cases[:WARM]:
        answer(skill, case)
    return [answer(skill, case) for case in cases]


def answer(skill: Any, case: SceneCase, clock: Clock = thread_time) -> Answer:
    """A plan, timed, and what is true of it; the clock of the thread stands still while others use its core."""
    obstacles = tray.arm().obstacles(case.scene)
    begun = clock()
    plan = skill.plan(case.start, case.goal, obstacles=obstacles)
    seconds = clock() - begun
    return Answer(case, plan, seconds, *judge(case, plan.path.states))


def judge(case: SceneCase, states: Array) -> tuple[float, Array, bool]:
    """Smallest clearance, tilts, and whether the limits are kept, along a path (n, 7)."""
    robot = tray.arm()
    fine = finely(states, FINE)
    lower, upper = robot.limits
    within = bool(((fine >= lower - 1e-9) & (fine <= upper + 1e-9)).all())
    return float(robot.obstacles(case.scene).clearance(fine).min()), tray.tilt(fine), within


def rows(task: Task, runs: Sequence[Run]) -> list[Row]:
    """Shares, tilt, times and lengths."""
    shares = [_share_row(run) for run in runs]
    return [*shares, _tilt_row(task, runs), *_time_rows(runs), _length_row(runs)]


def _share_row(run: Run) -> Row:
    valid = sum(answer.valid for answer in run.answers)
    said = [answer for answer in run.answers if answer.plan.success]
    wrong = {
        "say that they failed": len(run.answers) - len(said),
        "say success but are not clear": sum(not answer.clearance > 0.0 for answer in said),
        "say success but tilt the tray": sum(not answer.tilts.max() < LEVEL for answer in said),
        "say success but break limits": sum(not answer.within for answer in said),
        "are not smooth": sum("rough" in answer.plan.stats["methods"] for answer in said),
    }
    notes = [f"{valid} of {len(run.answers)}", *(f"{count} {words}" for words, count in wrong.items() if count)]
    name = f"LWR4 tray {run.name}: plans valid at every {FINE:g} rad"
    return Row(name, valid / max(len(run.answers), 1), "share", run.target, ">=", "", "; ".join(notes))


def _tilt_row(task: Task, runs: Sequence[Run]) -> Row:
    tilts = [answer.tilts for run in runs for answer in run.answers if answer.plan.success]
    shown = np.concatenate([tray.tilt(demos) for demos in task.demonstrations.values()])
    every = np.concatenate(tilts) if tilts else np.full(1, np.nan)
    note = f"largest {every.max():.2g}, of the demonstrations {shown.max():.2g}; {len(tilts)} paths"
    name = "LWR4 tray: tilt along all paths, p95, that of the demonstrations as its target"
    return Row(name, _p95(every), "rad", _p95(shown), "<=", "", note)


def _time_rows(runs: Sequence[Run]) -> list[Row]:
    whole = [np.array([answer.seconds for answer in run.answers]) for run in runs]
    first = [np.array([_first(answer) for answer in run.answers if answer.plan.success]) for run in runs]
    return [
        *_median_and_p95("LWR4 tray plan around obstacles", whole, runs, (25.0, 50.0), "by the clock of its thread"),
        *_median_and_p95("LWR4 tray first valid path", first, runs, (6.0, 10.0), "by the clock on the wall"),
    ]


def _first(answer: Answer) -> float:
    return float(answer.plan.stats["seconds_to_first"])


def _median_and_p95(
    name: str, seconds: list[Array], runs: Sequence[Run], targets: tuple[float, float], clock: str
) -> list[Row]:
    found = []
    for words, measure, target in (("median", np.median, targets[0]), ("p95", _p95, targets[1])):
        each = ", ".join(f"{run.name} {1e3 * measure(times):.3g}" for run, times in zip(runs, seconds, strict=True))
        value = 1e3 * float(measure(np.concatenate(seconds)))
        found.append(Row(f"{name}, {words}", value, "ms", target, "<", "", f"{each}; {clock}"))
    return found


def _length_row(runs: Sequence[Run]) -> Row:
    ratios = [answer.plan.length / answer.case.length for run in runs for answer in run.answers if answer.valid]
    note = "of a path of optimal poses over a grid, which is clear by twice as much as planners try to keep"
    return Row(
        "LWR4 tray: length of valid plans over a known path's, median", float(np.median(ratios)), "", note=note
    )


def _p95(values: Array) -> float:
    return float(np.quantile(values, 0.95))
