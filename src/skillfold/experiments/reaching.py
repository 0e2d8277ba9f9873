"""Section V-A and V-B of paper 000: paths planned on the learnt manifold against optimal poses.

Each trial learns from fresh samples, plans between fresh pairs of optimal poses, and compares every interior
state with the optimal pose at that state's own end-effector position. Trials run side by side; plans are timed by
the clock of their thread, which stands still while neighbours work.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from time import thread_time
from typing import Any

import numpy as np

from skillfold.experiments.parallel import in_parallel
from skillfold.experiments.rows import Row, Settings
from skillfold.experiments.three_link import (
    REACHING,
    WEIGHTED_REACHING,
    Redundancy,
    forward,
    optimal,
)
from skillfold.motion import Array

TRIALS = 10
PAIRS = 50
GRID_CENTRE = np.array([0.45, 0.0])
GRID_SHAPE = (21, 31)
GRID_SPACING = 0.03
GRID_HALF = GRID_SPACING * (np.array(GRID_SHAPE) - 1) / 2
OUTSIDE = 1.5  # extrapolation ends lie in the grid's rectangle scaled by this about its centre
REACH = 0.95  # of 1 m: stretched arms, where the two elbows meet, are left out
JOINT_NOISE = 0.01

Positions = Callable[[int, np.random.Generator], Array]


@dataclass(frozen=True)
class Outcome:
    """One trial: joint RMSE of all interior path points, share of plans converged, dimension, seconds of a plan."""

    rmse: float
    converged: float
    dim: int
    seconds: float


def grid() -> Array:
    """The 651 end-effector positions of Section V-A."""
    axes = [np.linspace(-half, half, count) for half, count in zip(GRID_HALF, GRID_SHAPE, strict=True)]
    return GRID_CENTRE + np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


def inside_grid(count: int, rng: np.random.Generator) -> Array:
    """Positions uniform in the grid's rectangle."""
    return GRID_CENTRE + rng.uniform(-GRID_HALF, GRID_HALF, (count, 2))


def outside_grid(count: int, rng: np.random.Generator) -> Array:
    """Positions uniform in the rectangle scaled by 1.5 but outside the grid, within 0.95 m of the base."""

    def allowed(positions: Array) -> np.ndarray:
        beyond = (np.abs(positions - GRID_CENTRE) > GRID_HALF).any(axis=1)
        return beyond & (np.linalg.norm(positions, axis=1) <= REACH)

    half = OUTSIDE * GRID_HALF
    return _rejection(lambda n: GRID_CENTRE + rng.uniform(-half, half, (n, 2)), allowed, count)


def upper_half_disc(count: int, rng: np.random.Generator) -> Array:
    """Positions uniform in the upper half of the reach, x ∈ [−1, 1], y ∈ [0, 1] (Equation 14), within 0.95 m.

    Below the x axis the mirrored pose becomes optimal: the paper's set stops there, and so does this one.
    """
    return _rejection(
        lambda n: rng.uniform([-1.0, 0.0], [1.0, 1.0], (n, 2)),
        lambda positions: np.linalg.norm(positions, axis=1) <= REACH,
        count,
    )


def trial(
    skill: Any, redundancy: Redundancy, ends: Positions, rng: np.random.Generator, pairs: int = PAIRS
) -> Outcome:
    """Plan between `pairs` random pairs of optimal poses and compare with the optimum."""
    starts, goals = (optimal(ends(pairs, rng), redundancy) for _ in range(2))
    plans, seconds = timed_plans(skill, starts, goals)
    interior = np.concatenate([plan.path.states[1:-1] for plan in plans])
    converged = float(np.mean([plan.converged for plan in plans]))
    return Outcome(path_rmse(interior, redundancy), converged, int(skill.dim), float(np.median(seconds)))


def timed_plans(skill: Any, starts: Array, goals: Array) -> tuple[list[Any], list[float]]:
    """A plan for each pair of ends (n, D), and its seconds by the clock of this thread."""
    plans, seconds = [], []
    for start, goal in zip(starts, goals, strict=True):
        begun = thread_time()
        plans.append(skill.plan(start, goal))
        seconds.append(thread_time() - begun)
    return plans, seconds


def path_rmse(joints: Array, redundancy: Redundancy) -> float:
    """Root mean square joint error (rad) of states (N, 3) against the optimum at their own positions."""
    positions = forward(joints)
    if redundancy == WEIGHTED_REACHING:
        # The optimum jumps to its mirror image below the x axis, outside the set that is learnt.
        joints, positions = joints[positions[:, 1] >= 0], positions[positions[:, 1] >= 0]
    return float(np.sqrt(np.mean((joints - optimal(positions, redundancy)) ** 2)))


def measure(settings: Settings, trials: int = TRIALS, pairs: int = PAIRS) -> list[Row]:
    """The rows of Sections V-A and V-B without noise."""
    runs = _Runs(settings, trials, pairs)
    small = runs.repeat("V-A, 100 samples", (0.0, 0.25), REACHING, _grid_samples(100), inside_grid, outside_grid)
    large = runs.repeat("V-A, 400 samples", (0.25, 0.5), REACHING, _grid_samples(400), inside_grid)
    half_disc = [
        runs.repeat(f"V-B, {n} samples", shares, WEIGHTED_REACHING, _half_disc_samples(n), upper_half_disc)[0]
        for n, shares in ((100, (0.5, 0.65)), (1000, (0.65, 0.9)))
    ]
    right = float(np.mean([outcome.dim == 2 for outcome in small[0]]))
    return [
        _row("V-A interpolation RMSE, 100 samples", small[0], 1e-4, "1.9e-4 ± 3.6e-5"),
        _row("V-A extrapolation RMSE, up to 1.5 × outside the grid", small[1], 4e-3, "6.8e-2 ± 2.2e-2"),
        _row("V-A interpolation RMSE, 400 samples", large[0], 1e-5),
        _row("V-B RMSE, 100 samples", half_disc[0], 2e-3, "~1e-3"),
        _row("V-B RMSE, 1000 samples", half_disc[1], 1e-4),
        Row("V-A chosen dimension is 2: share of trials", right, "", 1.0, ">=", "by hand"),
        _time_row("V-B one plan, 100 samples, median", half_disc[0], "~1 s (optimisation ~3 s)"),
    ]


def measure_noise(settings: Settings, trials: int = TRIALS, pairs: int = PAIRS) -> list[Row]:
    """Section V-A learnt from 1000 samples with 0.01 rad of noise on every joint."""
    runs = _Runs(settings, trials, pairs)
    outcomes = runs.repeat("V-A with noise", (0.0, 1.0), REACHING, _noisy_samples(1000), inside_grid)[0]
    return [_row("V-A interpolation RMSE, 1000 samples with 0.01 rad noise", outcomes, 1e-3)]


Samples = Callable[[np.random.Generator], Array]


@dataclass(frozen=True)
class _Runs:
    settings: Settings
    trials: int
    pairs: int

    def repeat(
        self, label: str, shares: tuple[float, float], redundancy: Redundancy, samples: Samples, *ends: Positions
    ) -> list[list[Outcome]]:
        """Outcomes per kind of ends; each trial's skill serves all. `shares` of the work: before and after."""
        # What tells of progress does not go to other processes.
        learner = Settings(self.settings.seed, fit=self.settings.fit)
        cases = [(learner, index, redundancy, samples, ends, self.pairs) for index in range(self.trials)]
        self.settings.progress(label, shares[0])
        found = list(in_parallel(_outcomes, cases, self.settings.progress, label, shares))
        return [list(kind) for kind in zip(*found, strict=True)]


def _outcomes(
    settings: Settings, index: int, redundancy: Redundancy, samples: Samples, ends: tuple[Positions, ...], pairs: int
) -> list[Outcome]:
    """One trial, an outcome for each kind of ends."""
    rng = np.random.default_rng([settings.seed, index])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the skill keeps its notes
        skill = settings.learn(samples(rng))
    return [trial(skill, redundancy, kind, rng, pairs) for kind in ends]


def _grid_samples(count: int) -> Samples:
    poses = optimal(grid(), REACHING)
    return lambda rng: poses[rng.choice(len(poses), count, replace=False)]


def _half_disc_samples(count: int) -> Samples:
    return lambda rng: optimal(upper_half_disc(count, rng), WEIGHTED_REACHING)


def _noisy_samples(count: int) -> Samples:
    def draw(rng: np.random.Generator) -> Array:
        poses = optimal(inside_grid(count, rng), REACHING)
        return poses + JOINT_NOISE * rng.standard_normal(poses.shape)

    return draw


def _time_row(name: str, outcomes: list[Outcome], paper: str) -> Row:
    times = 1e3 * np.array([outcome.seconds for outcome in outcomes])
    note = f"{times.min():.2g} to {times.max():.2g} ms among {len(times)} trials, by the clock of the thread"
    return Row(name, float(np.median(times)), "ms", None, "<=", paper, note)


def _row(name: str, outcomes: list[Outcome], target: float, paper: str = "") -> Row:
    errors = np.array([outcome.rmse for outcome in outcomes])
    converged = np.mean([outcome.converged for outcome in outcomes])
    note = f"{len(errors)} trials, ± {errors.std():.1e}, worst {errors.max():.1e}; {converged:.0%} of plans converged"
    return Row(name, float(errors.mean()), "rad", target, "<=", paper, note)


def _rejection(draw: Callable[[int], Array], allowed: Callable[[Array], np.ndarray], count: int) -> Array:
    kept = np.empty((0, 2))
    while len(kept) < count:
        drawn = draw(4 * count)
        kept = np.concatenate([kept, drawn[allowed(drawn)]])
    return kept[:count]
