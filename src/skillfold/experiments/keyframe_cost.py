"""Figure 9 of paper 002: nodes and run time until a first path, as printed and mended, whole and reduced envelope."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np

from skillfold.experiments.keyframe_runs import ALPHAS, Answer, Learnt, ask, judged, named, ready
from skillfold.experiments.parallel import in_parallel
from skillfold.experiments.rows import Row, Settings

VARIANTS = ("paper", "mended")
NAMES = {"paper": "as printed", "mended": "mended"}
RUNS = 7  # as in section III
LIMITS = {"paper": 4.0, "mended": 1.0}  # seconds
SAID = ("less time than reduced", "more nodes than reduced")  # of the whole envelope, in words; figures only in plots


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

    @property
    def seconds(self) -> float:
        """Run time, median."""
        return float(np.median([a.seconds for a in self.answers]))

    @property
    def nodes(self) -> float:
        """Of the tree, median."""
        return float(np.median([a.plan.stats["nodes"] for a in self.answers]))


def run(skills: Sequence[Learnt], settings: Settings, count: int = RUNS) -> list[Runs]:
    """Every skill by both variants at both α, each from one start, with `count` seeds."""
    seeds = [(*named(learnt), settings.seed, i) for learnt in skills for i in range(count)]
    cases = [(*which, variant, LIMITS[variant]) for which in seeds for variant in VARIANTS]
    label = "keyframes: nodes and run time"
    settings.progress(label, 0.0)
    answers = list(in_parallel(_answers, cases, settings.progress, label, (0.0, 0.9)))
    found = []
    for learnt, variant, (k, alpha) in product(skills, VARIANTS, enumerate(ALPHAS)):
        mine = [
            a[k] for a, case in zip(answers, cases, strict=True) if (*case[:2], case[4]) == (*named(learnt), variant)
        ]
        found.append(Runs(learnt.task.name, variant, alpha, tuple(mine)))
    return found


def rows(found: Sequence[Runs]) -> list[Row]:
    """Time and nodes of each, beside what the paths are worth, and what the paper says of the whole envelope."""
    return [row for runs in found for row in _rows(runs)]


def _rows(runs: Runs) -> list[Row]:
    name = f"{runs.task}, {NAMES[runs.variant]}, α {runs.alpha:g}"
    said = SAID if runs.alpha == 100.0 else ("", "")
    limit = LIMITS[runs.variant]
    note = f"{len(runs.done)} of {len(runs.answers)} within {limit:g} s of the clock; processor time"
    if runs.done:
        note += f"; {runs.inside:.3g} of the poses along the paths inside"
    return [
        Row(f"{name}: run time, median", 1e3 * runs.seconds, "ms", paper=said[0], note=note),
        Row(f"{name}: nodes, median", runs.nodes, "", paper=said[1]),
    ]


def _answers(task: int, draw: int, seed: int, i: int, variant: str, limit: float) -> tuple[Answer, ...]:
    """Of one seed, at each α."""
    learnt, world = ready(task, draw, seed)
    start = _start(task, draw, seed)
    options: dict[str, Any] = {"variant": variant, "time_limit": limit}
    return tuple(judged(ask(learnt, start, alpha, i, **options), learnt, world) for alpha in ALPHAS)


@lru_cache(2)
def _start(task: int, draw: int, seed: int) -> Any:
    """The start that all set out from; what the printed variant needs is compiled besides."""
    learnt, _ = ready(task, draw, seed)
    start = learnt.start([seed, 10, draw])
    ask(learnt, start, 100.0, 0, variant="paper", time_limit=0.1)
    return start
