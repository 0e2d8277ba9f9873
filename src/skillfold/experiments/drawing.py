"""The paper's own path on drawings: `route="geodesic"` on a one-dimensional manifold, LASA handwriting.

Same protocol as for whole recordings, one demonstration left out, but absolute: mean distance to it in per
cent of the diagonal of all the shape's demonstrations. Gaussian mixture regression stands beside it: over
phase, and for several modes, which a mean over phase mixes, also as dynamics.
"""

from dataclasses import astuple, dataclass

import numpy as np

from skillfold.baselines.gmr_regression import COMPONENTS, gmr_path, gmr_rollout
from skillfold.experiments.leave_one_out import corrected_mean, distance_between, straight_line
from skillfold.experiments.loaders import RecordedTask, lasa
from skillfold.experiments.recordings import left_out
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array


@dataclass(frozen=True)
class Percent:
    """Mean distance to the left-out demonstration, in per cent of the bounding diagonal."""

    geodesic: float
    gmr: float
    gmr_corrected: float
    line: float
    gmr_dynamics: float


def measure(settings: Settings) -> list[Row]:
    """The rows of single-mode and multi-mode shapes."""
    rows = []
    for multi_mode, target in ((False, 3.2), (True, 2.0)):
        name = f"LASA {'multi' if multi_mode else 'single'}-mode, geodesic, dim = 1"
        tasks = lasa(multi_mode)
        percents: list[Percent] = []
        for index, task in enumerate(tasks):
            settings.progress(f"{name}: {task.name}", index / len(tasks))
            percents += score_shape(task, settings, dynamics=multi_mode)
        rows += _rows(name, percents, target)
    return rows


def score_shape(task: RecordedTask, settings: Settings, dynamics: bool = False) -> list[Percent]:
    """One set of figures per demonstration of the shape; GMR dynamics, which are slow, only if asked for."""
    states = np.concatenate(task.recordings)
    diagonal = float(np.linalg.norm(np.ptp(states, axis=0)))
    return [_percent(truth, others, diagonal, settings, dynamics) for truth, others in left_out(task.recordings)]


def _percent(truth: Array, others: list[Array], diagonal: float, settings: Settings, dynamics: bool) -> Percent:
    start, goal = truth[0], truth[-1]
    skill = settings.learn(others, dim=1)
    seed = settings.seed % 2**32
    mixture = gmr_path(others, seed)
    paths = [
        skill.plan(start, goal, route="geodesic").path.states,
        mixture,
        corrected_mean([mixture], start, goal),
        straight_line(start, goal),
        *([gmr_rollout(others, start, goal, seed)] if dynamics else []),
    ]
    percents = [100.0 * distance_between(path, truth) / diagonal for path in paths]
    return Percent(*percents, *([] if dynamics else [float("nan")]))


def _rows(name: str, percents: list[Percent], target: float) -> list[Row]:
    geodesic, gmr, corrected, line, dynamics = np.mean([astuple(p) for p in percents], axis=0)
    note = (
        f"gmr with {COMPONENTS} components {gmr:.1f} %, its ends corrected {corrected:.1f} %, "
        f"straight line {line:.1f} %"
    )
    note += f", gmr as dynamics {dynamics:.1f} %" if np.isfinite(dynamics) else ""
    return [Row(f"{name}: distance to the left-out demonstration", float(geodesic), "%", target, note=note)]
