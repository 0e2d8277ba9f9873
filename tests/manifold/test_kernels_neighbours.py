"""The search for the nearest anchors, against its twin on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import neighbours
from manifold.random_models import SHAPES, random_model


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(7, *request.param)


def test_nearest_anchors_and_among_ask_the_neighbours_first(model):
    rows, listed = model.surface.rows, model.surface.neighbours
    if not listed.shape[1]:
        assert len(rows) < 192
        return
    state = rows[7:8] + 1e-3
    nearest, squares = np.full((1, 9), 7), np.empty((1, 9))
    own = neighbours.among(rows, listed, 7, state, 0, nearest, squares)
    assert own == pytest.approx(len(rows[0]) * 1e-6, rel=1e-9)
    np.testing.assert_array_equal(nearest[0], twins.nearest(model.surface.points, state[0])[0])
    all_of_them = np.full(len(rows), np.nan)  # not asked: their distances stay as they are
    neighbours.nearest_anchors(
        model.surface.points, rows, listed, model.surface.reaches, state, all_of_them, nearest, squares
    )
    assert np.isnan(all_of_them).all()


@pytest.mark.parametrize(("count", "wanted"), [(20, 1), (20, 5), (5, 5), (1, 1)])
def test_smallest(count, wanted):
    values = np.random.default_rng(count).normal(size=count)
    indices, found = np.zeros(wanted, np.int64), np.empty(wanted)
    neighbours.smallest(values, indices, found)
    np.testing.assert_array_equal(indices, values.argsort()[:wanted])
    np.testing.assert_array_equal(found, np.sort(values)[:wanted])


@pytest.mark.parametrize("wanted", [1, 5, 20])
def test_farthest_and_smallest_within(wanted):
    """Any places will do to say how far to look."""
    rng = np.random.default_rng(wanted)
    values, places = rng.normal(size=20) ** 2, rng.choice(20, wanted, replace=False)
    bound = neighbours.farthest(values, places)
    assert bound == values[places].max()
    indices, found = np.zeros(wanted, np.int64), np.empty(wanted)
    neighbours.smallest_within(values, bound, indices, found)
    np.testing.assert_array_equal(indices, values.argsort()[:wanted])
    np.testing.assert_array_equal(found, np.sort(values)[:wanted])


def test_smallest_passes_over_infinities():
    indices, found = np.full(3, 7), np.empty(3)
    neighbours.smallest(np.array([np.inf, 2.0, np.inf, 1.0]), indices, found)
    np.testing.assert_array_equal(indices, [3, 1, 7])
    np.testing.assert_array_equal(found, [1.0, 2.0, np.inf])
