"""Tumblers that stand free on a carried tray, under pushes and past boxes (paper 000, section VI, carried further).

How a run goes stands in `tumbler_runs`, how boxes move in `tumbler_boxes`. Beside the skill's figures stand those of
a naive arm: a quintic in joint space, held by computed torque with the stiffness and damping that the skill's
controller has along the manifold; with the same stiffness damped critically; and as stiff as that controller is off
the manifold. With gains as high as these tumblers stand on the naive arm too, and it is the tilt that tells.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from skillfold.experiments.parallel import in_parallel
from skillfold.experiments.rows import Progress, Row, Settings
from skillfold.experiments.tumbler_boxes import JUMP, Passing, passing
from skillfold.experiments.tumbler_runs import (
    BODIES,
    FORCES,
    METHODS,
    Outcome,
    Trial,
    run,
    skill_of,
    trials,
)

RUNS = 50  # of each kind
KINDS = ("short", "slow")
STANDING = {"forearm": 0.95, "tool": 0.90}  # share of runs
TILT = 1 / 3  # of the naive arm's
PASSED = 0.95
LABELS = {"skill": "skill", "naive": "naive", "critical": "damped critically", "stiff": "stiffest"}
NAIVE_LABELS = {method: label for method, label in LABELS.items() if method != "skill"}
Outcomes = dict[str, list[Outcome]]


def measure(settings: Settings, runs: int = RUNS) -> list[Row]:
    """All rows: left alone, the four kinds of push, past boxes that move."""
    rng = np.random.default_rng([settings.seed, 6])
    settings.progress("tumblers: learning", 0.0)
    skill = skill_of(settings, rng)
    told = partial(_Told, settings.progress)
    alone = told("tumblers left alone", (0.05, 0.15))
    found = [_alone_row(compared(skill, trials(skill, runs, rng), METHODS[:2], alone))]
    for index, (kind, body) in enumerate((kind, body) for kind in KINDS for body in BODIES):
        pushed = told(f"tumblers, {kind} pushes on the {body}", (0.15 + 0.15 * index, 0.3 + 0.15 * index))
        found += _pushed_rows(kind, body, compared(skill, trials(skill, runs, rng, body, kind), METHODS, pushed))
    return [*found, *_passing_rows(passed(skill, runs, rng, told("tumblers past boxes that move", (0.75, 0.95))))]


@dataclass(frozen=True)
class _Told:
    """Who is told how far the work is, in which words, between which shares of all."""

    progress: Progress
    label: str = ""
    between: tuple[float, float] = (0.0, 1.0)


_NOBODY = _Told(lambda label, share: None)


def compared(skill: Any, asked: Sequence[Trial], methods: Sequence[str] = METHODS, told: _Told = _NOBODY) -> Outcomes:
    """Outcomes of the same trials by method."""
    cases = [(method, skill, trial) for method in methods for trial in asked]
    outcomes = list(in_parallel(run, cases, told.progress, told.label, told.between))
    return {method: outcomes[i * len(asked) : (i + 1) * len(asked)] for i, method in enumerate(methods)}


def passed(skill: Any, count: int, rng: np.random.Generator, told: _Told = _NOBODY) -> list[Passing]:
    """Runs past boxes, a fresh case each."""
    cases = [(int(seed),) for seed in rng.integers(2**31, size=count)]
    return list(in_parallel(partial(passing, skill), cases, told.progress, told.label, told.between))


def _alone_row(found: Outcomes) -> Row:
    everyone = [outcome for outcomes in found.values() for outcome in outcomes]
    tilts = ", ".join(f"{name} {_tilt(found[name]):.4f}" for name in ("skill", "naive"))
    note = f"{len(everyone)} runs, skill and naive; peak tilt, median: {tilts}"
    return Row("not pushed: runs with all three standing", _stood(everyone), "share", 1.0, ">=", "", note)


def _pushed_rows(kind: str, body: str, found: Outcomes) -> list[Row]:
    low, high = FORCES[kind]
    lasting = "0.1–0.3 s" if kind == "short" else "1.5 s"
    name = f"{kind} pushes on the {body}"
    naive = ", ".join(f"{label} {_stood(found[method]):.2f}" for method, label in NAIVE_LABELS.items())
    mine, other = _tilt(found["skill"]), _tilt(found["naive"])
    tilts = ", ".join(f"{label} {_tilt(found[method]):.4f}" for method, label in NAIVE_LABELS.items())
    gives = ", ".join(f"{label} {_gives(found[method])}" for method, label in LABELS.items())
    replans = np.mean([outcome.replans for outcome in found["skill"]])
    return [
        Row(
            f"{name}: runs with all three standing",
            _stood(found["skill"]),
            "share",
            STANDING[body],
            ">=",
            "",
            f"{low:.0f}–{high:.0f} N for {lasting}, {len(found['skill'])} runs; {naive}; {replans:.1f} replans a run",
        ),
        Row(
            f"{name}: peak tilt of the tray over the naive arm's at the same gains, medians",
            mine / other,
            "",
            TILT,
            "<=",
            "",
            f"skill {mine:.4f} rad; {tilts}; the tool gives way by (median, most): {gives}",
        ),
    ]


def _passing_rows(found: list[Passing]) -> list[Row]:
    touched, fell = sum(p.contacts > 0 for p in found), sum(p.standing < 3 for p in found)
    rough, lost = sum(not p.jump <= JUMP for p in found), sum(not p.arrived for p in found)
    note = (
        f"{len(found)} runs; {touched} touched, in {fell} a tumbler fell, in {rough} the reference jumped; "
        f"{np.mean([p.replans for p in found]):.1f} replans a run; clearance with room for standing tumblers "
        f"{np.nanmin([p.clearance for p in found]):.3f} m at least; largest jump "
        f"{np.nanmax([p.jump for p in found]):.2f} of the acceleration limit"
    )
    name = "past a box that moves into the way: no contact, smooth reference, all three standing"
    safe = float(np.mean([p.safe for p in found]))
    arrived = Row("and at the goal", 1.0 - lost / len(found), "share", PASSED, ">=")
    return [Row(name, safe, "share", PASSED, ">=", "", note), arrived]


def _stood(outcomes: Sequence[Outcome]) -> float:
    return float(np.mean([outcome.stood for outcome in outcomes]))


def _tilt(outcomes: Sequence[Outcome]) -> float:
    return float(np.median([outcome.tilt for outcome in outcomes]))


def _gives(outcomes: Sequence[Outcome]) -> str:
    gives = [outcome.gives for outcome in outcomes]
    return f"{1e3 * np.median(gives):.0f}, {1e3 * max(gives):.0f} mm"
