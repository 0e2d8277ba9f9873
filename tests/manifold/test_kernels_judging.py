"""Kernels of judging, against their twins on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.random_models import SHAPES, random_model
from skillfold.manifold.kernels import judging, projection
from skillfold.manifold.projection import judge


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(11, *request.param)


def arrays(model):
    return model.surface, model.field


@pytest.mark.parametrize("ghost", [0.05, np.inf])
def test_displacements(model, ghost):
    states = model.states(10, 0.5)
    expected = [twins.displacement(*arrays(model), x) for x in states]
    off, nearest, doubts = judging.displacements(model.table, states, ghost)
    lengths = [np.hypot(np.linalg.norm(e[0]), e[3] if e[3] > ghost else 0.0) for e in expected]
    np.testing.assert_allclose(off, lengths, atol=1e-10)
    np.testing.assert_allclose(nearest, [np.sqrt(e[2]) for e in expected], atol=1e-10)
    np.testing.assert_allclose(doubts, [e[3] for e in expected], atol=1e-6)


@pytest.mark.parametrize("enough", [0.0, 1e-6, 0.05])
@pytest.mark.parametrize("spread", [0.0, 0.3])
def test_judge(model, spread, enough):
    states = model.states(6, spread)
    expected = [twins.distance(*arrays(model), model.trust, x, enough) for x in states]
    off, nearest = judge(model, states, enough)
    np.testing.assert_allclose(off, expected, atol=1e-9)
    np.testing.assert_allclose(nearest, judging.nearest_distances(model.table, states), atol=1e-12)


def test_judge_next_to_the_surface(model):
    """Where the displacement is taken for the distance, unless the anchors disagree."""
    on, met = projection.bring_onto(model.table, model.trust, model.states(20, 0.05))
    assert met.any()
    states = on[met] + 1e-7 * model.rng.normal(size=on[met].shape)
    expected = [twins.distance(*arrays(model), model.trust, x, 1e-6) for x in states]
    found, _ = judge(model, states, 1e-6)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_nearest_distances(model):
    states = model.states(10, 0.5)
    expected = np.linalg.norm(states[:, None] - model.surface.points.T, axis=2).min(1)
    np.testing.assert_allclose(judging.nearest_distances(model.table, states), expected, atol=1e-12)
