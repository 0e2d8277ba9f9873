"""How planned paths get shorter with time, and how the reduced envelope turns them toward what was demonstrated."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skillfold.experiments.keyframe_runs import ALPHAS, THIRD, Answer, Learnt, ask, named, ready
from skillfold.experiments.parallel import in_parallel
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array

SOON, LATE = 0.1, 3.0  # seconds


def cost_rows(skills: Sequence[Learnt], seeds: int, settings: Settings, late: float = LATE) -> list[Row]:
    """Cost soon after the question beside the cost later, of the same runs."""
    found = []
    for number, learnt in enumerate(skills):
        settings.progress("keyframes: cost over time", 0.3 + 0.15 * number / len(skills))
        for seed in range(seeds):
            start = learnt.start([settings.seed, 6, learnt.draw, seed])
            found += [ask(learnt, start, a, seed, stop="time", time_limit=late) for a in ALPHAS]
    costs = [answer.plan.stats["costs"] for answer in found if answer.plan.success]
    above = np.array([cost_at(c, SOON) / c[-1][1] - 1.0 for c in costs] or [np.nan])
    rising = sum(bool((np.diff([cost for _, cost in c]) > 0.0).any()) for c in costs)
    note = f"{len(costs)} of {len(found)} plans; p95 {np.quantile(above, 0.95):.3g}; none after {SOON:g} s: the first"
    return [
        Row(
            f"cost after {SOON:g} s above that after {late:g} s, median",
            float(np.median(above)),
            "",
            0.1,
            "<=",
            "",
            note,
        ),
        Row("plans whose cost rises with time", float(rising), "", 0, "==", "", f"{len(costs)} plans"),
    ]


def cost_at(costs: Sequence[tuple[float, float]], seconds: float) -> float:
    """Cost of the best path after so many seconds; of the first where there was none."""
    there = [cost for time, cost in costs if time <= seconds]
    return there[-1] if there else costs[0][1]


def turned_rows(skills: Sequence[Learnt], seeds: int, settings: Settings) -> list[Row]:
    """Off-axis motion along the parent's principal direction in the first third, α 85 against 100, by draw."""
    cases = [(*named(learnt), settings.seed, seeds) for learnt in skills]
    all_of = in_parallel(_turned_means, cases, settings.progress, "keyframes: direction of paths", (0.45, 0.7))
    found: dict[str, list[Array]] = {}
    for learnt, means in zip(skills, all_of, strict=True):
        found.setdefault(learnt.task.name, []).append(means)
    return [
        row for name, target in zip(found, (0.01, None), strict=False) for row in _turned(name, found[name], target)
    ]


def _turned_means(task: int, draw: int, seed: int, seeds: int) -> Array:
    """Of one skill, (2, 3): what `turned` tells at each α, mean over the starts."""
    learnt, _ = ready(task, draw, seed)
    starts = [learnt.start([seed, 7, draw, i]) for i in range(seeds)]
    answers = [[ask(learnt, q, alpha, i) for i, q in enumerate(starts)] for alpha in ALPHAS]
    each = [[turned(learnt, a) for a in some if a.plan.success] or [(np.nan,) * 3] for some in answers]
    return np.array([np.mean(some, axis=0) for some in each])


def _turned(task: str, values: Sequence[Array], target: float | None) -> list[Row]:
    """Of metres along the direction, metres across it and the share along it (3,), at each α, by draw."""
    whole, reduced = np.array([v for v in values if np.isfinite(v).all()]).swapaxes(0, 1)
    p, across, share = (_above(reduced[:, k], whole[:, k]) for k in range(3))
    a, b = whole.mean(axis=0) * [100, 100, 1], reduced.mean(axis=0) * [100, 100, 1]
    note = (
        f"{a[0]:.2g} cm at α 100, {b[0]:.2g} at α 85, {len(whole)} draws, Wilcoxon, one-sided; "
        f"across that direction {a[1]:.2g} and {b[1]:.2g} cm (p = {across:.2g})"
    )
    said = f"{a[2]:.3f} at α 100; p = {share:.2g}"
    name = f"{task}, first third: off-axis motion along the parent's direction"
    if target is not None and 0.5 ** len(whole) >= target:  # the least p that so many draws can come to
        target, note = None, f"{note}; too few draws to tell"
    return [
        Row(f"{name}, α 85 over 100, p", p, "", target, "<", "", note),
        Row(f"{name}, as a share, α 85", float(b[2]), "", None, ">", "", said),
    ]


def _above(first: Array, second: Array) -> float:
    """How likely pairs (n,) are so much larger in the first by chance."""
    from scipy.stats import wilcoxon

    found: Any = wilcoxon(first, second, alternative="greater")
    return float(found.pvalue)


def turned(learnt: Learnt, answer: Answer) -> tuple[float, float, float]:
    """The tool's motion off the axis in its first third; by the parent's main direction, as `off_axis` tells it."""
    parent, child = learnt.envelope.parent, learnt.envelope.child
    axis = child.mean[:3] - parent.mean[:3]
    places = learnt.task.robot.forward(answer.plan.path.states)[:, :3] - parent.mean[:3]
    return off_axis(places, axis, np.linalg.eigh(parent.covariance[:3, :3])[1][:, -1])


def off_axis(places: Array, axis: Array, direction: Array) -> tuple[float, float, float]:
    """Of a way (n, 3) from near the origin along an axis (3,): how far it goes off the axis, in its first third.

    Metres along a direction and across it, and the share that goes along it, 0 where nothing goes off.
    """
    length = np.linalg.norm(axis)
    axis = axis / length
    beyond = places @ axis > THIRD * length
    steps = np.diff(places[: int(beyond.argmax()) if beyond.any() else len(places)], axis=0)
    across = steps - np.outer(steps @ axis, axis)
    along = direction - (direction @ axis) * axis
    along = along / np.linalg.norm(along)
    whole, part = float(np.linalg.norm(across, axis=1).sum()), float(np.abs(across @ along).sum())
    return part, float(np.abs(across @ np.cross(axis, along)).sum()), part / whole if whole > 0.0 else 0.0
