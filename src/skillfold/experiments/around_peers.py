"""OMPL's planners against ours: the same learnt manifold, the same cases, one after the other."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.errors import MissingExtraError
from skillfold.experiments import around_tray, tray
from skillfold.experiments.around_tray import Answer
from skillfold.experiments.ompl_peer import SPACES, OmplPeer, PeerPlan
from skillfold.experiments.rows import Row, Settings
from skillfold.experiments.tray_cases import SceneCase
from skillfold.motion import Array

SECONDS = 5.0  # that OMPL may take
WARM = 2  # cases that do not count: the first compile
FASTER = 2.0  # that ours must be


@dataclass(frozen=True)
class Race:
    """Our answer to a case, and OMPL's by space."""

    ours: Answer
    theirs: dict[str, PeerPlan]


def rows(skill: Any, cases: Sequence[SceneCase], settings: Settings) -> list[Row]:
    """Ours and each of OMPL's spaces, side by side; without figures where OMPL is not installed."""
    settings.progress("past boxes: OMPL", 0.8)
    try:
        races = [_race(skill, case) for case in (*cases[:WARM], *cases)][len(cases[:WARM]) :]
    except MissingExtraError as error:
        return [replace(row, note=str(error)) for space in SPACES for row in compare([], space)]
    return [row for space in SPACES for row in compare(races, space)]


def compare(races: Sequence[Race], space: str) -> list[Row]:
    """First valid path, whole plan, share solved, length."""
    both = [(race.ours, race.theirs[space]) for race in races]
    return [
        _first_row(np.array([(_first(a), p.first_seconds) for a, p in both]).reshape(-1, 2), space),
        _whole_row(np.array([(a.seconds, p.seconds) for a, p in both]).reshape(-1, 2), space),
        _solved_row(both, space),
        _length_row(np.array([(a.plan.length, p.length) for a, p in both if a.valid and p.solved]), space),
    ]


def _race(skill: Any, case: SceneCase) -> Race:
    """By the wall's clock, both. OMPL's planner is made before it starts; we read the obstacles within the whole."""
    ours = around_tray.answer(skill, case, perf_counter)
    theirs = {}
    for space in SPACES:
        peer = OmplPeer(skill, tray.arm().obstacles(case.scene), space)
        theirs[space] = peer.plan(case.start, case.goal, time_limit=SECONDS)
    return Race(ours, theirs)


def _first_row(seconds: Array, space: str) -> Row:
    name = f"first valid path, median: OMPL's {space} space over ours"
    if not len(seconds):
        return Row(name, None, "×", FASTER, ">=")
    ours, theirs = 1e3 * np.median(seconds, axis=0)
    return Row(name, theirs / ours, "×", FASTER, ">=", "", f"{theirs:.3g} over {ours:.3g} ms; {len(seconds)} cases")


def _whole_row(seconds: Array, space: str) -> Row:
    name = f"whole plan, p95: OMPL's {space} space over ours"
    if not len(seconds):
        return Row(name, None, "×", FASTER, ">=")
    ours, theirs = 1e3 * np.quantile(seconds, 0.95, axis=0)
    median = 1e3 * np.median(seconds, axis=0)
    note = f"{theirs:.3g} over {ours:.3g} ms; medians {median[1]:.3g} and {median[0]:.3g} ms"
    return Row(name, theirs / ours, "×", FASTER, ">=", "", note)


def _solved_row(both: Sequence[tuple[Answer, PeerPlan]], space: str) -> Row:
    name = f"cases solved, the share of OMPL's {space} space as its target"
    if not both:
        return Row(name, None, "share", None, ">=")
    ours, theirs = (float(np.mean(column)) for column in zip(*[(a.valid, p.solved) for a, p in both], strict=True))
    right = sum(p.solved and _holds(a, p) for a, p in both)
    note = f"{len(both)} cases; of OMPL's paths {right} are valid at every {around_tray.FINE:g} rad, as ours must be"
    return Row(name, ours, "share", theirs, ">=", "", note)


def _length_row(lengths: Array, space: str) -> Row:
    name = f"length of our plans over OMPL's in its {space} space, mean"
    if not len(lengths):
        return Row(name, None, "", 1.0, "<")
    shorter = int((lengths[:, 0] < lengths[:, 1]).sum())
    ratio = float((lengths[:, 0] / lengths[:, 1]).mean())
    return Row(name, ratio, "", 1.0, "<", "", f"shorter in {shorter} of {len(lengths)} that both solved")


def _first(answer: Answer) -> float:
    """Seconds to our first valid path, once ends and obstacles were read; all that we took where there is none."""
    return answer.plan.stats["seconds_to_first"] if answer.plan.success else answer.seconds


def _holds(answer: Answer, plan: PeerPlan) -> bool:
    clearance, tilts, within = around_tray.judge(answer.case, plan.states)
    return clearance > 0.0 and within and float(tilts.max()) < around_tray.LEVEL
