"""`skillfold demo keyframes`: both tasks of section III from seven demonstrations, planned at α 100 and 85."""

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.experiments.keyframe_runs import ALPHAS, Answer, Learnt, ask, judged, learn, warm
from skillfold.experiments.keyframe_tasks import tasks
from skillfold.experiments.rows import Progress, Settings
from skillfold.motion import Array
from skillfold.robots.world import World

PLANS = 5  # paths of each task at each α, as in figures 6 and 8


@dataclass(frozen=True, eq=False)
class Chapter:
    """One task.

    Attributes:
        learnt: the skill, and what it was learnt from.
        start: joint positions (dof,) that all set out from.
        answers: by α, plans of several seeds.
        fit_seconds: that the fit took.
    """

    learnt: Learnt
    start: Array
    answers: dict[float, list[Answer]]
    fit_seconds: float

    def paths(self, alpha: float) -> list[Array]:
        """Tool positions (n, 3) along each path."""
        robot = self.learnt.task.robot
        return [robot.forward(a.plan.path.states)[:, :3] for a in self.answers[alpha] if a.plan.success]

    def facts(self) -> list[dict[str, Any]]:
        """What a table shows, for each α, in JSON's types."""
        return [self._facts(alpha) for alpha in self.answers]

    def _facts(self, alpha: float) -> dict[str, Any]:
        found = self.answers[alpha]
        seen = [part for a in found for part in (a.verdict, a.early) if part is not None]
        done = [a.plan for a in found if a.plan.success]
        return {
            "task": self.learnt.task.name,
            "alpha": alpha,
            "fit_seconds": self.fit_seconds,
            "plans": len(found),
            "solved": sum(a.solved for a in found),
            "first_seconds": _median([plan.stats["first_solution"] for plan in done]),
            "plan_seconds": _median([a.seconds for a in found]),
            "nodes": _median([a.plan.stats["nodes"] for a in found]),
            "length": _median([plan.length for plan in done]),
            "gate_factor": max((float(plan.stats["gate_factor"]) for plan in done), default=None),
            "outside": sum(part.outside for part in seen),
            "touching": sum(part.touching for part in seen),
            "states": sum(part.states for part in seen),
        }


@dataclass(frozen=True, eq=False)
class Story:
    """Both tasks."""

    chapters: tuple[Chapter, ...]

    def facts(self) -> list[dict[str, Any]]:
        """Of every task and α."""
        return [facts for chapter in self.chapters for facts in chapter.facts()]


def run(seed: int = 0, progress: Progress | None = None, plans: int | None = None) -> Story:
    """Learn, plan, judge.

    Args:
        seed: of everything random.
        progress: called with what is being done and the share of all that is done.
        plans: of each task at each α; `PLANS` unless told otherwise.
    """
    settings = Settings(seed, progress=progress or Settings(0).progress)
    settings.progress("compiling (once on each machine): keyframes", 0.0)
    return Story(tuple(_chapter(number, settings, plans or PLANS) for number in range(len(tasks()))))


def _chapter(number: int, settings: Settings, plans: int) -> Chapter:
    task = tasks()[number]
    learn(task, 0, settings)  # compiles
    begun = perf_counter()
    learnt = learn(task, number, settings)
    taken = perf_counter() - begun
    warm(learnt)
    settings.progress(task.name, 0.4 + 0.3 * number)
    start = learnt.start([settings.seed, number])
    world = World(task.robot, task.scene)
    answers = {alpha: [judged(ask(learnt, start, alpha, i), learnt, world) for i in range(plans)] for alpha in ALPHAS}
    return Chapter(learnt, start, answers, taken)


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if len(values) else None
