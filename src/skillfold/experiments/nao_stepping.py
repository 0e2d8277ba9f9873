"""Section VII-A of paper 000: new steps of a Nao as geodesics, against optimised steps; and a walk of ten.

A new step is asked by three poses: where the swing starts, how high it is half way, where it lands. The swing is the
geodesic through them, the weight shift the geodesic from its end. Each state of both is compared with the optimised
pose whose swing foot and pelvis are where that state puts them, as in the experiments on arms. Skills are learnt with
the defaults that a user gets, where the paper sets dimension 4 and 20 kernels.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.experiments import nao_around, nao_walk
from skillfold.experiments.nao_balance import timed
from skillfold.experiments.nao_poses import Asked
from skillfold.experiments.nao_stability import Verdict, count, judge_motion
from skillfold.experiments.nao_steps import Example, Skills, Stepper, examples, learn, same_pace
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array
from skillfold.robots.standing import SIDES

RMSE, FASTER = 0.05, 1000.0
CHECKED = 10  # states of each phase that are compared with the optimum


@dataclass(frozen=True)
class Counts:
    """How much is measured: steps learnt from for each leg, new steps, steps past obstacles, steps of the walk."""

    shown: int = 50
    trials: int = 50
    obstacles: int = 50
    walk: int = 10


@dataclass(frozen=True)
class Trial:
    """A new step.

    Attributes:
        example: the same step, optimised.
        plans: of swing and weight shift.
        errors: RMS of each phase to the optimum at its own foot and pelvis [rad].
        paced: RMS of both phases to the optimised step at the same share of its way [rad].
        seconds: of both plans, and of the optimisation of the whole step.
        verdicts: of each phase.
    """

    example: Example
    plans: tuple[Any, Any]
    errors: tuple[float, float]
    paced: float
    seconds: tuple[float, float]
    verdicts: tuple[Verdict, Verdict]


@dataclass(frozen=True)
class Stepping:
    """All that the rows and the pictures tell of."""

    skills: dict[str, Skills]
    trials: list[Trial]
    around: list[nao_around.Answer]
    walk: nao_walk.Walk


def measure(settings: Settings, counts: Counts | None = None) -> list[Row]:
    """Rows of new steps, of steps past obstacles and of the walk."""
    return rows(run(settings, counts or Counts()))


def run(settings: Settings, counts: Counts) -> Stepping:
    """Learn for both legs, step, step past obstacles, walk."""
    rng = np.random.default_rng(settings.seed)
    skills = {}
    for number, side in enumerate(SIDES):
        settings.progress(f"stepping: optimising steps on the {side} foot", 0.2 * number)
        skills[side] = learn(settings, examples(side, counts.shown, rng))
    settings.progress("stepping: new steps", 0.4)
    sides = [SIDES[i % 2] for i in range(counts.trials)]
    trials = [trial(skills[side], examples(side, 1, rng)[0]) for side in sides]
    settings.progress("stepping: past obstacles", 0.7)
    around = [nao_around.ask(skills[case.side], case) for case in nao_around.cases(skills, counts.obstacles, rng)]
    settings.progress("stepping: a walk", 0.9)
    return Stepping(skills, trials, around, nao_walk.walk(skills, counts.walk, rng))


def trial(skills: Skills, example: Example) -> Trial:
    """The step of an example, planned; plans are made once before they are timed."""
    step, stepper = example.step, Stepper(example.step.side)
    apex = stepper.optimiser.optimise(stepper.swinging(step, 0.5)).pose
    (swinging, swing), (shifting, shift) = timed_plans(skills, example, apex)
    optimising, _ = timed(lambda: stepper.example(step), 1)
    robot = stepper.optimiser.robot

    def asked(q: Array) -> Asked:
        return Asked(robot.forward(q, robot.swing)[:3], robot.forward(q, "Torso")[:2])

    def over(q: Array) -> Asked:
        return stepper.optimiser.over_foot(robot.forward(q, robot.swing)[:3])

    errors = stepper.error(swing.path.states, over, CHECKED), stepper.error(shift.path.states, asked, CHECKED)
    pairs = ((swing, example.swing), (shift, example.shift))
    paced = float(np.sqrt(np.mean([np.mean(same_pace(plan.path.states, poses) ** 2) for plan, poses in pairs])))
    verdicts = (
        judge_motion(stepper.optimiser, swing.path.states),
        judge_motion(stepper.optimiser, shift.path.states, stepper.soles(step)),
    )
    return Trial(example, (swing, shift), errors, paced, (swinging + shifting, optimising), verdicts)


def timed_plans(skills: Skills, example: Example, apex: Array) -> list[tuple[float, Any]]:
    """Seconds and plan of the swing, and of the weight shift."""
    return [
        timed(lambda: skills.swing.plan(example.swing[0], example.swing[-1], via=apex[None])),
        timed(lambda: skills.shift.plan(example.shift[0], example.shift[-1])),
    ]


def rows(stepping: Stepping) -> list[Row]:
    """Every row."""
    found = stepping.trials
    return [
        *_error_rows(stepping),
        _time_row(found),
        _stable_row(found),
        *nao_around.rows(stepping.around),
        nao_walk.row(stepping.walk),
    ]


def _error_rows(stepping: Stepping) -> list[Row]:
    errors = np.array([trial.errors for trial in stepping.trials])
    whole = np.sqrt(np.mean(errors**2, axis=1))
    said = np.array([[plan.success for plan in trial.plans] for trial in stepping.trials]).sum(0)
    dims = ", ".join(f"{skills.swing.dim} and {skills.shift.dim}" for skills in stepping.skills.values())
    paced = np.array([trial.paced for trial in stepping.trials])
    return [
        Row(
            "Nao's new steps: RMSE to the optimum at each state's own foot and pelvis",
            float(whole.mean()),
            "rad",
            RMSE,
            "<=",
            "0.1",
            f"swing {errors[:, 0].mean():.1e}, shift {errors[:, 1].mean():.1e}, largest {errors.max():.1e}; of "
            f"{len(whole)} plans {said[0]} and {said[1]} say success; dimensions of swing and shift {dims}",
        ),
        Row(
            "Nao's new steps: RMSE to the optimised step at the same share of its way",
            float(paced.mean()),
            "rad",
            RMSE,
            "<=",
            "0.1",
            f"largest {paced.max():.1e}; geodesics need not follow the sinusoid",
        ),
    ]


def _time_row(found: list[Trial]) -> Row:
    planning, optimising = np.median([trial.seconds for trial in found], axis=0)
    note = f"plans {1e3 * planning:.1f} ms, twenty optimised poses {1e3 * optimising:.0f} ms, medians"
    return Row(
        "Nao's new steps: plan, times faster than optimisation", optimising / planning, "×", FASTER, ">", "30", note
    )


def _stable_row(found: list[Trial]) -> Row:
    counts = [count([trial.verdicts[phase] for trial in found]) for phase in (0, 1)]
    stable = sum(all(verdict.stable for verdict in trial.verdicts) for trial in found)
    note = f"swings {counts[0].note}; shifts {counts[1].note}"
    return Row("Nao's new steps: stable by both judges", stable / len(found), "share", None, ">=", "", note)
