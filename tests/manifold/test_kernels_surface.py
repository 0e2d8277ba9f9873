"""The modelled surface at states, against its twins on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import evaluated, surface
from manifold.random_models import SHAPES, random_model


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(7, *request.param)


def test_blend(model):
    states = model.states(20, spread=0.3)
    squares = evaluated(model, states).squares
    weights = np.empty((20, squares.shape[1] - 1))
    surface.blend(squares, weights)
    r = np.sqrt((squares[:, :-1] - squares[:, :1]) / (squares[:, -1:] - squares[:, :1]))
    expected = (1 - r) ** 4 * (4 * r + 1)
    np.testing.assert_allclose(weights, expected / expected.sum(1, keepdims=True), atol=1e-12)


def from_one_anchor(model, i, x):
    """`displace` with all the weight on one anchor."""
    s, d = model.surface, model.field.weights.shape[0]
    normals, doubts = np.empty((1, len(x))), np.empty(1)
    work = np.empty(len(x)), np.empty(d), np.empty(s.parents.size), np.zeros(s.bends.shape[2])
    layout = s.parents, s.factors, s.degrees
    surface.displace(
        s.rows, s.tangents, s.bends, *layout, x[None], np.array([[i]]), np.ones((1, 1)), *work, normals, doubts
    )
    assert doubts[0] == pytest.approx(0.0, abs=1e-6)
    return normals[0]


@pytest.mark.parametrize("spread", [0.1, 3.0])
def test_displace(model, spread):
    """Near the anchor and far beyond the polynomial's own reach."""
    for x in model.states(20, spread):
        i = int(model.rng.integers(model.surface.points.shape[1]))
        expected = twins.anchor_displacement(model.surface, i, x)
        np.testing.assert_allclose(from_one_anchor(model, i, x), expected, atol=1e-10)


def test_displace_goes_on_straight_beyond_its_reach(model):
    """Along a ray the surface of one anchor is a straight line from 1.5 radii on, and continuous there."""
    ray = model.surface.tangents[0, 0] * model.surface.radii[0] ** 2
    reaches = (1.5 - 1e-9, 1.5 + 1e-9, 2.0, 3.0, 4.0)
    heights = [from_one_anchor(model, 0, model.surface.rows[0] + reach * ray) for reach in reaches]
    np.testing.assert_allclose(heights[0], heights[1], atol=1e-8)
    np.testing.assert_allclose(heights[3] - heights[2], heights[4] - heights[3], atol=1e-12)


def test_displace_is_across_the_anchor(model):
    for i, x in enumerate(model.states(5, 0.3)):
        across = model.surface.tangents[i] @ from_one_anchor(model, i, x)
        np.testing.assert_allclose(across, 0.0, atol=1e-10)
