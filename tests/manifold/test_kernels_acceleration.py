"""Anderson's acceleration, against its twin."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import acceleration


@pytest.mark.parametrize("known", [1, 2, 5])
def test_mix(known):
    rng = np.random.default_rng(known)
    moves, changes = rng.normal(size=(2, known, 7, 3))
    steps = rng.normal(size=(7, 3))
    expected = twins.mix(moves, changes, steps)
    acceleration.mix(moves, changes, steps)
    np.testing.assert_allclose(steps, expected, atol=1e-7)


def test_mix_finds_where_a_linear_iteration_ends():
    """Its steps F = A (q − q*) in two unknown directions: after two changes the end is known."""
    rng = np.random.default_rng(3)
    along = rng.normal(size=(2, 4, 3))
    shares = np.array([0.9, 0.3])  # left of the error in each direction, by each iteration

    def error(k):
        return np.tensordot(shares**k, along, axes=1)

    moves = np.array([error(k + 1) - error(k) for k in range(2)])
    steps = [error(k + 1) - error(k) for k in range(3)]
    changes = np.array([steps[1] - steps[0], steps[2] - steps[1]])
    last = steps[2].copy()
    acceleration.mix(moves, changes, last)
    np.testing.assert_allclose(error(2) + last, 0.0, atol=1e-6)


def test_small_ones():
    rng = np.random.default_rng(0)
    path, steps = rng.normal(size=(2, 6, 3))
    assert acceleration.dot(path[0], steps[0]) == pytest.approx(path[0] @ steps[0], rel=1e-12)
    assert acceleration.longest(steps) == pytest.approx(np.linalg.norm(steps, axis=1).max(), rel=1e-12)
    out = np.empty_like(path)
    acceleration.copy_rows(path, out)
    np.testing.assert_array_equal(out, path)
    lengths = np.linalg.norm(steps, axis=1, keepdims=True)
    expected = path + steps * np.minimum(1.0, 0.8 / lengths)
    acceleration.take(path, steps, 1.0, 0.8)
    np.testing.assert_allclose(path, expected, atol=1e-14)
    assert np.linalg.norm(steps, axis=1).max() == pytest.approx(0.8)
