"""Many samples: a million points with noise, and how time and memory grow; each fit in its own process."""

import numpy as np

from skillfold.experiments.alone import alone, seconds
from skillfold.experiments.rows import Row, Settings
from skillfold.experiments.synthetic import noisy_sphere, smooth_manifold

MODULE = "skillfold.experiments.large"
NOISE = 0.01


def measure(settings: Settings) -> list[Row]:
    """The rows about a million samples and about growth from 1e4 to 1e5 samples of 7 dimensions."""
    seed = settings.seed
    settings.progress("1e6 samples of 3 dimensions", 0.0)
    million = alone(MODULE, "fit_sphere", count=1_000_000, seed=seed)
    settings.progress("1e4 samples of 7 dimensions", 0.5)
    small = alone(MODULE, "fit_seven", count=10_000, seed=seed)
    settings.progress("1e5 samples of 7 dimensions", 0.6)
    large = alone(MODULE, "fit_seven", count=100_000, seed=seed)
    return [*_million_rows(million), *_growth_rows(small, large)]


def fit_sphere(count: int, seed: int) -> dict[str, float]:
    """Fit a unit sphere with 1 % noise; seconds of the fit and of a projection, and what noise is left."""
    rng = np.random.default_rng(seed)
    settings = Settings(seed)
    _warm_up(settings, 3)
    samples = noisy_sphere(count, NOISE, rng)
    skills = []
    (fit,) = seconds(lambda: skills.append(settings.learn(samples)))
    states = rng.uniform(-1, 1, (500, 3))
    skills[0].project(states[0])
    single = [seconds(lambda state=state: skills[0].project(state))[0] for state in states]
    off = np.abs(np.linalg.norm(skills[0].project(states), axis=1) - 1.0)
    return {"fit": fit, "project": float(np.median(single)), "residual": float(np.median(off))}


def fit_seven(count: int, seed: int) -> dict[str, float]:
    """Fit a four-dimensional manifold in seven dimensions; seconds of the fit, warm."""
    settings = Settings(seed)
    _warm_up(settings, 7)
    samples = smooth_manifold(count, 7, 4, np.random.default_rng(seed))
    dims = []
    (fit,) = seconds(lambda: dims.append(settings.learn(samples).dim))
    return {"fit": fit, "dim": float(dims[0])}


def _warm_up(settings: Settings, n_dims: int) -> None:
    """Compile what a fit and a projection use, so that only their work is measured."""
    samples = smooth_manifold(300, n_dims, 2, np.random.default_rng(0))
    settings.learn(samples).project(samples[:2])


def _million_rows(million: dict[str, float]) -> list[Row]:
    left = f"median distance of projected box states from the sphere {million['residual'] / NOISE:.2f} σ"
    memory = f"peak memory {million['peak_memory_gb']:.2f} GB"
    return [
        Row("1e6 samples of 3 dimensions with 1 % noise: fit", million["fit"], "s", 30.0, "<", note=memory),
        Row("1e6 samples: one projection, median", 1e3 * million["project"], "ms", 0.3, "<", note=left),
    ]


def _growth_rows(small: dict[str, float], large: dict[str, float]) -> list[Row]:
    times = f"{small['fit']:.2f} s to {large['fit']:.2f} s"
    times += f"; dimensions {small['dim']:.0f}, {large['dim']:.0f} (true 4)"
    memory = large["peak_memory_gb"]
    return [
        Row(
            "7 dimensions, 1e5 samples: fit over that of 1e4",
            large["fit"] / small["fit"],
            "",
            12.0,
            note=times,
        ),
        Row("7 dimensions, 1e5 samples: peak memory of the process", memory, "GB", 4.0, "<"),
    ]
