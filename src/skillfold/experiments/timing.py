"""Times of what a user waits for, on smooth manifolds; and a plan against pose by pose optimisation.

Medians within one run. A first call of everything compiles and is not counted.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.baselines.pose_optimiser import optimise_poses
from skillfold.experiments import three_link
from skillfold.experiments.alone import import_seconds, seconds
from skillfold.experiments.reaching import inside_grid
from skillfold.experiments.rows import Row, Settings
from skillfold.experiments.synthetic import smooth_manifold
from skillfold.experiments.three_link import REACHING
from skillfold.motion import Array

POINTS = 50
PLANS = 40
STATES = 2000
OPTIMISED_PLANS = 10


@dataclass(frozen=True)
class Size:
    """One case: N samples of D dimensions, manifold dimension d, K kernels; the plan's target in ms."""

    n_samples: int
    n_dims: int
    dim: int
    kernels: int
    plan_ms: float | None


SIZES = (
    Size(100, 3, 2, 10, 0.5),
    Size(100, 7, 4, 20, 1.0),
    Size(500, 12, 4, 20, 3.0),
    Size(500, 3, 1, 5, None),
)


def measure(settings: Settings) -> list[Row]:
    """All rows about time but those of many samples."""
    rows: list[Row] = []
    for index, size in enumerate(SIZES):
        settings.progress(f"times at {size.n_samples} × {size.n_dims}", index / (len(SIZES) + 2))
        rows += _size_rows(size, settings)
    settings.progress("plan against pose by pose optimisation", len(SIZES) / (len(SIZES) + 2))
    rows.append(_optimiser_row(settings))
    settings.progress("import", 1.0)
    rows.append(Row("import skillfold", float(np.median([import_seconds() for _ in range(5)])), "s", 0.3, "<"))
    return rows


def _size_rows(size: Size, settings: Settings) -> list[Row]:
    rng = np.random.default_rng(settings.seed)
    samples = smooth_manifold(size.n_samples, size.n_dims, size.dim, rng)

    def fit() -> Any:
        return settings.learn(samples, dim=size.dim, kernels=size.kernels)

    skill = fit()
    case = f"{size.n_samples} × {size.n_dims}"
    fit_seconds = float(np.median(seconds(fit, 5)))
    rows = [Row(f"fit at {case}, dim and kernels given", fit_seconds, "s", 0.3, "<", "1.38 s")]
    if size.plan_ms is not None:
        rows += _call_rows(skill, size, samples, rng)
    return rows


def _call_rows(skill: Any, size: Size, samples: Array, rng: np.random.Generator) -> list[Row]:
    case = f"D = {size.n_dims}"
    states = samples[rng.integers(len(samples), size=STATES)]
    states = states + 0.05 * rng.standard_normal(states.shape)
    h_batch, h_single = _per_state(skill.tangent, states)
    p_batch, p_single = _per_state(skill.project, states)
    plan_ms, converged = _plan_times(skill, samples, rng)
    note = f"{converged:.0%} of {PLANS} converged"
    return [
        Row(f"one H, {case}", h_batch, "µs", 2.0, "<", "", f"in a batch; a single call {h_single:.0f} µs"),
        Row(
            f"one projection, {case}",
            p_batch,
            "µs",
            50.0,
            "<",
            "90 ms",
            f"in a batch; single {p_single:.0f} µs",
        ),
        Row(f"one {POINTS}-point plan, {case}, median", plan_ms, "ms", size.plan_ms, "<", "25–100 ms", note),
        Row(f"plans converged, {case}", converged, "share", 1.0, ">="),
    ]


def _per_state(function: Any, states: Array) -> tuple[float, float]:
    """Microseconds per state in one batch (median of 7 batches) and of one single call (median of 300)."""
    function(states)
    function(states[0])
    batch = np.median(seconds(lambda: function(states), 7)) / len(states)
    single = np.median([seconds(lambda state=state: function(state))[0] for state in states[:300]])
    return 1e6 * float(batch), 1e6 * float(single)


def _plan_times(skill: Any, samples: Array, rng: np.random.Generator) -> tuple[float, float]:
    """Milliseconds of a plan between two samples (median), and the share that converged."""
    pairs = [samples[rng.choice(len(samples), 2, replace=False)] for _ in range(PLANS)]
    skill.plan(*pairs[0], points=POINTS)
    plans: list[Any] = []
    times = [seconds(lambda pair=pair: plans.append(skill.plan(*pair, points=POINTS)))[0] for pair in pairs]
    return 1e3 * float(np.median(times)), float(np.mean([plan.converged for plan in plans]))


def _optimiser_row(settings: Settings) -> Row:
    """The three-link arm's plan against SLSQP on the same poses."""
    rng = np.random.default_rng(settings.seed)
    skill = settings.learn(three_link.optimal(inside_grid(100, rng), REACHING))
    ends = three_link.optimal(inside_grid(2 * OPTIMISED_PLANS, rng), REACHING).reshape(-1, 2, 3)
    skill.plan(*ends[0], points=POINTS)
    ratios, shares = zip(*(_race(skill, start, goal) for start, goal in ends), strict=True)
    note = f"{np.mean(shares):.0%} of the optimisations succeed; lowest ratio {min(ratios):.0f}"
    name = f"{POINTS}-point plan against optimising the same poses (SLSQP, warm-started): times faster"
    return Row(name, float(np.median(ratios)), "×", 100.0, ">", "3 (three links), 30 (Nao)", note)


def _race(skill: Any, start: Array, goal: Array) -> tuple[float, float]:
    plan = skill.plan(start, goal, points=POINTS)
    planning = float(np.median(seconds(lambda: skill.plan(start, goal, points=POINTS), 5)))
    positions = three_link.forward(plan.path.states)
    shares: list[float] = []
    (optimising,) = seconds(lambda: shares.append(_optimise(positions, start)))
    return optimising / planning, shares[0]


def _optimise(positions: Array, first: Array) -> float:
    functions = REACHING.cost, REACHING.gradient, three_link.forward, three_link.jacobian
    return optimise_poses(positions, first, *functions)[1]
