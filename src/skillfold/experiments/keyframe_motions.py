"""How planned paths get shorter with time, and how the reduced envelope turns them toward what was demonstrated."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skillfold.experiments.keyframe_runs import ALPHAS, THIRD, Answer, Learnt, ask
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
    found: dict[str, list[Array]] = {}
    for number, learnt in enumerate(skills):
        settings.progress("keyframes: direction of paths", 0.45 + 0.15 * number / len(skills))
        starts = [learnt.start([settings.seed, 7, learnt.draw, seed]) for seed in range(seeds)]
        answers = [[ask(learnt, q, alpha, i) for i, q in enumerate(starts)] for alpha in ALPHAS]
        mine = [
            np.mean([turned(a) for a in some if a.plan.success] or [(np.nan, np.nan)], axis=0) for some in answers
        ]
        found.setdefault(learnt.task.name, []).append(np.array(mine))
    targets = (0.01, None)
    return [_turned_row(*named, target) for named, target in zip(found.items(), targets, strict=False)]


def _turned_row(task: str, values: Sequence[Array], target: float | None) -> Row:
    """Of share and metres (2,) at each α, by draw."""
    whole, reduced = np.array([v for v in values if np.isfinite(v).all()]).swapaxes(0, 1)
    p, q = (_above(reduced[:, k], whole[:, k]) for k in range(2))
    (a, b), (c, d) = whole.mean(axis=0), reduced.mean(axis=0)
    note = (
        f"share of the motion off the axis {a:.3f} at α 100, {c:.3f} at α 85, {len(whole)} draws (Wilcoxon, one-sided); "
        f"in centimetres {100 * b:.3g} and {100 * d:.3g}, p = {q:.2g}"
    )
    return Row(f"{task}: along the parent's direction in the first third, p", p, "", target, "<", "", note)


def _above(first: Array, second: Array) -> float:
    """p that pairs (n,) are not larger in the first."""
    from scipy.stats import wilcoxon

    found: Any = wilcoxon(first, second, alternative="greater")
    return float(found.pvalue)


def turned(answer: Answer) -> tuple[float, float]:
    """Of the tool's motion across the axis, in the first third of it, what goes along the parent's main direction.

    Share of it, and metres.
    """
    parent, child = answer.learnt.envelope.parent, answer.learnt.envelope.child
    axis = child.mean[:3] - parent.mean[:3]
    places = answer.learnt.task.robot.forward(answer.plan.path.states)[:, :3] - parent.mean[:3]
    return off_axis(places, axis, np.linalg.eigh(parent.covariance[:3, :3])[1][:, -1])


def off_axis(places: Array, axis: Array, direction: Array) -> tuple[float, float]:
    """Of a way (n, 3) from near the origin along an axis (3,): how far its steps across go along a direction.

    Until a third of the axis is behind it; as a share of all that goes across, 0 where nothing does, and in metres.
    """
    length = np.linalg.norm(axis)
    axis = axis / length
    beyond = places @ axis > THIRD * length
    steps = np.diff(places[: int(beyond.argmax()) + 1 if beyond.any() else len(places)], axis=0)
    across = steps - np.outer(steps @ axis, axis)
    along = direction - (direction @ axis) * axis
    along = along / np.linalg.norm(along)
    whole, part = float(np.linalg.norm(across, axis=1).sum()), float(np.abs(across @ along).sum())
    return (part / whole if whole > 0.0 else 0.0), part
