"""Kernels of the law against NumPy; that no kernel goes without a twin."""

from pathlib import Path

import numpy as np
import pytest

from control import twins
from skillfold.control.kernels import law, reference, step

GAINS = np.array([100.0, 80.0, 1600.0, 1.0, 2.0, 0.1])


@pytest.mark.parametrize("module", [law, reference, step], ids=lambda m: m.__name__.split(".")[-1])
def test_every_kernel_is_tested(module):
    name = module.__name__.split(".")[-1]
    found = {n for n, f in vars(module).items() if hasattr(f, "py_func") and f.py_func.__module__ == module.__name__}
    text = (Path(__file__).parent / f"test_kernels_{name}.py").read_text(encoding="utf-8")
    assert found
    assert {kernel for kernel in found if f"{name}.{kernel}(" not in text} == set()


@pytest.fixture
def rng():
    return np.random.default_rng(1)


@pytest.mark.parametrize(("D", "E", "d"), [(3, 3, 2), (7, 7, 3), (6, 4, 2), (2, 2, 1)])
def test_across(rng, D, E, d):
    kept = np.ascontiguousarray(np.linalg.qr(rng.normal(size=(D, E)))[0])
    basis = np.ascontiguousarray(np.linalg.qr(rng.normal(size=(E, d)))[0].T)
    vector, out = rng.normal(size=D), np.empty(D)
    law.across(kept, basis, vector, np.empty(E), out)
    assert np.allclose(out, twins.tangent_projector(kept, basis) @ vector)


def test_stiffness_grows_with_the_distance_and_no_further():
    grown = [law.stiffness(1600.0, 2.0, 0.1, distance) for distance in (0.0, 0.05, 0.1, 5.0)]
    assert np.allclose(grown, [1600.0, 2400.0, 3200.0, 3200.0])


@pytest.mark.parametrize("most", [np.inf, 100.0, 20.0])
def test_feedback(rng, most):
    parts, out = 0.05 * rng.normal(size=(4, 5)), np.empty(5)
    law.feedback(GAINS, *parts, most, out)
    assert np.allclose(out, twins.feedback(GAINS, *parts, most))


def test_eased():
    assert law.eased(1600.0, 80.0, 1000.0) == (1600.0, 80.0)
    assert np.allclose(law.eased(1600.0, 80.0, 20.0), (100.0, 20.0))
    assert np.allclose(law.eased(1600.0, 80.0, 20.0), twins.eased(1600.0, 80.0, 20.0))


def test_bound(rng):
    for scale in (0.1, 10.0):
        vector, limit = scale * rng.normal(size=5), rng.uniform(0.5, 2.0, 5)
        expected = twins.bound(vector, limit)
        law.bound(vector, limit)
        assert np.allclose(vector, expected)


@pytest.mark.parametrize("interval", [0.0, 0.001, 0.05])
def test_restrain(rng, interval):
    for _ in range(200):
        q, qd, wanted = rng.uniform(-1.2, 1.2, 4), rng.normal(size=4), 100 * rng.normal(size=4)
        limits = np.full(4, -1.0), np.full(4, 1.0), np.full(4, 1.0), np.full(4, 5.0), np.full(4, 50.0)
        out = wanted.copy()
        law.restrain(q, qd, *limits, interval, out)
        assert np.allclose(out, twins.restrain(q, qd, *limits, interval, wanted))
