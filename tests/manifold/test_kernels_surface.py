"""The modelled surface and the tangent field at states, against their twins on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import surface
from manifold.random_models import SHAPES, random_model
from skillfold.manifold.model import as_maps, build_surface
from skillfold.manifold.polynomials import monomials


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(7, *request.param)


def evaluated(model, states):
    scratch = surface.make_scratch(model.surface, model.field, len(states))
    surface.evaluate(model.surface, model.field, states, scratch)
    return scratch


def test_make_scratch(model):
    D, M = model.surface.points.shape
    scratch = surface.make_scratch(model.surface, model.field, 6)
    assert scratch.distances.shape == (M,)
    assert scratch.nearest.shape == scratch.squares.shape == (6, min(8, M - 1) + 1)
    assert scratch.starts.shape == scratch.start_squares.shape == (4,)
    assert scratch.bases.shape == (6, model.field.weights.shape[0], D)


@pytest.mark.parametrize("spread", [0.0, 0.05, 0.5, 20.0])
def test_find_nearest(model, spread):
    """Among the neighbours of the anchor that was nearest before, or among all: the same."""
    scratch = surface.make_scratch(model.surface, model.field, 50)
    for _ in range(2):
        states = model.states(50, spread) + 1e-9 * model.rng.normal(size=(50, len(model.surface.points)))
        surface.find_nearest(model.surface, states, scratch)
        expected = [twins.nearest(model.surface.points, x) for x in states]
        np.testing.assert_array_equal(scratch.nearest, [order for order, _ in expected])
        np.testing.assert_allclose(scratch.squares, [square for _, square in expected], atol=1e-12, rtol=1e-12)


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


@pytest.mark.parametrize("spread", [0.0, 0.1, 2.0])
def test_evaluate(model, spread):
    states = model.states(20, spread)
    scratch = evaluated(model, states)
    for i, x in enumerate(states):
        expected, basis, nearest, doubt = twins.displacement(model.surface, model.field, x)
        np.testing.assert_allclose(scratch.normals[i], expected, atol=1e-10)
        np.testing.assert_allclose(scratch.bases[i], basis, atol=1e-10)
        assert scratch.squares[i, 0] == pytest.approx(nearest, abs=1e-12)
        # A square root of a difference of squares: eps of the squares is half the digits of the root.
        assert scratch.doubts[i] == pytest.approx(doubt, abs=1e-6)


def test_evaluate_one_by_one_is_the_same_but_for_rounding(model):
    states = model.states(20, 0.2)
    together = evaluated(model, states).normals
    scratch = surface.make_scratch(model.surface, model.field, 1)
    for i in range(20):
        surface.evaluate(model.surface, model.field, states[i : i + 1], scratch)
        np.testing.assert_allclose(scratch.normals[0], together[i], atol=1e-14)


def test_evaluate_where_all_anchors_are_one_point():
    """No width to blend over: equal weights, no division by zero."""
    points = np.tile([[1.0], [2.0]], (1, 4))
    maps = as_maps(np.tile(np.eye(2), (4, 1, 1)), np.zeros((4, 1, 2)), np.ones(4))
    sheet = build_surface(points, *maps, np.ones(4), monomials(1, 1))
    field = surface.Field(np.zeros((2, 1)), 1.0, np.array([[[1.0], [0.0]]]))
    scratch = surface.make_scratch(sheet, field, 1)
    surface.evaluate(sheet, field, np.array([[1.5, 2.25]]), scratch)
    np.testing.assert_allclose(scratch.normals[0], [0.0, 0.25], atol=1e-15)
