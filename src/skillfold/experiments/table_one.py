"""Table I of paper 000: the true cost of motions, left alone and pushed, naive quintic against skill manifold.

The rows of the two systems, each beside the naive planner's figure of the same run and the paper's. How a trial goes
stands in `pushed_motions`. Cost is the mean over the states of a motion; besides it stands the excess over the
cheapest pose at each state's own tool position, since cost also varies along the manifold. The paper tells neither
how far it pushes nor the scale of its three-link cost: only the order of its figures compares.
"""

from dataclasses import dataclass

import numpy as np

from skillfold.experiments import three_link, tray
from skillfold.experiments.pushed_motions import RETURN, Costs, Runs, Task, run
from skillfold.experiments.reaching import upper_half_disc
from skillfold.experiments.rows import Row, Settings
from skillfold.experiments.three_link import WEIGHTED_REACHING
from skillfold.motion import Array

TRIALS, SAMPLES = 100, 100
PUSH, LARGE_PUSH = 0.5, 1.0  # rad
RATIO = 5.0  # that the excess after a push must be lower by
MOVED = 0.01  # rad: ends moved by less are not told
TILT_TARGET = 0.06  # rad², of J₂ after the large push
# As the paper prints them: naive and manifold, left alone and pushed.
PAPER = {
    ("3-link", "J", 0): ("0.9239 ± 0.1799", "0.8724 ± 0.1723"),
    ("3-link", "J", 1): ("1.401 ± 0.3610", "1.214 ± 0.2597"),
    ("KUKA", "J1", 0): ("0.7952 ± 0.0713", "0.6719 ± 0.0777"),
    ("KUKA", "J1", 1): ("0.8173 ± 0.1215", "0.6862 ± 0.1317"),
    ("KUKA", "J2", 0): ("0.0154 ± 0.0082", "0.0119 ± 0.0072"),
    ("KUKA", "J2", 1): ("0.5546 ± 0.1199", "0.0785 ± 0.0160"),
}


@dataclass(frozen=True)
class Half:
    """One system of the table: what it was asked, and the motions left alone, pushed, and pushed hard."""

    task: Task
    runs: tuple[Runs, ...]


def measure(settings: Settings, trials: int = TRIALS) -> list[Row]:
    """All rows of the table."""
    return [row for half in table(settings, trials) for row in rows(half)]


def table(settings: Settings, trials: int = TRIALS) -> tuple[Half, Half]:
    """Both systems; every trial counts."""
    rng = np.random.default_rng(settings.seed)
    settings.progress("Table I, three-link arm", 0.0)
    first = _half(settings, three_link_task(settings, rng, trials), (0.0, PUSH), rng, (0.05, 0.3))
    settings.progress("Table I, KUKA arm with a tray", 0.3)
    return first, _half(settings, kuka_task(settings, rng, trials), (0.0, PUSH, LARGE_PUSH), rng, (0.35, 0.9))


def _half(
    settings: Settings, task: Task, pushes: tuple[float, ...], rng: np.random.Generator, shares: tuple[float, float]
) -> Half:
    runs = []
    for index, push in enumerate(pushes):
        words = f"pushed by {push:g} rad" if push else "left alone"
        settings.progress(f"Table I, {task.name} {words}", shares[0] + np.ptp(shares) * index / len(pushes))
        runs.append(run(task, push, rng))
    return Half(task, tuple(runs))


def three_link_task(settings: Settings, rng: np.random.Generator, trials: int = TRIALS) -> Task:
    """Section V-C: the reaching skill of section V-B."""
    poses = three_link.optimal(upper_half_disc(SAMPLES + 2 * trials, rng), WEIGHTED_REACHING)
    skill = settings.learn(poses[:SAMPLES])
    costs: dict[str, Costs] = {"J": WEIGHTED_REACHING.cost}
    return Task("3-link", skill, poses[SAMPLES:].reshape(trials, 2, -1), costs, _three_link_excess)


def kuka_task(settings: Settings, rng: np.random.Generator, trials: int = TRIALS) -> Task:
    """Section VI: the tray carried by seven joints."""
    skill = settings.learn(tray.tray_poses(SAMPLES, rng, tray.PAPER_WEIGHT))
    ends = tray.tray_poses(2 * trials, rng, tray.PAPER_WEIGHT).reshape(trials, 2, -1)
    costs: dict[str, Costs] = {"J1": tray.motion_cost, "J2": lambda q: tray.tilt(q) ** 2}
    return Task("KUKA", skill, ends, costs, _kuka_excess)


def rows(half: Half) -> list[Row]:
    """Costs left alone and under the largest push, then the excess."""
    alone, pushed = half.runs[0], half.runs[-1]
    found = [_cost_row(half.task, name, runs) for runs in (alone, pushed) for name in half.task.costs]
    return [*found, _excess_row(half.task, alone), _ratio_row(half.task, half.runs[1])]


def _cost_row(task: Task, name: str, runs: Runs) -> Row:
    naive, manifold = (runs.costs(task.costs[name])[method] for method in ("naive", "manifold"))
    limit = float(naive.mean())
    tight = name == "J2" and runs.push == LARGE_PUSH
    paper = PAPER[task.name, name, int(runs.push > 0)]
    return Row(
        f"{task.name} {name}, {_pushed(runs)}: manifold's mean, naive's as its target",
        float(manifold.mean()),
        "",
        min(TILT_TARGET, limit) if tight else limit,
        "<",
        f"{paper[1]} (naive {paper[0]})",
        f"± {manifold.std():.4f}; naive {limit:.4f} ± {naive.std():.4f}; lower in {_wins(manifold, naive)}; "
        f"dimension {task.skill.dim}; {runs.failed} plans failed their check{_moved(task, runs)}",
    )


def _excess_row(task: Task, runs: Runs) -> Row:
    naive, manifold = (np.nanmean(runs.excess[method]) for method in ("naive", "manifold"))
    name = f"{task.name} excess over the optimum, {_pushed(runs)}: manifold's mean, naive's as its target"
    return Row(name, float(manifold), "", float(naive), "<", "", _unknown(runs))


def _ratio_row(task: Task, runs: Runs) -> Row:
    means = {method: float(np.nanmean(values)) for method, values in runs.excess.items()}
    per_trial = {method: np.nanmean(values, axis=1) for method, values in runs.excess.items()}
    note = (
        f"naive {means['naive']:.2e}, manifold {means['manifold']:.2e}, lower in "
        f"{_wins(per_trial['manifold'], per_trial['naive'])}; back within {RETURN:g} of the time; with one slow "
        f"motion back and on, {means['naive'] / means['unhurried']:.1f}; {_unknown(runs)}"
    )
    name = f"{task.name} excess over the optimum, {_pushed(runs)}: times lower than naive"
    return Row(name, means["naive"] / means["manifold"], "", RATIO, ">=", "", note)


def _moved(task: Task, runs: Runs) -> str:
    """In how many motions the skill's started or ended elsewhere than was asked: such ends lie off what it learnt."""
    away = np.linalg.norm(runs.motions["manifold"][:, [0, -1]] - task.ends, axis=2).max(axis=1)
    told = (
        f"; ends of {int((away > MOVED).sum())} lay off its surface and were moved, by {away.max():.2g} rad at most"
    )
    return told if away.max() > MOVED else ""


def _pushed(runs: Runs) -> str:
    return f"pushed by {runs.push:g} rad" if runs.push else "not pushed"


def _wins(manifold: Array, naive: Array) -> str:
    return f"{int((manifold < naive).sum())} of {len(naive)}"


def _unknown(runs: Runs) -> str:
    share = np.mean([np.isnan(values).mean() for values in runs.excess.values()])
    return f"optimum unknown at {share:.1%} of the states"


def _three_link_excess(q: Array) -> Array:
    best = three_link.followed(three_link.forward(q), WEIGHTED_REACHING)
    return WEIGHTED_REACHING.cost(q) - WEIGHTED_REACHING.cost(best)


def _kuka_excess(q: Array) -> Array:
    best = tray.optimum(tray.positions(q), tray.PAPER_WEIGHT)
    known = np.all(np.isfinite(best), axis=1)
    return np.where(known, tray.cost(q) - tray.cost(np.where(known[:, None], best, q)), np.nan)
