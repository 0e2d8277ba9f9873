"""How far a fitted surface is believed: what counts as on it, and how far from its anchors it reaches."""

from typing import Any

import numpy as np
from scipy.spatial import KDTree

from skillfold.manifold.kernels.judging import displacements
from skillfold.manifold.kernels.scratch import evaluator
from skillfold.manifold.kernels.surface import Field, Surface, Trust
from skillfold.manifold.kernels.tabled import tabled
from skillfold.manifold.model import trust_in
from skillfold.manifold.shapes import Chosen, spread_out
from skillfold.manifold.threads import in_parts

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

QUANTILE = 0.95
HALF_WAY = 0.45  # of a stride from anchor to anchor: as near are nine of ten places along it
NO_DOUBT = 1e-3  # rms radii: disagreement between anchors that is never a reason for doubt
CAP = 0.5  # rms radii: longest step of a projection, if no local surface is smaller
POOL = 20_000  # samples from which anchors are chosen


def calibrate(
    surface: Surface,
    field: Field,
    samples: Array,
    chosen: Indices,
    judged: Chosen,
    stride: float,
    seed: int,
    jobs: int,
) -> tuple[float, Trust]:
    """What is held out of samples (N, D) tells: the tolerance, and how far the surface is trusted.

    Args:
        surface, field: as fitted.
        samples: (N, D).
        chosen: (M,) those that became anchors, sorted.
        judged: what was held out, and how well it was predicted.
        stride: from anchor to anchor.
        seed: of the samples that anchors were chosen from.
        jobs: threads.
    """
    table = tabled(surface, field, np.zeros(samples.shape[1]), np.eye(samples.shape[1]), 1.0, evaluator())

    def measured(states: Array) -> Array:
        found = in_parts(lambda part: displacements(table.entries, states[part], np.inf), len(states), jobs)
        return np.concatenate(found, axis=1)

    left_out = samples[judged.left_out]
    tolerance = _quantile(np.sqrt(judged.squares))
    if len(chosen) < len(samples):
        # Held out, the surface was one around a sample close by. Around the nearest anchor it may be farther off.
        tolerance = max(tolerance, _quantile(measured(left_out)[0]))
    # Half-way between anchors that follow each other is no farther out than usual, however near each has a twin.
    spacing = max(_quantile(_gaps(samples, surface.rows, chosen, judged, seed)), HALF_WAY * stride)
    # Anchors may disagree as they usually do at the demonstrations, or by next to nothing of the skill's size.
    doubts = measured(surface.rows)[2]
    usual = max(float(np.median(doubts)), NO_DOUBT)
    return tolerance, trust_in(spacing, usual, min(CAP, float(np.median(surface.radii))), doubts <= usual)


def _quantile(values: Array) -> float:
    return float(np.quantile(values, QUANTILE))


def _gaps(samples: Array, anchors: Array, chosen: Indices, judged: Chosen, seed: int) -> Array:
    """Distance of each left-out sample from the nearest anchor, as if it had been left out before those were chosen.

    It is no nearer than the nearest sample, nor than its own noise lets it be: anchors have none.
    """
    left_out = samples[judged.left_out]
    tree = KDTree(anchors)
    nearest, other = np.asarray(tree.query(left_out, 2)[0]).T
    own = np.isin(judged.left_out, chosen)
    heirs = _heirs(samples, chosen, tree, seed)[np.searchsorted(chosen, judged.left_out[own])]
    nearest[own] = np.minimum(other[own], heirs)
    return np.maximum(nearest, np.linalg.norm(samples[judged.nearest] - left_out, axis=1))


def _heirs(samples: Array, chosen: Indices, tree: KDTree, seed: int) -> Array:
    """Distance from each anchor (M,) to the sample that would be one in its place; infinite where none would.

    Anchors lie far from each other. Without one of them, of the samples around it the farthest from it would be
    chosen, if it is farther from all others than any sample is now.
    """
    found = np.full(len(chosen), np.inf)
    rest = np.setdiff1d(spread_out(len(samples), POOL, seed), chosen)
    if len(rest):
        gaps, anchors = tree.query(samples[rest], 2)
        nearest, other = np.asarray(gaps).T
        heir = other > nearest.max()
        farthest = np.zeros(len(chosen))
        np.maximum.at(farthest, np.asarray(anchors)[heir, 0], nearest[heir])
        found = np.where(farthest > 0.0, farthest, found)
    return found
