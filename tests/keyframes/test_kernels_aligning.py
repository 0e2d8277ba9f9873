"""Sequences laid along places against every way to lay them."""

from itertools import combinations

import numpy as np
import pytest

from skillfold.keyframes.kernels.aligning import EXTRA, lay_along


def lay_along_twin(found, missed, extra):
    """Best labels (m,) by trying all: any keyframes, in order, at any places, in order."""
    count, places = found.shape
    best, labels = -np.inf, None
    for size in range(min(count, places) + 1):
        for rows in combinations(range(count), size):
            for columns in combinations(range(places), size):
                score = sum(found[i, k] for i, k in zip(rows, columns, strict=True)) + extra * (count - size)
                score += sum(missed[k] for k in range(places) if k not in columns)
                if score > best:
                    best, labels = score, np.full(count, EXTRA)
                    labels[list(rows)] = columns
    return labels


@pytest.mark.parametrize(("count", "places"), [(1, 1), (1, 4), (4, 1), (3, 3), (5, 4), (4, 5)])
def test_lay_along(count, places):
    rng = np.random.default_rng(10 * count + places)
    found = rng.normal(0, 3, (12, count + 1, places))
    missed = rng.normal(-1, 1, (12, places))
    labels = np.full((12, count + 1), 77)
    lay_along(found, missed, -1.5, count, np.empty((count + 2, places + 1)), labels)
    for s in range(12):
        np.testing.assert_array_equal(labels[s, :count], lay_along_twin(found[s, :count], missed[s], -1.5))
    assert (labels[:, count] == 77).all()


def test_impossible_places_stay_empty():
    labels = np.empty((1, 2), np.int64)
    lay_along(np.full((1, 2, 3), -np.inf), np.full((1, 3), -1.0), -2.0, 2, np.empty((3, 4)), labels)
    np.testing.assert_array_equal(labels, [[EXTRA, EXTRA]])
