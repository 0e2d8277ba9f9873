"""Section V-B3 of paper 000: the three-link arm's plans around patches and through the gap of a wall.

Skills learnt with the defaults that a user gets, from fresh samples; obstacle points of reach βℓ, where ℓ is the
usual distance between neighbouring samples. Whether a plan is good is found without the planner: by distances from
the obstacle points at fine steps, and by the true optimum at the states' own tool positions.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import thread_time
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from skillfold.experiments.oracle import finely
from skillfold.experiments.patch_cases import NEARER, PatchCase, disc_cases, wall_cases
from skillfold.experiments.reaching import upper_half_disc
from skillfold.experiments.rows import Row, Settings
from skillfold.experiments.three_link import WEIGHTED_REACHING, followed, forward, optimal
from skillfold.motion import Array
from skillfold.planning.point_obstacles import PointObstacles

SAMPLES = 100
FINE = 1e-3  # rad between the states that are judged
OFF = 0.02  # rad of joint RMSE against the optimum
LOCAL = ("springs", "hinge", "geodesic")
WARM = 5  # plans that are not timed: the first compile
# Of the same criterion in another implementation of the paper, by method and kind of case.
ELSEWHERE = {
    ("springs", "discs β = 1"): "51 of 60",
    ("springs", "discs β = 0.7"): "14 of 25",
    ("springs", "walls β = 0.7"): "1 of 25",
    ("hinge", "discs β = 1"): "59 of 60",
    ("hinge", "discs β = 0.7"): "23 of 25",
    ("hinge", "walls β = 0.7"): "0 of 25",
}


@dataclass(frozen=True)
class Kind:
    """One kind of cases: how many of them, how they are made, β, the share of good plans that is asked for."""

    name: str
    make: Callable[[int, float, np.random.Generator], list[PatchCase]]
    beta: float
    target: float | None


KINDS = (
    Kind("discs β = 1", disc_cases, 1.0, 0.98),
    Kind("discs β = 0.7", disc_cases, 0.7, None),
    Kind("walls β = 0.7", wall_cases, 0.7, 0.95),
)


@dataclass(frozen=True)
class Answer:
    """A plan and the truth about it.

    Attributes:
        case, plan: what was asked and answered.
        seconds: that it took, by the clock of its thread.
        clearance: smallest distance of its states from an obstacle point, in reaches; NEARER at least is asked for.
        rmse: rad per joint, against the optimum at the states' own tool positions; infinite where there is none.
    """

    case: PatchCase
    plan: Any
    seconds: float
    clearance: float
    rmse: float

    @property
    def clear(self) -> bool:
        """Whether it keeps half the reach from every obstacle point."""
        return self.clearance > NEARER

    @property
    def good(self) -> bool:
        """Whether it says success, is clear and holds the manifold."""
        return self.plan.success and self.clear and self.rmse < OFF


@dataclass(frozen=True)
class Counts:
    """How many skills, and cases of each kind in all; `local` of them for the local methods too."""

    skills: int = 4
    cases: tuple[int, ...] = (200, 200, 100)
    local: int = 40


def measure(settings: Settings, counts: Counts | None = None) -> list[Row]:
    """All rows of the arm."""
    counts = counts or Counts()
    answers: dict[tuple[str, str], list[Answer]] = {}
    for index in range(counts.skills):
        rng = np.random.default_rng([settings.seed, index])
        skill = learn(settings, rng)
        for kind, count in zip(KINDS, counts.cases, strict=True):
            settings.progress(f"around patches: {kind.name}", 0.4 * index / counts.skills)
            cases = make_cases(skill, kind, _share(count, index, counts.skills), rng)
            answers.setdefault(("", kind.name), []).extend(ask(skill, cases))
            few = cases[: _share(counts.local, index, counts.skills)]
            for method in LOCAL:
                answers.setdefault((method, kind.name), []).extend(ask(skill, few, method))
    return rows(answers)


def learn(settings: Settings, rng: np.random.Generator) -> Any:
    """A skill of optimal poses over the upper half disc (Equation 15)."""
    return settings.learn(optimal(upper_half_disc(SAMPLES, rng), WEIGHTED_REACHING))


def make_cases(skill: Any, kind: Kind, count: int, rng: np.random.Generator) -> list[PatchCase]:
    """Cases whose obstacle points reach βℓ."""
    return kind.make(count, kind.beta * skill.model.step * skill.model.scale, rng)


def ask(skill: Any, cases: Sequence[PatchCase], method: str = "") -> list[Answer]:
    """A plan for each case, by the library's own choice of method unless one is given."""
    for case in cases[:WARM]:
        answer(skill, case, method)
    return [answer(skill, case, method) for case in cases]


def answer(skill: Any, case: PatchCase, method: str = "") -> Answer:
    """A plan, timed, and what is true of it."""
    options = {"method": method} if method else {}
    obstacles = PointObstacles(case.points, case.reach)
    begun = thread_time()
    plan = skill.plan(case.start, case.goal, obstacles=obstacles, **options)
    seconds = thread_time() - begun
    states = finely(plan.path.states, FINE)
    clearance = float(KDTree(case.points).query(states)[0].min()) / case.reach
    return Answer(case, plan, seconds, clearance, rmse(plan.path.states))


def rows(answers: dict[tuple[str, str], list[Answer]]) -> list[Row]:
    """Of answers by method, "" for the default, and kind."""
    default = [answers["", kind.name] for kind in KINDS]
    found = [
        _share_row(f"V-B {kind.name}: plans clear and on the manifold", mine, kind.target)
        for kind, mine in zip(KINDS, default, strict=True)
    ]
    walls = [answer for answer in default[-1] if answer.plan.success]
    through = sum(not answer.clear for answer in walls)
    note = f"of {len(walls)}; looked at every {FINE:g} rad"
    found.append(Row("V-B walls: plans that say success and go through", through, "", 0, "==", "", note))
    found += _time_rows([answer for mine in default for answer in mine])
    for (method, kind), mine in answers.items():
        if method:
            found.append(_share_row(f"V-B {kind}, {method}", mine, None, ELSEWHERE.get((method, kind), "")))
    return found


def rmse(states: Array) -> float:
    """Rad per joint of states (n, 3) against the optimum at their own tool positions."""
    best = followed(forward(states), WEIGHTED_REACHING)
    found = float(np.sqrt(np.mean((states - best) ** 2)))
    return found if np.isfinite(found) else np.inf


def _share(count: int, index: int, parts: int) -> int:
    """Of `count`, dealt to equal parts."""
    return count // parts + (index < count % parts)


def _share_row(name: str, answers: list[Answer], target: float | None, elsewhere: str = "") -> Row:
    good = sum(answer.good for answer in answers)
    said = [answer for answer in answers if answer.plan.success]
    wrong = {
        "say that they failed": len(answers) - len(said),
        "say success but come too near": sum(not answer.clear for answer in said),
        "say success but are off the manifold": sum(answer.clear and not answer.good for answer in said),
    }
    notes = [f"{good} of {len(answers)}", *(f"{count} {words}" for words, count in wrong.items() if count)]
    notes += [f"another implementation {elsewhere}"] if elsewhere else []
    return Row(name, good / max(len(answers), 1), "share", target, ">=", "", "; ".join(notes))


def _time_rows(answers: list[Answer]) -> list[Row]:
    times = 1e3 * np.array([answer.seconds for answer in answers])
    first = 1e3 * np.array([answer.plan.stats.get("seconds_to_first", np.nan) for answer in answers])
    points = np.median([len(answer.case.points) for answer in answers])
    note = (
        f"{len(times)} plans, {points:g} obstacle points, by the clock of their thread; first valid path "
        f"{np.nanmedian(first):.2g} ms by the wall's"
    )
    return [
        Row("plan around obstacles, D = 3, median", float(np.median(times)), "ms", 5.0, "<", "", note),
        Row("plan around obstacles, D = 3, p95", float(np.quantile(times, 0.95)), "ms", 20.0, "<"),
    ]
