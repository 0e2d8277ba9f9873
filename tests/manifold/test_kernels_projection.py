"""Projection kernels against their twins on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.random_models import SHAPES, random_model
from skillfold.manifold.kernels import projection
from skillfold.manifold.kernels.surface import make_scratch


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(11, *request.param)


def arrays(model):
    return model.surface, model.field


def room(model):
    """Scratch memory for one state."""
    return make_scratch(*arrays(model), 1), np.empty((4, len(model.surface.points)))


@pytest.mark.parametrize(("tolerance", "steps"), [(1e-10, 30), (1e-4, 5)])
@pytest.mark.parametrize("bounded", [False, True])
def test_descend(model, bounded, tolerance, steps):
    trust = model.trust
    limits = (trust.spacing, trust.doubt, trust.cap) if bounded else (np.inf, np.inf, trust.cap)
    for state, start in zip(model.states(10, 0.3), model.states(10, 0.0), strict=True):
        points = start[None].copy()
        met = projection.descend(*arrays(model), *limits, state, points, tolerance, float(steps), *room(model))
        expected, good = twins.descend(*arrays(model), *limits, state, start, tolerance, steps)
        assert met == good
        np.testing.assert_allclose(points[0], expected, atol=1e-9)


@pytest.mark.parametrize("spacing", [0.05, 0.5])
@pytest.mark.parametrize("sure", [0, 2, None])
def test_find_starts(model, sure, spacing):
    """With no sure anchors, with two, and with as many as there are; few of them around, or many."""
    flags = model.trust.sure if sure is None else np.arange(len(model.trust.sure)) < sure
    trust = model.trust._replace(sure=flags, spacing=spacing)
    scratch = room(model)[0]
    for state in model.states(10, 0.5):
        found = scratch.distances, scratch.starts, scratch.start_squares
        projection.find_starts(model.surface.points, spacing, flags, state, *found)
        np.testing.assert_array_equal(scratch.starts, twins.starts(model.surface, trust, state))


@pytest.mark.parametrize("spread", [0.02, 0.3, 2.0])
def test_project_state_alone_and_in_batches(model, spread):
    states = model.states(6, spread)
    points, met = projection.project_states(*arrays(model), model.trust, states)
    scratch, work = room(model)
    for state, point, good in zip(states, points, met, strict=True):
        expected, found = twins.project_state(*arrays(model), model.trust, state)
        assert good == found
        np.testing.assert_allclose(point, expected, atol=1e-9)
        out = np.empty((1, len(state)))
        assert projection.project_state(*arrays(model), model.trust, state, scratch, work, out) == good
        np.testing.assert_array_equal(out[0], point)


def test_project_near(model):
    states, starts = model.states(10, 0.2), model.states(10, 0.05)
    given = starts.copy()
    points, met = projection.project_near(*arrays(model), model.trust, states, starts)
    np.testing.assert_array_equal(starts, given)
    for i, state in enumerate(states):
        expected, good = twins.descend(*arrays(model), np.inf, np.inf, model.trust.cap, state, starts[i])
        assert met[i] == good
        np.testing.assert_allclose(points[i], expected, atol=1e-9)


@pytest.mark.parametrize(("rate", "steps"), [(0.1, 300), (0.7, 7), (1.0, 0)])
def test_follow_leaf(model, rate, steps):
    states, starts = model.states(6, 0.2), model.states(6, 0.0)
    found = projection.follow_leaf(model.field, states, starts, rate, steps)
    expected = [twins.follow_leaf(model.field, *pair, rate, steps) for pair in zip(states, starts, strict=True)]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_step_back(model):
    for x in model.states(10, 0.3):
        points = x[None].copy()
        met = projection.step_back(*arrays(model), points, 1e-10, room(model)[0])
        expected, good = twins.step_back(*arrays(model), x, 1e-10)
        assert met == good
        np.testing.assert_allclose(points[0], expected, atol=1e-9)


def test_gap(model):
    a, b = model.states(2, 1.0)
    assert projection.gap(a, b) == pytest.approx(((a - b) ** 2).sum(), rel=1e-12)


def test_field_bases(model):
    states = model.states(10, 1.0)
    expected = [twins.tangent_basis(model.field, x)[0] for x in states]
    np.testing.assert_allclose(projection.field_bases(model.field, states), expected, atol=1e-10)


def test_displacements(model):
    states = model.states(10, 0.5)
    expected = [twins.displacement(*arrays(model), x) for x in states]
    normals, nearest, doubts = projection.displacements(*arrays(model), states)
    np.testing.assert_allclose(normals, [e[0] for e in expected], atol=1e-10)
    np.testing.assert_allclose(nearest, [np.sqrt(e[2]) for e in expected], atol=1e-10)
    np.testing.assert_allclose(doubts, [e[3] for e in expected], atol=1e-6)


@pytest.mark.parametrize("enough", [0.0, 1e-6, 0.05])
@pytest.mark.parametrize("spread", [0.0, 0.3])
def test_judge(model, spread, enough):
    states = model.states(6, spread)
    expected = [twins.distance(*arrays(model), model.trust, x, enough) for x in states]
    off, nearest = projection.judge(*arrays(model), model.trust, states, enough)
    np.testing.assert_allclose(off, expected, atol=1e-9)
    np.testing.assert_allclose(nearest, projection.nearest_distances(*arrays(model), states), atol=1e-12)


def test_judge_next_to_the_surface(model):
    """Where the displacement is taken for the distance, unless the anchors disagree."""
    on, met = projection.project_states(*arrays(model), model.trust, model.states(20, 0.05))
    assert met.any()
    states = on[met] + 1e-7 * model.rng.normal(size=on[met].shape)
    expected = [twins.distance(*arrays(model), model.trust, x, 1e-6) for x in states]
    found, _ = projection.judge(*arrays(model), model.trust, states, 1e-6)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_nearest_distances(model):
    states = model.states(10, 0.5)
    expected = np.linalg.norm(states[:, None] - model.surface.points.T, axis=2).min(1)
    np.testing.assert_allclose(projection.nearest_distances(*arrays(model), states), expected, atol=1e-12)
