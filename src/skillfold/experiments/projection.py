"""Projection onto surfaces with known equations, after learning from 1000 of their points.

The states are uniform in the bounding box of the samples. A projection onto the nearest sample would do well
on the residual alone, so the displacement is compared with the true distance from the surface.
"""

from typing import Any

import numpy as np

from skillfold.experiments.point_sets import PLANE, SETS, SPHERE, PointSet
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array

SAMPLES = 1000
STATES = 1000
NOISE_SHARE = 0.01
RAW_MEDIAN = 0.67  # of the absolute value of a standard normal variable
RESIDUAL_TARGETS = {"sphere": 1e-4, "circle": 1e-4, "plane": 1e-3}


def measure(settings: Settings) -> list[Row]:
    """Chosen dimension, residual and displacement on sphere, plane and circle, without noise."""
    rng = np.random.default_rng(settings.seed)
    rows = []
    for index, kind in enumerate(SETS):
        settings.progress(f"projection onto the {kind.name}", index / len(SETS))
        samples = kind.samples(SAMPLES, rng, settings.data)
        skill = settings.learn(samples)
        rows += _rows(kind, skill, box_states(samples, rng))
    return rows


def measure_noise(settings: Settings) -> list[Row]:
    """What is left of 1 % noise after projection, on sphere and plane."""
    rng = np.random.default_rng(settings.seed)
    rows = []
    for index, kind in enumerate((SPHERE, PLANE)):
        settings.progress(f"noisy {kind.name}", index / 2)
        clean = kind.samples(SAMPLES, rng, settings.data)
        sigma = noise_of(clean)
        skill = settings.learn(clean + sigma * rng.standard_normal(clean.shape))
        rows.append(_noise_row(kind, skill.project(box_states(clean, rng)), sigma))
    return rows


def noise_of(samples: Array) -> float:
    """1 % of the samples' root mean square distance from their centre."""
    return NOISE_SHARE * float(np.sqrt(np.mean(np.sum((samples - samples.mean(axis=0)) ** 2, axis=1))))


def box_states(samples: Array, rng: np.random.Generator, count: int = STATES) -> Array:
    """States uniform in the bounding box of the samples."""
    return rng.uniform(samples.min(axis=0), samples.max(axis=0), (count, samples.shape[1]))


def _rows(kind: PointSet, skill: Any, states: Array) -> list[Row]:
    projected = np.asarray(skill.project(states))
    residual = np.abs(kind.residual(projected))
    ratio = np.linalg.norm(projected - states, axis=1) / np.maximum(kind.distance(states), 1e-12)
    success = f"share below 0.1: {np.mean(residual < 0.1):.1%}"
    return [
        Row(f"{kind.name}: chosen dimension", float(skill.dim), "", float(kind.dim), "==", "by hand"),
        Row(
            f"{kind.name}: residual of projected states, median",
            float(np.median(residual)),
            "",
            RESIDUAL_TARGETS[kind.name],
            "<=",
            "ECoMaNN 0.03",
            f"p95 {np.percentile(residual, 95):.1e}; {success}",
        ),
        Row(f"{kind.name}: displacement over the true distance, median", float(np.median(ratio)), "", 1.05),
        Row(
            f"{kind.name}: displacement over the true distance, 95 % quantile",
            float(np.percentile(ratio, 95)),
            "",
            1.05,
            note=f"worst {ratio.max():.2f}",
        ),
    ]


def _noise_row(kind: PointSet, projected: Array, sigma: float) -> Row:
    # The median, because a few states near a fold or beyond the samples' edge decide any mean.
    share = kind.distance(projected) / sigma
    note = f"p95 {np.percentile(share, 95):.2f} σ, σ = {sigma:.3g}; the noise itself has median {RAW_MEDIAN} σ"
    name = f"{kind.name} with 1 % noise: distance of projected states from the truth, median"
    return Row(name, float(np.median(share)), "σ", 0.3, note=note)
