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
from skillfold.experiments.nao_steps import POINTS, Example, Skills, Stepper, examples, learn, same_pace
from skillfold.experiments.parallel import in_parallel
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

    @classmethod
    def of(cls, settings: Settings) -> "Counts":
        """All, or few for a first look."""
        return cls(20, 4, 4, 4) if settings.quick else cls()


@dataclass(frozen=True)
class Seconds:
    """Of the thread that worked.

    Attributes:
        planning: swing and weight shift.
        optimising, differencing: the whole step, with analytic derivatives and with finite differences.
    """

    planning: float
    optimising: float
    differencing: float


@dataclass(frozen=True)
class Trial:
    """A new step.

    Attributes:
        example: the same step, optimised.
        plans: of swing and weight shift.
        along: (2, 10) RMS to the optimum at its own foot and pelvis, of states along both phases [rad].
        paced: RMS of both phases to the optimised step at the same share of its way [rad].
        seconds: that each took.
        verdicts: of each phase.
    """

    example: Example
    plans: tuple[Any, Any]
    along: Array
    paced: float
    seconds: Seconds
    verdicts: tuple[Verdict, Verdict]

    @property
    def errors(self) -> Array:
        """(2,) RMS over each phase [rad]."""
        return np.sqrt(np.mean(self.along**2, axis=1))


@dataclass(frozen=True)
class Stepping:
    """All that the rows and the pictures tell of."""

    skills: dict[str, Skills]
    trials: list[Trial]
    around: list[nao_around.Answer]
    walk: nao_walk.Walk


def measure(settings: Settings, counts: Counts | None = None) -> list[Row]:
    """Rows of new steps, of steps past obstacles and of the walk."""
    return rows(run(settings, counts or Counts.of(settings)))


def run(settings: Settings, counts: Counts) -> Stepping:
    """Learn for both legs, step, step past obstacles, walk."""
    rng = np.random.default_rng(settings.seed)
    skills = {}
    for number, side in enumerate(SIDES):
        settings.progress(f"stepping: optimising steps on the {side} foot", 0.15 * number)
        skills[side] = learn(settings, examples(side, counts.shown, rng))
    found = trials(skills, counts.trials, rng, settings)
    around = nao_around.past(skills, counts.obstacles, rng, settings)
    settings.progress("stepping: a walk", 0.9)
    return Stepping(skills, found, around, nao_walk.walk(skills, counts.walk, rng))


def trials(skills: dict[str, Skills], number: int, rng: np.random.Generator, settings: Settings) -> list[Trial]:
    """New random steps, on either foot in turn."""
    shown = {side: examples(side, len(range(i, number, 2)), rng) for i, side in enumerate(SIDES)}
    sides = [SIDES[i % 2] for i in range(number)]
    cases = [(skills[side], shown[side][i // 2]) for i, side in enumerate(sides)]
    return list(in_parallel(trial, cases, settings.progress, "stepping: new steps", (0.3, 0.6)))


def trial(skills: Skills, example: Example) -> Trial:
    """The step of an example, planned; what is timed is done once before."""
    step, stepper = example.step, Stepper(example.step.side)
    apex = stepper.optimiser.optimise(stepper.swinging(step, 0.5)).pose
    (swinging, swing), (shifting, shift) = timed_plans(skills, example, apex)
    optimising, _ = timed(lambda: stepper.example(step), 1)
    differencing, _ = timed(lambda: stepper.example(step, analytic=False), 1)
    robot = stepper.optimiser.robot

    def asked(q: Array) -> Asked:
        return Asked(robot.forward(q, robot.swing)[:3], robot.forward(q, "Torso")[:2])

    def over(q: Array) -> Asked:
        return stepper.optimiser.over_foot(robot.forward(q, robot.swing)[:3])

    along = [stepper.errors(plan.path.states, best, CHECKED) for plan, best in ((swing, over), (shift, asked))]
    pairs = ((swing, example.swing), (shift, example.shift))
    paced = float(np.sqrt(np.mean([np.mean(same_pace(plan.path.states, poses) ** 2) for plan, poses in pairs])))
    verdicts = (
        judge_motion(stepper.optimiser, swing.path.states),
        judge_motion(stepper.optimiser, shift.path.states, stepper.soles(step)),
    )
    seconds = Seconds(swinging + shifting, optimising, differencing)
    return Trial(example, (swing, shift), np.array(along), paced, seconds, verdicts)


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
        *_time_rows(found),
        _stable_row(found),
        *nao_around.rows(stepping.around),
        nao_walk.row(stepping.walk),
    ]


def _error_rows(stepping: Stepping) -> list[Row]:
    errors = np.array([trial.errors for trial in stepping.trials])
    whole = np.sqrt(np.mean(errors**2, axis=1))
    said = np.array([[plan.success for plan in trial.plans] for trial in stepping.trials]).sum(0)
    dims = ", ".join(f"{skills.swing.dim} and {skills.shift.dim}" for skills in stepping.skills.values())
    shown = sum(len(skills.examples) for skills in stepping.skills.values()) // len(stepping.skills)
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
            f"{len(whole)} plans {said[0]} and {said[1]} say success; learnt from {shown} steps of each leg; "
            f"dimensions of swing and shift {dims}",
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


def _time_rows(found: list[Trial]) -> list[Row]:
    seconds = [(trial.seconds.planning, trial.seconds.optimising, trial.seconds.differencing) for trial in found]
    planning, optimising, differencing = np.median(seconds, axis=0)
    swing, shift = (len(plan.path.states) for plan in found[0].plans)
    plans = f"plans of {swing} and {shift} states {1e3 * planning:.1f} ms"
    told = (
        f"{plans}, twenty optimised poses {1e3 * taken:.0f} ms; medians, of the thread"
        for taken in (differencing, optimising)
    )
    name = "Nao's new steps: plan, times faster than optimisation"
    alike = (swing + shift) / (2 * POINTS)  # as often as optimised steps have fewer states
    return [
        Row(f"{name} by finite differences", differencing / planning, "×", None, ">", "30", next(told)),
        Row(f"{name} with analytic derivatives", optimising / planning, "×", FASTER, ">", "", next(told)),
        Row(
            f"{name} by finite differences of as many poses as the plans have states",
            alike * differencing / planning,
            "×",
            paper="30",
            note=f"with analytic derivatives {alike * optimising / planning:.0f}",
        ),
    ]


def _stable_row(found: list[Trial]) -> Row:
    counts = [count([trial.verdicts[phase] for trial in found]) for phase in (0, 1)]
    stable = sum(all(verdict.stable for verdict in trial.verdicts) for trial in found)
    note = f"swings {counts[0].note}; shifts {counts[1].note}"
    return Row("Nao's new steps: stable by both judges", stable / len(found), "share", None, ">=", "", note)
