"""Nearest samples by either way against sorting by hand."""

import numpy as np
import pytest

from skillfold.manifold import nearest as room
from skillfold.manifold.nearest import least, nearest


@pytest.mark.parametrize("k", [1, 7, 40, 200])
@pytest.mark.parametrize("jobs", [1, 2])
def test_nearest_are_the_nearest_in_order(k, jobs):
    rng = np.random.default_rng(k)
    samples, states = rng.normal(size=(200, 4)), rng.normal(size=(90, 4))
    expected = np.linalg.norm(samples - states[:, None], axis=2).argsort(1)[:, :k]
    np.testing.assert_array_equal(nearest(samples, states, k, jobs), expected)


def test_both_ways_agree(monkeypatch):
    samples = np.random.default_rng(0).normal(size=(150, 3))
    sorted_out = nearest(samples, samples, 60)
    monkeypatch.setattr(room, "MOST", 0)
    np.testing.assert_array_equal(sorted_out, nearest(samples, samples, 60))
    assert (sorted_out[:, 0] == np.arange(150)).all()


@pytest.mark.parametrize(("n", "k"), [(1, 1), (2, 2), (300, 1), (300, 40), (1024, 1024), (1025, 7)])
def test_the_least_are_those_that_come_first_when_sorted(n, k):
    """To the bit where numbers differ by more than a millionth of a millionth."""
    squares = np.random.default_rng(n + k).exponential(size=(30, n)) ** 8
    expected = squares.argsort(axis=1, kind="stable")[:, :k]
    np.testing.assert_array_equal(least(squares.copy(), k), expected)


def test_of_equal_numbers_the_first_column_comes_first():
    squares = np.random.default_rng(0).integers(0, 4, (20, 90)).astype(float)
    expected = squares.argsort(axis=1, kind="stable")[:, :30]
    np.testing.assert_array_equal(least(squares, 30), expected)
