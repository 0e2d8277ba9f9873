"""Nearest points of ellipsoids; and that no kernel of this family goes without a twin."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from keyframes.envelopes import nearest_in_ellipsoid, spd
from manifold.kernels import callable_of
from skillfold.keyframes.kernels import ellipsoids as _ellipsoids

ellipsoids = callable_of(_ellipsoids)
UPPER = np.triu_indices(3)


@pytest.mark.parametrize("name", ["charts", "ellipsoids", "chains", "envelope", "hand_written"])
def test_every_kernel_is_tested(name):
    module = import_module(f"skillfold.keyframes.kernels.{name}")
    kernels = {
        n for n, f in vars(module).items() if hasattr(f, "py_func") and f.py_func.__module__ == module.__name__
    }
    text = (Path(__file__).parent / f"test_kernels_{name}.py").read_text(encoding="utf-8")
    assert kernels
    assert {kernel for kernel in kernels if f"{name}.{kernel}(" not in text} == set()


@pytest.fixture(params=[1.0, 1e-2, 1e-5], ids=str)
def drawn(request):
    """A matrix, as thin as that, and a vector."""
    rng = np.random.default_rng(3)
    sigma = spd(rng, [0.3, 0.3 * np.sqrt(request.param), 0.3 * request.param])
    return sigma, tuple(sigma[UPPER]), tuple(rng.normal(size=3))


def test_solved_times_and_dot(drawn):
    sigma, six, v = drawn
    np.testing.assert_allclose(ellipsoids.times(six, v), sigma @ v, rtol=1e-12, atol=1e-16)
    np.testing.assert_allclose(sigma @ ellipsoids.solved(six, 0.0, v), v, rtol=1e-5)
    np.testing.assert_allclose(
        ellipsoids.solved(six, 0.2, v), np.linalg.solve(sigma + 0.2 * np.eye(3), v), rtol=1e-11
    )
    assert ellipsoids.dot(v, six[:3]) == pytest.approx(np.dot(v, six[:3]), rel=1e-14)


def test_multiplier(drawn):
    """Outside the point it tells is on the edge, nearest by optimality and by bisection; inside it is the point."""
    sigma, six, v = drawn
    for scale in (1e-9, 0.5, 1.0, 1e3):
        mu, *x = ellipsoids.multiplier(six, tuple(scale * np.array(v)))
        x = np.array(x)
        w = sigma @ x
        wanted = nearest_in_ellipsoid(sigma, scale * np.array(v))
        np.testing.assert_allclose(w, wanted, atol=1e-9)
        np.testing.assert_allclose(w + mu * x, scale * np.array(v), rtol=1e-7, atol=1e-9)
        assert mu >= 0
        assert mu == 0 or x @ w == pytest.approx(1, abs=1e-12)
