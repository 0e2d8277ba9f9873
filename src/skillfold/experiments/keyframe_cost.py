"""Figure 9 of paper 002: nodes and run time until a first path, as printed and mended, whole and reduced envelope."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.experiments.keyframe_runs import ALPHAS, Answer, Learnt, ask, judged, warm
from skillfold.experiments.rows import Row, Settings
from skillfold.robots.world import World

VARIANTS = ("paper", "mended")
RUNS = 7  # as in section III
LIMITS = {"paper": 4.0, "mended": 1.0}  # seconds


@dataclass(frozen=True)
class Runs:
    """Plans of one task, one variant and one α."""

    task: str
    variant: str
    alpha: float
    answers: tuple[Answer, ...]

    @property
    def done(self) -> list[Answer]:
        """Those with a path to the goal, valid or not."""
        return [a for a in self.answers if a.verdict is not None]

    @property
    def inside(self) -> float:
        """Share of the poses along the paths that are inside; NaN where there is none."""
        seen = [part for a in self.done for part in (a.verdict, a.early) if part is not None]
        return 1.0 - sum(p.outside for p in seen) / sum(p.states for p in seen) if seen else float("nan")


def run(skills: Sequence[Learnt], settings: Settings, count: int = RUNS) -> list[Runs]:
    """Every skill by both variants at both α, each from one start, with `count` seeds."""
    found = []
    for number, learnt in enumerate(skills):
        settings.progress(f"keyframes: {learnt.task.name}", number / len(skills))
        world = World(learnt.task.robot, learnt.task.scene)
        warm(learnt)
        start = learnt.start([settings.seed, 10, learnt.draw])
        ask(learnt, start, 100.0, 0, variant="paper", time_limit=0.1)
        for variant in VARIANTS:
            options: dict[str, Any] = {"variant": variant, "time_limit": LIMITS[variant]}
            for alpha in ALPHAS:
                answers = tuple(judged(ask(learnt, start, alpha, i, **options), world) for i in range(count))
                found.append(Runs(learnt.task.name, variant, alpha, answers))
    return found


def rows(found: Sequence[Runs]) -> list[Row]:
    """Time and nodes of each, beside what the paths are worth."""
    made = []
    for runs in found:
        times = 1e3 * np.array([a.seconds for a in runs.answers])
        nodes = np.median([a.plan.stats["nodes"] for a in runs.answers])
        note = (
            f"{len(runs.done)} of {len(runs.answers)} within {LIMITS[runs.variant]:g} s, {nodes:.0f} nodes (median), "
            f"{runs.inside:.3g} of the poses along the paths inside"
        )
        name = f"{runs.task}, {runs.variant}, α {runs.alpha:g}: run time, median"
        made.append(Row(name, float(np.median(times)), "ms", note=note))
    return made
