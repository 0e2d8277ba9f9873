"""Rows of Table II: what was measured of a Nao on one leg, beside the paper's."""

import numpy as np

from skillfold.experiments.nao_balance import Counts, Table, Trial, run, timed
from skillfold.experiments.nao_stability import Count, count
from skillfold.experiments.rows import Row, Settings

NEEDED, PAPER = (47, 46), ("47", "42")  # of 50 projections and geodesics must be stable; are in the paper
GROUNDS = ("on a pedestal", "on flat ground")
KNOWN = ("projected states led out of floor and robot", "geodesics planned around floor and robot")
RMSE, FASTER = 0.01, 1000.0


def measure(settings: Settings, counts: Counts | None = None) -> list[Row]:
    """Rows of the table for every number of samples."""
    return rows(run(settings, counts or Counts.of(settings)))


def rows(tables: list[Table]) -> list[Row]:
    """All rows: first what does not depend on the skill."""
    return [*_given_rows(tables[0]), *(row for table in tables for row in _table_rows(table))]


def _given_rows(table: Table) -> list[Row]:
    """Optimised poses as they were demonstrated, random states, and the time of both optimisers."""
    best, random = count(table.shown), count([trial.random for trial in table.trials])
    analytic, differences = _optimising(table.trials)
    runs = [(trial.best, trial.by_differences) for trial in table.trials]
    evaluations = np.median([[found.evaluations for found in pair] for pair in runs], axis=0)
    return [
        Row("Nao on one leg, optimised poses: stable", best.stable, "", None, ">=", "48", best.note),
        Row("Nao on one leg, random states: stable", random.stable, "", None, "<=", "0", random.note),
        Row(
            "Nao on one leg, optimisation of a pose by finite differences, as in the paper",
            1e3 * differences,
            "ms",
            paper="38.35 s",
            note=f"median, of the thread; SciPy's trust-region-reflective solver on compiled kinematics, "
            f"{evaluations[1]:.0f} evaluations of the cost",
        ),
        Row(
            "Nao on one leg, optimisation of a pose with analytic derivatives",
            1e3 * analytic,
            "ms",
            note=f"median, of the thread; the same solver, {evaluations[0]:.0f} evaluations of the cost",
        ),
    ]


def _optimising(found: list[Trial]) -> tuple[float, float]:
    """Median seconds of the optimisation with analytic derivatives and with finite differences."""
    analytic = float(np.median([trial.seconds.optimising for trial in found]))
    return analytic, float(np.median([trial.seconds.differencing for trial in found]))


def _table_rows(table: Table) -> list[Row]:
    name = f"Nao on one leg, {len(table.demonstrations)} poses"
    errors = np.array([trial.error for trial in table.trials])
    reached = sum(trial.best.reached for trial in table.trials)
    note = (
        f"median {np.median(errors):.1e}, p95 {np.percentile(errors, 95):.1e}, largest {errors.max():.1e}; optimum "
        f"within reach in {reached} of {len(errors)}; dimension {table.skill.dim} (of the foot's positions 3)"
    )
    error = Row(f"{name}: RMSE of projections to the optimum", float(errors.mean()), "rad", RMSE, "<=", "0.01", note)
    return [error, *_stable_rows(name, table.trials), *_known_rows(name, table.trials), *_time_rows(name, table)]


def _stable_rows(name: str, found: list[Trial]) -> list[Row]:
    """Projections and poses of geodesics held one by one, and geodesics played as motions."""
    said = f"; {sum(trial.plan.success for trial in found)} of {len(found)} plans say success"
    made = []
    for ground, where in enumerate(GROUNDS):
        kinds = (
            ("projected states", 0, [trial.verdicts[0][ground] for trial in found], ""),
            ("poses of geodesics", 1, [pair[ground] for trial in found for pair in trial.held], said),
            ("geodesics played as motions", 1, [trial.verdicts[1][ground] for trial in found], said),
        )
        for what, kind, verdicts, more in kinds:
            counted = count(verdicts)
            title = f"{name}: {what} stable by both judges {where}"
            made.append(_stable_row(title, counted, kind, counted.note + more))
    return made


def _known_rows(name: str, found: list[Trial]) -> list[Row]:
    """The same on flat ground, the floor known."""
    said = sum(trial.floor.plan.success for trial in found)
    clear = sum(trial.floor.clear for trial in found)
    moved = [float(np.linalg.norm(trial.floor.pose - trial.projected)) for trial in found]
    away = [distance for distance in moved if distance > 0.0]
    told = (
        f"{len(away)} had to be led, by {np.median(away or [0.0]):.2f} rad in the median; {clear} are clear",
        f"{said} plans say success",
    )
    made = []
    for kind, what in enumerate(KNOWN):
        counted = count([trial.floor.verdicts[kind] for trial in found])
        title = f"{name}: {what}, stable by both judges on flat ground"
        made.append(_stable_row(title, counted, kind, f"{counted.note}; {told[kind]}"))
    return made


def _stable_row(title: str, counted: Count, kind: int, note: str) -> Row:
    """Targets and the paper's figures are of 50, of projections or of geodesics."""
    target = int(np.ceil(NEEDED[kind] * counted.total / 50))
    return Row(title, counted.stable, "", target, ">=", f"{PAPER[kind]} of 50", note)


def _time_rows(name: str, table: Table) -> list[Row]:
    """Both calls against both optimisers of one pose."""
    seconds = [trial.seconds for trial in table.trials]
    projecting, planning, coarsely = np.median([(s.projecting, s.planning, s.coarsely) for s in seconds], axis=0)
    states = np.array([trial.state for trial in table.trials])
    batch = timed(lambda: table.skill.project(states))[0] / len(states)
    points = len(table.trials[0].plan.path.states)
    notes = (
        f"{1e3 * projecting:.2f} ms, median of single calls, of the thread; {1e3 * batch:.2f} ms for each of a batch",
        f"{1e3 * planning:.2f} ms, median, of the thread, for {points} states; {1e3 * coarsely:.2f} ms for ten",
    )
    made = []
    for what, taken, paper, note in zip(
        ("projection", "geodesic"), (projecting, planning), ("22", "1500"), notes, strict=True
    ):
        analytic, differences = (seconds / taken for seconds in _optimising(table.trials))
        title = f"{name}: {what}, times faster than optimisation of a pose"
        made.append(Row(f"{title} by finite differences", differences, "×", None, ">", paper, note))
        made.append(Row(f"{title} with analytic derivatives", analytic, "×", FASTER, ">", "", note))
    analytic, differences = (points * seconds / planning for seconds in _optimising(table.trials))
    title = (
        f"{name}: geodesic, times faster than optimisation by finite differences of as many poses as it has states"
    )
    return [*made, Row(title, differences, "×", note=f"with analytic derivatives {analytic:.0f}")]
