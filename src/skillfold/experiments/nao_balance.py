"""Section VII-C and Table II of paper 000: a Nao balances on its left leg, the right foot anywhere it can reach.

The skill is learnt from optimised poses with the defaults that a user gets. Random states, uniform within the joint
limits, are projected onto it; geodesics lead from each projected state to the next. Neither knows of the floor, and
both may put the free foot into it: what balances is judged on a pedestal and on flat ground. The optimum of a
projected state is the optimised pose whose swing foot is where the projection put it. The paper does not tell from
how many poses it learnt: 500, as where it walks, and twice as many.
"""

from dataclasses import dataclass
from time import thread_time
from typing import Any

import numpy as np

from skillfold.experiments.nao_poses import Found, Optimiser
from skillfold.experiments.nao_stability import Verdict, count, judge_motion, judge_pose
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array

LOWER, UPPER = np.array([-0.20, -0.20, 0.0]), np.array([0.20, -0.05, 0.15])  # m: Equation 24
KINDS = (("projected states", 47, "47"), ("geodesics", 46, "42"))  # how many of 50 must be stable; the paper's
RMSE, FASTER = 0.01, 1000.0
REPEATS = 5  # of a call that is timed


@dataclass(frozen=True)
class Counts:
    """How much is measured: poses learnt from, each with a skill of its own, and trials."""

    samples: tuple[int, ...] = (1000, 500)
    trials: int = 50


@dataclass(frozen=True)
class Trial:
    """One random state, projected, and the way to it.

    Attributes:
        state, projected: (12,).
        best: optimum at the foot position of the projection.
        plan: from the projection before.
        seconds: of projection, plan and optimisation.
        verdicts: of projection and plan, on a pedestal and on flat ground.
    """

    state: Array
    projected: Array
    best: Found
    plan: Any
    seconds: tuple[float, float, float]
    verdicts: tuple[tuple[Verdict, Verdict], tuple[Verdict, Verdict]]

    @property
    def error(self) -> float:
        """RMS over the joints between projection and optimum [rad]."""
        return float(np.sqrt(np.mean((self.projected - self.best.pose) ** 2)))


@dataclass(frozen=True)
class Table:
    """Table II for one skill."""

    skill: Any
    demonstrations: Array
    trials: list[Trial]


def measure(settings: Settings, counts: Counts | None = None) -> list[Row]:
    """Rows of the table for every number of samples."""
    return rows(run(settings, counts or Counts()), settings)


def run(settings: Settings, counts: Counts) -> list[Table]:
    """The table for every number of samples, the first ones of the same poses."""
    optimiser, rng = Optimiser("left"), np.random.default_rng(settings.seed)
    settings.progress("balance: optimising poses", 0.0)
    poses = balancing(optimiser, max(counts.samples), rng)
    states = optimiser.robot.sample(counts.trials, settings.seed)
    tables = []
    for number, samples in enumerate(counts.samples):
        settings.progress(f"balance: {samples} poses", 0.3 + 0.6 * number / len(counts.samples))
        skill = settings.learn(poses[:samples], space=optimiser.robot.space)
        tables.append(Table(skill, poses[:samples], trials(optimiser, skill, states)))
    return tables


def balancing(optimiser: Optimiser, number: int, rng: np.random.Generator) -> Array:
    """Optimal poses (number, 12) at random foot positions; what is out of reach is drawn again."""
    found: list[Array] = []
    while len(found) < number:
        pose = optimiser.optimise(optimiser.over_foot(rng.uniform(LOWER, UPPER)))
        if pose.reached:
            found.append(pose.pose)
    return np.array(found)


def trials(optimiser: Optimiser, skill: Any, states: Array) -> list[Trial]:
    """A trial for each state (n, 12)."""
    found: list[Trial] = []
    current = np.asarray(skill.project(optimiser.robot.home))
    skill.plan(current, skill.project(states[0]))  # the first call compiles
    for state in states:
        projecting, projected = timed(lambda state=state: skill.project(state))
        planning, plan = timed(lambda a=current, b=projected: skill.plan(a, b))
        foot = optimiser.robot.forward(projected, optimiser.robot.swing)[:3]
        optimising, best = timed(lambda foot=foot: optimiser.optimise(optimiser.over_foot(foot)))
        verdicts = both_grounds(optimiser, projected[None]), both_grounds(optimiser, plan.path.states)
        found.append(Trial(state, projected, best, plan, (projecting, planning, optimising), verdicts))
        current = projected
    return found


def both_grounds(optimiser: Optimiser, states: Array) -> tuple[Verdict, Verdict]:
    """A pose or motion (n, 12) judged on a pedestal and on flat ground."""
    return judge_motion(optimiser, states, pedestal=True), judge_motion(optimiser, states)


def timed(work: Any, repeats: int = REPEATS) -> tuple[float, Any]:
    """Seconds of this thread (median of a few calls) and what the work returns."""
    times, answer = [], None
    for _ in range(repeats):
        begun = thread_time()
        answer = work()
        times.append(thread_time() - begun)
    return float(np.median(times)), answer


def rows(tables: list[Table], settings: Settings) -> list[Row]:
    """All rows: first what does not depend on the skill."""
    return [*_given_rows(tables[0], settings), *(row for table in tables for row in _table_rows(table))]


def _given_rows(table: Table, settings: Settings) -> list[Row]:
    """Optimised poses as they were demonstrated, and random states."""
    optimiser, total = Optimiser("left"), len(table.trials)
    random = count([judge_pose(optimiser, trial.state, True) for trial in table.trials])
    shown = np.random.default_rng(settings.seed).choice(len(table.demonstrations), total, replace=False)
    best = count([judge_pose(optimiser, q, True) for q in table.demonstrations[shown]])
    black = [_black_box(optimiser, trial) for trial in table.trials]
    seconds = np.array([trial.seconds[2] for trial in table.trials])
    return [
        Row("Nao on one leg, optimised poses: stable", best.stable, "", None, ">=", "48", best.note),
        Row("Nao on one leg, random states: stable", random.stable, "", None, "<=", "0", random.note),
        Row(
            "Nao on one leg, optimisation of a pose",
            1e3 * float(np.median(seconds)),
            "ms",
            paper="38.35 s",
            note=f"analytic derivatives; {1e3 * np.median(black):.0f} ms with finite differences, as in the paper",
        ),
    ]


def _black_box(optimiser: Optimiser, trial: Trial) -> float:
    """Seconds of the same optimisation where the kinematics only answer for poses."""
    foot = optimiser.robot.forward(trial.projected, optimiser.robot.swing)[:3]
    begun = thread_time()
    optimiser.optimise(optimiser.over_foot(foot), analytic=False)
    return thread_time() - begun


def _table_rows(table: Table) -> list[Row]:
    name = f"Nao on one leg, {len(table.demonstrations)} poses"
    errors = np.array([trial.error for trial in table.trials])
    reached = sum(trial.best.reached for trial in table.trials)
    note = (
        f"median {np.median(errors):.1e}, p95 {np.percentile(errors, 95):.1e}, largest {errors.max():.1e}; optimum "
        f"within reach in {reached} of {len(errors)}; dimension {table.skill.dim} (of the foot's positions 3)"
    )
    error = Row(f"{name}: RMSE of projections to the optimum", float(errors.mean()), "rad", RMSE, "<=", "0.01", note)
    return [error, *_stable_rows(name, table.trials), *_time_rows(name, table)]


def _stable_rows(name: str, found: list[Trial]) -> list[Row]:
    said = sum(trial.plan.success for trial in found)
    rows = []
    for ground, where in enumerate(("on a pedestal", "on flat ground")):
        for kind, (what, needed, paper) in enumerate(KINDS):
            counted = count([trial.verdicts[kind][ground] for trial in found])
            note = f"{counted.note}; {said} plans say success" if kind else counted.note
            target = round(needed * len(found) / 50)
            row = Row(f"{name}: {what} stable by both judges {where}", counted.stable, "", target, ">=", paper, note)
            rows.append(row)
    return rows


def _time_rows(name: str, table: Table) -> list[Row]:
    projecting, planning, optimising = np.median([trial.seconds for trial in table.trials], axis=0)
    states = np.array([trial.state for trial in table.trials])
    batch = timed(lambda: table.skill.project(states))[0] / len(states)
    note = f"{1e3 * projecting:.2f} ms, median of single calls; {1e3 * batch:.2f} ms for each of a batch"
    faster = "times faster than optimisation"
    return [
        Row(f"{name}: projection, {faster}", optimising / projecting, "×", FASTER, ">", "22", note),
        Row(
            f"{name}: geodesic, {faster}",
            optimising / planning,
            "×",
            FASTER,
            ">",
            "1500",
            f"{1e3 * planning:.2f} ms, median",
        ),
    ]
