"""Every figure that the library claims, measured in one run beside its target and the paper's figure."""

import os
import platform
import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib import metadata
from pathlib import Path
from time import perf_counter
from typing import Any

from skillfold.errors import InputError
from skillfold.experiments import (
    around,
    drawing,
    keyframes,
    large,
    projection,
    reaching,
    reacting,
    recordings,
    table_one,
    timing,
    tumblers,
    upright,
)
from skillfold.experiments.rows import Progress, Row, Settings

Experiment = Callable[[Settings], list[Row]]

GROUPS: dict[str, tuple[Experiment, ...]] = {
    "arm": (reaching.measure,),
    "sets": (projection.measure,),
    "upright": (upright.measure,),
    "noise": (reaching.measure_noise, projection.measure_noise),
    "around": (around.measure,),
    "control": (table_one.measure, reacting.measure),
    "tumblers": (tumblers.measure,),
    "recordings": (recordings.measure, drawing.measure),
    "large": (large.measure,),
    "keyframes": (keyframes.learning, keyframes.measure),
    "speed": (timing.measure,),
}
PACKAGES = ("skillfold", "numpy", "scipy", "scikit-learn", "numba", "mujoco", "gmr", "ompl", "movement_primitives")


@dataclass(frozen=True)
class Report:
    """One run: its rows and all that is needed to run it again."""

    rows: tuple[Row, ...]
    seed: int
    seconds: dict[str, float]
    machine: dict[str, Any]

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "seed": self.seed,
            "machine": self.machine,
            "seconds": self.seconds,
            "rows": [row.as_dict() for row in self.rows],
        }


def run(
    groups: Sequence[str] | None = None,
    data: Path | None = None,
    seed: int | None = None,
    progress: Progress | None = None,
) -> Report:
    """Measure the given groups, all by default.

    Args:
        groups: of `GROUPS`.
        data: folder with `ecomann/` and `robotasks/`; without it the point sets are drawn and the robot tasks
            left out, which their rows say.
        seed: of everything random; fresh by default and told in the report.
        progress: called with what is being measured and the share of that group that is done.

    Raises:
        InputError: an unknown group, or a data folder without the sets.
        MissingExtraError: the recordings of LASA or the package `gmr` are not installed.
    """
    chosen = _checked(groups)
    seed = secrets.randbits(32) if seed is None else seed
    settings = Settings(seed, data, progress or Settings(0).progress)
    rows: list[Row] = []
    seconds: dict[str, float] = {}
    for name in chosen:
        start = perf_counter()
        rows += [replace(row, group=name) for experiment in GROUPS[name] for row in experiment(settings)]
        seconds[name] = perf_counter() - start
    return Report(tuple(rows), seed, seconds, machine())


def machine() -> dict[str, Any]:
    """What the figures were measured on."""
    return {
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "cores": os.cpu_count(),
        "packages": {name: _version(name) for name in PACKAGES},
    }


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


def _checked(groups: Sequence[str] | None) -> list[str]:
    if groups is None:
        return list(GROUPS)
    unknown = [name for name in groups if name not in GROUPS]
    if unknown:
        raise InputError(f"No group named {', '.join(unknown)}; there are {', '.join(GROUPS)}.")
    return list(dict.fromkeys(groups))
