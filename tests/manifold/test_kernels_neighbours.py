"""The search for the nearest anchors, against its twin on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import neighbours
from manifold.random_models import SHAPES, random_model


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(7, *request.param)


def known(count, D, around):
    """What is known of the anchors around so many states, at first: their names, and of no state how far."""
    return np.tile(around, (count, 1)), np.empty((1, len(around))), np.zeros((count, D)), np.zeros(count)


def test_search_and_among_ask_the_neighbours_first(model):
    s = model.surface
    state, rows = s.rows[4:5] + 1e-3, s.rows
    around, squares, _, _ = known(1, 1, np.arange(min(16, len(rows))))
    wanted, found = np.empty((1, 3), np.int64), np.empty((1, 3))
    neighbours.among(rows, around, 0, state, 0, wanted, found, 0)
    named = ((rows[around[0]] - state) ** 2).sum(1)
    np.testing.assert_array_equal(wanted[0], named.argsort()[:3])
    np.testing.assert_allclose(found[0], np.sort(named)[:3], rtol=1e-12)
    everywhere = np.linalg.norm(rows - state, axis=1)
    if s.neighbours.shape[1]:
        around[0, :16] = s.neighbours[4, :16]
    distances = np.full(len(rows), np.nan)
    others = neighbours.search(
        s.points, rows, s.neighbours, s.reaches, state, 0, around.shape[1] - 1, distances, around, squares
    )
    np.testing.assert_array_equal(around[0], everywhere.argsort()[:16])
    assert others == np.inf or others <= np.sort(everywhere)[16] + 1e-12
    assert np.isnan(distances).all() == bool(s.neighbours.shape[1])  # not asked: they stay as they are


def test_nearest_anchors_of_states_that_move(model):
    """By short steps and by leaps: what was known before is never told from what is found."""
    s, K, m = model.surface, min(16, len(model.surface.rows)), min(9, len(model.surface.rows))
    states = model.states(6, 0.2)
    kept, distances = known(6, states.shape[1], np.arange(K)), np.empty(len(s.rows))
    for step in (0.0, 1e-9, 1e-3, 0.03, 0.03, 0.1, 1.0, 0.0):
        states = states + step * model.rng.normal(size=states.shape)
        fresh = known(6, states.shape[1], np.arange(K))
        answers = []
        for state_of_knowledge in (kept, fresh):
            nearest, squares = np.empty((6, m), np.int64), np.empty((6, m))
            neighbours.nearest_anchors(
                s.points, s.rows, s.neighbours, s.reaches, states, distances, nearest, squares, *state_of_knowledge
            )
            answers.append((nearest, squares))
        np.testing.assert_array_equal(answers[0][0], answers[1][0])
        np.testing.assert_array_equal(answers[0][1], answers[1][1])
        np.testing.assert_array_equal(answers[0][0], [twins.nearest(s.points, x)[0] for x in states])


def test_apart():
    a, b = np.random.default_rng(0).normal(size=(2, 4, 3))
    assert neighbours.apart(a, 1, b, 2) == pytest.approx(np.linalg.norm(a[1] - b[2]), rel=1e-14)


@pytest.mark.parametrize("step", [1e-3, 0.02, 0.3])
def test_nearest_anchors_of_states_in_a_row(model, step):
    """What is known of one serves the next where that is close by, and never hides a nearer anchor."""
    s, K, m = model.surface, min(16, len(model.surface.rows)), min(9, len(model.surface.rows))
    states = model.states(1, 0.1) + step * np.arange(40)[:, None] * model.rng.normal(size=(1, len(s.points)))
    kept, distances = known(40, states.shape[1], np.arange(K)), np.empty(len(s.rows))
    nearest, squares = np.empty((40, m), np.int64), np.empty((40, m))
    neighbours.nearest_anchors(s.points, s.rows, s.neighbours, s.reaches, states, distances, nearest, squares, *kept)
    np.testing.assert_array_equal(nearest, [twins.nearest(s.points, x)[0] for x in states])
    searches = len(np.unique(kept[2], axis=0))
    assert searches == 1 if len(s.rows) == K else searches < 40 or step > 0.1


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
