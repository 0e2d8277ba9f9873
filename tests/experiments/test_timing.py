"""The plumbing of the timed experiments, on a skill that costs nothing."""

from types import SimpleNamespace

import numpy as np
import pytest

from skillfold.experiments import large, timing
from skillfold.experiments.rows import Settings


class _Flat:
    dim = 2

    def __init__(self, samples, **options):
        self.options = options

    def tangent(self, x):
        return np.zeros((*np.shape(x), self.dim))

    def project(self, x):
        return np.array(x)

    def plan(self, start, goal, points=50):
        return SimpleNamespace(path=SimpleNamespace(states=np.linspace(start, goal, points)), converged=True)


def test_every_line_about_time_is_measured(monkeypatch):
    monkeypatch.setattr(timing, "OPTIMISED_PLANS", 2)
    rows = timing.measure(Settings(0, fit=_Flat))
    assert len({row.name for row in rows}) == len(rows) == 4 + 3 * 4 + 2
    assert all(row.measured is not None and np.isfinite(row.measured) for row in rows)
    assert all(row.met for row in rows if row.name.startswith(("fit", "one", "plans")))


def test_a_plan_that_costs_nothing_beats_the_optimiser(monkeypatch):
    monkeypatch.setattr(timing, "OPTIMISED_PLANS", 2)
    row = timing._optimiser_row(Settings(0, fit=_Flat))
    assert row.measured is not None and row.measured > 20


def test_growth_and_memory_are_ratios_and_gigabytes(monkeypatch):
    answers = {
        "fit_sphere": {"fit": 10.0, "project": 2e-4, "residual": 1e-3, "peak_memory_gb": 1.0},
        "fit_seven": {"fit": 2.0, "dim": 4.0, "peak_memory_gb": 0.5},
    }
    monkeypatch.setattr(large, "alone", lambda module, function, **arguments: answers[function])
    rows = large.measure(Settings(0))
    assert [row.measured for row in rows] == pytest.approx([10.0, 0.2, 1.0, 0.5])
    assert all(row.met for row in rows)
