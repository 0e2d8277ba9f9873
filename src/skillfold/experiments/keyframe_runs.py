"""Keyframe skills learnt from seven demonstrations and planned past what was never shown, and what is true of it."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from time import thread_time
from typing import Any

import numpy as np

from skillfold.experiments.keyframe_judge import FINE, Verdict, judge
from skillfold.experiments.keyframe_tasks import Task, tasks
from skillfold.experiments.parallel import in_parallel
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array, Plan
from skillfold.robots.world import World

ALPHAS = (100.0, 85.0)
SECONDS = 1.0  # that a plan may take
THIRD = 1 / 3


@dataclass(frozen=True, eq=False)
class Learnt:
    """A skill from one draw of demonstrations.

    Attributes:
        task: what was shown.
        draw: which draw.
        skill: as it was learnt.
    """

    task: Task
    draw: int
    skill: Any

    @cached_property
    def envelope(self) -> Any:
        """Between its two Gaussians."""
        return self.skill.envelope(0)

    def start(self, seed: Any) -> Array:
        """Joint positions to set out from, the tool within the first gate."""
        return self.task.start(seed, lambda pose: bool(self.envelope.parent.contains(pose)))


@dataclass(frozen=True, eq=False)
class Answer:
    """A plan, timed, and what is true of it.

    Attributes:
        task: its name.
        alpha, seed: that were asked.
        plan: the answer.
        seconds: of the processor until it was there, check and all; what else runs here does not count.
        verdict: of the path, None where there is none.
        early: of its first part, which leads into a reduced envelope; None where there is none.
    """

    task: str
    alpha: float
    seed: int
    plan: Plan
    seconds: float
    verdict: Verdict | None = None
    early: Verdict | None = None

    @property
    def solved(self) -> bool:
        """Within the gates as they were learnt, in time."""
        return self.plan.success and self.plan.stats["gate_factor"] == 1.0 and self.seconds <= SECONDS


def learn(task: Task, draw: int, settings: Settings) -> Learnt:
    """A skill of two Gaussians, as in section III, else with the defaults that a user gets."""
    from skillfold.keyframes.skill import KeyframeSkill

    demonstrations = task.demonstrations([settings.seed, 1, draw])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the skill keeps its notes
        return Learnt(task, draw, KeyframeSkill.fit(list(demonstrations), n_keyframes=2))


def warm(learnt: Learnt) -> None:
    """What is compiled once, and the task's model, are there before anything is timed."""
    for alpha in ALPHAS:
        ask(learnt, learnt.start(0), alpha, 0)
        ask(learnt, learnt.start(0), alpha, 0, stop="time", time_limit=0.05)


def ask(learnt: Learnt, start: Array, alpha: float, seed: int, scene: Any = None, **options: Any) -> Answer:
    """A plan with the defaults that a user gets."""
    task = learnt.task
    asked: dict[str, Any] = {"alpha": alpha, "time_limit": SECONDS, "seed": seed} | options
    begun = thread_time()
    plan = learnt.skill.plan(task.robot, start, task.scene if scene is None else scene, **asked)
    return Answer(task.name, alpha, seed, plan, thread_time() - begun)


def judged(answer: Answer, learnt: Learnt, world: World) -> Answer:
    """The same with what is true of it: in the whole envelope until it enters the reduced one, in that afterwards."""
    if len(answer.plan.path) < 2:
        return answer
    states = np.asarray(answer.plan.path.states)
    wide = learnt.envelope.widened(answer.plan.stats["gate_factor"])
    entered = int(answer.plan.stats["entered"])
    inside = wide if answer.alpha == 100.0 else wide.reduced(answer.alpha)
    verdict = judge(learnt.task.robot, world, inside, states[entered:])
    early = judge(learnt.task.robot, world, wide, states[: entered + 1]) if entered else None
    return replace(answer, verdict=verdict, early=early)


def answers(skills: Sequence[Learnt], seeds: int, settings: Settings) -> list[Answer]:
    """Every skill asked from `seeds` starts, at each α, with nothing else under way; then every answer judged."""
    asked = []
    for number, learnt in enumerate(skills):
        settings.progress("keyframes: paths", 0.25 * number / len(skills))
        warm(learnt)
        starts = [learnt.start([settings.seed, 2, learnt.draw, i]) for i in range(seeds)]
        asked.append([ask(learnt, start, alpha, i) for i, start in enumerate(starts) for alpha in ALPHAS])
    cases = [(*named(learnt), settings.seed, some) for learnt, some in zip(skills, asked, strict=True)]
    found = in_parallel(_judged, cases, settings.progress, "keyframes: what is true of them", (0.25, 0.45))
    return [answer for some in found for answer in some]


def _judged(task: int, draw: int, seed: int, found: Sequence[Answer]) -> list[Answer]:
    """Answers of one skill, judged in a process of its own."""
    learnt, world = ready(task, draw, seed)
    return [judged(answer, learnt, world) for answer in found]


def named(learnt: Learnt) -> tuple[int, int]:
    """Which task and which draw of it: enough to learn the same in another process."""
    return [task.name for task in tasks()].index(learnt.task.name), learnt.draw


@lru_cache(2)
def ready(task: int, draw: int, seed: int) -> tuple[Learnt, World]:
    """A skill and its world."""
    learnt = learn(tasks()[task], draw, Settings(seed))
    return learnt, World(learnt.task.robot, learnt.task.scene)


def first_rows(found: Sequence[Answer]) -> list[Row]:
    """Share solved in time, median and 95 % quantile of the whole plan."""
    times = 1e3 * np.array([answer.seconds for answer in found])
    shares = [
        f"{task}, α {alpha:g}: {np.mean([a.solved for a in mine]):.3g}, {_median(mine):.2g} ms"
        for task, alpha, mine in _kinds(found)
    ]
    first = 1e3 * np.array([answer.plan.stats["first_solution"] for answer in found])
    nodes = np.median([answer.plan.stats["nodes"] for answer in found])
    said = f"{nodes:g} nodes, first way {np.nanmedian(first):.2g} ms of the clock"
    note = f"{len(found)} plans, processor time; medians: {said}"
    solved = float(np.mean([answer.solved for answer in found]))
    return [
        Row("first solution: solved in 1 s, gates as learnt", solved, "share", 0.99, ">=", "", "; ".join(shares)),
        Row("first solution: whole plan with check, median", float(np.median(times)), "ms", 10.0, "<=", "", note),
        Row("first solution: whole plan with check, p95", float(np.quantile(times, 0.95)), "ms", 50.0, "<="),
    ]


def inside_rows(found: Sequence[Answer]) -> list[Row]:
    """What was seen along the paths."""
    paths = [a for a in found if a.verdict is not None]
    parts = [part for a in paths for part in (a.verdict, a.early) if part is not None]
    states = sum(part.states for part in parts)
    outside = sum(part.outside for part in parts)
    entries, excess = sum(a.early is not None for a in paths), max(part.excess for part in parts)
    note = (
        f"{states} poses of {len(paths)} paths, every {FINE:g} rad; largest √d² - 1: {excess:.1e}; "
        f"{entries} paths enter the reduced envelope on the way and are held to the whole one until then"
    )
    return [
        Row("path poses inside the (reduced) envelope", 1.0 - outside / states, "share", 1.0, ">=", "", note),
        Row("paths that touch something", _some(paths, "touching"), "", 0, "==", "", f"{len(paths)} paths"),
        Row("paths that break joint limits", _some(paths, "beyond"), "", 0, "=="),
    ]


def bits_row(skills: Sequence[Learnt], settings: Settings) -> Row:
    """Whether the same seed gives the same path, bit for bit."""
    same = []
    for learnt in skills:
        start = learnt.start([settings.seed, 3, learnt.draw])
        for alpha in ALPHAS:
            first, again = (ask(learnt, start, alpha, 5).plan.path.states for _ in range(2))
            same.append(np.array_equal(first, again))
    return Row("same seed, same path bits", float(np.mean(same)), "share", 1.0, "==", "", f"{len(same)} plans")


def _median(found: Sequence[Answer]) -> float:
    return float(np.median([1e3 * answer.seconds for answer in found]))


def _kinds(found: Sequence[Answer]) -> list[tuple[str, float, list[Answer]]]:
    kinds = list(dict.fromkeys((a.task, a.alpha) for a in found))
    return [(*kind, [a for a in found if (a.task, a.alpha) == kind]) for kind in kinds]


def _some(paths: Sequence[Answer], name: str) -> float:
    return float(sum(any(getattr(p, name) for p in (a.verdict, a.early) if p is not None) for a in paths))
