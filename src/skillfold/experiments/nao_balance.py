"""Section VII-C and Table II of paper 000: a Nao balances on its left leg, the right foot anywhere it can reach.

The skill is learnt from optimised poses with the defaults that a user gets. Random states, uniform within the joint
limits, are projected onto it; geodesics lead from each projected state to the next. Poses along these are held one by
one, as the projections are; harder yet, they are played as motions, in which a foot must not drag. Neither knows of
the floor, and both may put the free foot into it: what balances is judged on a pedestal and on flat ground, and
motions again on flat ground with the floor known. The optimum of a projected state is the optimised pose whose swing
foot is where the projection put it. The paper does not tell from how many poses it learnt: twice 500, and 500 as
where it walks.
"""

from collections.abc import Callable
from dataclasses import dataclass
from time import thread_time
from typing import Any, TypeVar

import numpy as np

from skillfold.experiments.nao_floor import Known, around, known, led_out
from skillfold.experiments.nao_poses import Found, Optimiser
from skillfold.experiments.nao_stability import Verdict, judge_motion, judge_pose
from skillfold.experiments.parallel import in_parallel
from skillfold.experiments.rows import Settings
from skillfold.motion import Array

LOWER, UPPER = np.array([-0.20, -0.20, 0.0]), np.array([0.20, -0.05, 0.15])  # m: Equation 24
REPEATS = 5  # of a call that is timed
DRAWN, FEWEST = 4, 20  # foot positions at a time: so many for each pose that is missing, one in five is in reach
FEW_POINTS = 10  # states of a geodesic that is to be had sooner: as many as the paper's demonstrations have

T = TypeVar("T")


@dataclass(frozen=True)
class Counts:
    """How much is measured: poses learnt from, each with a skill of its own, trials, and poses of each geodesic."""

    samples: tuple[int, ...] = (1000, 500)
    trials: int = 50
    held: int = 10

    @classmethod
    def of(cls, settings: Settings) -> "Counts":
        """All, or few for a first look."""
        return cls((150,), 10, 3) if settings.quick else cls()


@dataclass(frozen=True)
class Seconds:
    """Of the thread that worked.

    Attributes:
        projecting: one state.
        planning, coarsely: one geodesic, and one with few states.
        optimising, differencing: the same pose, with analytic derivatives and with finite differences.
    """

    projecting: float
    planning: float
    coarsely: float
    optimising: float
    differencing: float


@dataclass(frozen=True)
class Trial:
    """One random state, projected, and the way to it.

    Attributes:
        state, projected: (12,).
        best: optimum at the foot position of the projection.
        by_differences: the same by finite differences.
        plan: from the projection before.
        seconds: that each took.
        random: verdict of the random state.
        verdicts: of projection and plan, played as a motion, on a pedestal and on flat ground.
        held: the same of poses along the plan, each held on its own.
        floor: what comes of it where the floor is known.
    """

    state: Array
    projected: Array
    best: Found
    by_differences: Found
    plan: Any
    seconds: Seconds
    random: Verdict
    verdicts: tuple[tuple[Verdict, Verdict], tuple[Verdict, Verdict]]
    held: list[tuple[Verdict, Verdict]]
    floor: Known

    @property
    def error(self) -> float:
        """RMS over the joints between projection and optimum [rad]."""
        return float(np.sqrt(np.mean((self.projected - self.best.pose) ** 2)))


@dataclass(frozen=True)
class Drawn:
    """Optimal poses (n, 12) at random foot positions, and foot positions (m, 3) that were out of reach."""

    poses: Array
    missed: Array


@dataclass(frozen=True)
class Table:
    """Table II for one skill.

    Attributes:
        skill: that was learnt.
        demonstrations: (n, 12) poses it was learnt from.
        missed: (m, 3) foot positions that were out of reach.
        shown: verdicts of some of the demonstrations on a pedestal.
        trials: one for each random state.
    """

    skill: Any
    demonstrations: Array
    missed: Array
    shown: list[Verdict]
    trials: list[Trial]


def run(settings: Settings, counts: Counts) -> list[Table]:
    """The table for every number of samples, the first ones of the same poses."""
    optimiser, rng = Optimiser("left"), np.random.default_rng(settings.seed)
    drawn = balancing(optimiser, max(counts.samples), rng, settings)
    states = optimiser.robot.sample(counts.trials, settings.seed)
    some = rng.choice(len(drawn.poses), min(counts.trials, len(drawn.poses)), replace=False)
    shown = list(in_parallel(judge_pose, [(optimiser, q, True) for q in drawn.poses[some]]))
    tables, share = [], 0.6 / len(counts.samples)
    for number, samples in enumerate(counts.samples):
        begun, label = 0.3 + share * number, f"balance: {samples} poses"
        settings.progress(label, begun)
        poses = drawn.poses[:samples]
        skill = settings.learn(poses, space=optimiser.robot.space)
        between = begun + 0.3 * share, begun + share
        found = trials(optimiser, skill, states, counts.held, settings, label, between)
        tables.append(Table(skill, poses, drawn.missed, shown, found))
    return tables


def balancing(optimiser: Optimiser, number: int, rng: np.random.Generator, settings: Settings) -> Drawn:
    """So many optimal poses; what is out of reach is drawn again."""
    found: list[Array] = []
    missed: list[Array] = []
    label = "balance: optimising poses"
    while len(found) < number:
        feet = rng.uniform(LOWER, UPPER, (max(DRAWN * (number - len(found)), FEWEST), 3))
        cases = [(optimiser, part) for part in np.array_split(feet, len(feet) // 20)]
        for part, poses in zip(cases, in_parallel(optimise_all, cases), strict=True):
            for foot, pose in zip(part[1], poses, strict=True):
                if len(found) == number:
                    break
                found.append(pose.pose) if pose.reached else missed.append(foot)
            settings.progress(label, 0.3 * len(found) / number)
    return Drawn(np.array(found), np.array(missed).reshape(-1, 3))


def optimise_all(optimiser: Optimiser, feet: Array) -> list[Found]:
    """The optimal pose at each foot position (n, 3)."""
    return [optimiser.optimise(optimiser.over_foot(foot)) for foot in feet]


def trials(
    optimiser: Optimiser,
    skill: Any,
    states: Array,
    held: int,
    settings: Settings,
    label: str = "",
    between: tuple[float, float] = (0.0, 1.0),
) -> list[Trial]:
    """A trial for each state (n, 12), each begun where the one before ends; so many poses of each way are held."""
    places = [np.asarray(skill.project(q)) for q in (optimiser.robot.home, *states)]
    obstacles = around(optimiser)
    clear = [led_out(skill, obstacles, q) for q in places]
    pairs = zip(states, places, places[1:], clear, clear[1:], strict=False)
    cases = [(optimiser, skill, held, *case) for case in pairs]
    return list(in_parallel(trial, cases, settings.progress, label, between))


def trial(
    optimiser: Optimiser,
    skill: Any,
    held: int,
    state: Array,
    start: Array,
    projected: Array,
    clear_start: Array,
    clear: Array,
) -> Trial:
    """Everything that is asked of one state (12,), its projection and the one before."""
    projecting, _ = timed(lambda: skill.project(state))
    planning, plan = timed(lambda: skill.plan(start, projected))
    coarsely, _ = timed(lambda: skill.plan(start, projected, FEW_POINTS))
    asked = optimiser.over_foot(optimiser.robot.forward(projected, optimiser.robot.swing)[:3])
    optimising, best = timed(lambda: optimiser.optimise(asked))
    differencing, again = timed(lambda: optimiser.optimise(asked, analytic=False))
    states = plan.path.states
    some = states[np.linspace(0, len(states) - 1, held).round().astype(int)]
    return Trial(
        state,
        projected,
        best,
        again,
        plan,
        Seconds(projecting, planning, coarsely, optimising, differencing),
        judge_pose(optimiser, state, True),
        (both_grounds(optimiser, projected[None]), both_grounds(optimiser, states)),
        [both_grounds(optimiser, q[None]) for q in some],
        known(optimiser, skill, clear_start, clear),
    )


def both_grounds(optimiser: Optimiser, states: Array) -> tuple[Verdict, Verdict]:
    """A pose or motion (n, 12) judged on a pedestal and on flat ground."""
    return judge_motion(optimiser, states, pedestal=True), judge_motion(optimiser, states)


def timed(work: Callable[[], T], repeats: int = REPEATS) -> tuple[float, T]:
    """Seconds of this thread (median of a few calls, the first of which may compile) and what the work returns."""
    times, answers = [], []
    for _ in range(repeats):
        begun = thread_time()
        answers.append(work())
        times.append(thread_time() - begun)
    return float(np.median(times)), answers[-1]
