"""Random skills of keyframes, and what is measured on them."""

import numpy as np
import pytest
from scipy.stats import chi2

from skillfold.experiments.keyframe_learning import (
    APART,
    QUANTILE,
    Counts,
    demonstrate,
    measure,
    random_truth,
    recovered,
    within,
)
from skillfold.experiments.rows import Settings
from skillfold.keyframes.gaussians import PoseGaussian

NAMES = ["gate coverage off nominal, position", "gate coverage off nominal, rotation"] + [
    f"keyframes recovered, {kind}" for kind in ("clean", "15 % missing", "15 % extra", "both")
]


def test_rows():
    rows = measure(Settings(5), Counts(skills=1, poses=4))
    assert [row.name for row in rows] == NAMES
    assert all(row.target is not None and row.measured is not None for row in rows)
    assert rows == measure(Settings(5), Counts(skills=1, poses=4))


def test_the_region_of_a_keyframe_holds_its_share():
    truth = random_truth(np.random.default_rng(1))
    assert pytest.approx(chi2.ppf(0.975, 3), abs=1e-3) == QUANTILE
    rng = np.random.default_rng(2)
    held = np.mean([truth.holds(1, truth.draw(1, rng)) for _ in range(2000)])
    assert held == pytest.approx(0.975**2, abs=0.015)


def test_consecutive_keyframes_lie_apart():
    for seed in range(20):
        truth = random_truth(np.random.default_rng(seed))
        assert len(truth.positions) == 4
        angles = [
            np.arccos(np.clip((np.trace(a.T @ b) - 1) / 2, -1, 1))
            for a, b in zip(truth.rotations, truth.rotations[1:], strict=False)
        ]
        assert (
            np.hypot(np.linalg.norm(np.diff(truth.positions, axis=0), axis=1), 0.15 * np.array(angles)).min() > APART
        )


@pytest.mark.parametrize(("missing", "extra"), [(0.0, 0.0), (0.15, 0.0), (0.0, 0.15)])
def test_how_many_keyframes(missing, extra):
    rng = np.random.default_rng(3)
    demos = demonstrate(random_truth(rng), 400, missing, extra, rng)
    assert np.mean([len(demo) for demo in demos]) == pytest.approx(4 * (1 - missing + extra), abs=0.15)


def test_recovered_needs_number_and_order():
    truth = random_truth(np.random.default_rng(4))
    means = [truth.draw(k, np.random.default_rng(0)) for k in range(4)]
    assert recovered(truth, means)
    assert not recovered(truth, means[:3])
    assert not recovered(truth, means[::-1])


def test_within_gates():
    gaussian = PoseGaussian([0, 0, 0, 1, 0, 0, 0], np.diag([0.01**2] * 3 + [0.1**2] * 3), np.array([9.0, 4.0]))
    half = 0.5 * np.array([0.19, 0.21])
    inside, outside = ([0.029, 0, 0, np.cos(h), 0, 0, np.sin(h)] for h in half)
    assert within(gaussian, np.array(inside)) == [True, True]
    assert within(gaussian, np.array(outside)) == [True, False]
    assert within(gaussian, np.array([0.031, 0, 0, -1, 0, 0, 0])) == [False, True]
