"""The modelled surface and the tangent field at one state, against their twins on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.random_models import SHAPES, random_model
from skillfold.manifold.kernels import surface
from skillfold.manifold.polynomials import monomials


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(7, *request.param)


def test_make_scratch(model):
    D, M = model.surface.points.shape
    scratch = surface.make_scratch(model.surface, model.field)
    assert scratch.distances.shape == (M,)
    assert scratch.nearest.shape == scratch.squares.shape == (min(8, M - 1) + 1,)
    assert scratch.starts.shape == scratch.start_squares.shape == (4,)
    assert scratch.basis.shape == (model.field.weights.shape[0], D)


def test_tangent_basis(model):
    d, D, K = model.field.weights.shape
    for x in model.states(20, spread=1.0):
        basis, features = np.empty((d, D)), np.empty(K)
        assert surface.tangent_basis(model.field, x, features, basis)
        np.testing.assert_allclose(basis, twins.tangent_basis(model.field, x)[0], atol=1e-10)


def test_tangent_basis_far_away_is_that_of_the_nearest_centre(model):
    d, D, K = model.field.weights.shape
    x = 1e4 * model.rng.normal(size=D)
    k = np.linalg.norm(model.field.centres - x[:, None], axis=0).argmin()
    basis = np.empty((d, D))
    surface.tangent_basis(model.field, x, np.empty(K), basis)
    np.testing.assert_allclose(basis, twins.orthonormalise(model.field.weights[:, :, k])[0], atol=1e-10)


def test_find_nearest(model):
    scratch = surface.make_scratch(model.surface, model.field)
    for x in model.states(20, spread=0.5):
        surface.find_nearest(model.surface.points, x, scratch)
        order, square = twins.nearest(model.surface.points, x)
        np.testing.assert_array_equal(scratch.nearest, order)
        np.testing.assert_allclose(scratch.squares, square, atol=1e-12)


@pytest.mark.parametrize(("count", "wanted"), [(20, 1), (20, 5), (5, 5), (1, 1)])
def test_smallest(count, wanted):
    values = np.random.default_rng(count).normal(size=count)
    indices, found = np.zeros(wanted, np.int64), np.empty(wanted)
    surface.smallest(values, indices, found)
    np.testing.assert_array_equal(indices, values.argsort()[:wanted])
    np.testing.assert_array_equal(found, np.sort(values)[:wanted])


def test_smallest_passes_over_infinities():
    indices, found = np.full(3, 7), np.empty(3)
    surface.smallest(np.array([np.inf, 2.0, np.inf, 1.0]), indices, found)
    np.testing.assert_array_equal(indices, [3, 1, 7])
    np.testing.assert_array_equal(found, [1.0, 2.0, np.inf])


@pytest.mark.parametrize("spread", [0.1, 3.0])
def test_add_displacement(model, spread):
    """Near the anchor and far beyond the polynomial's own reach."""
    scratch = surface.make_scratch(model.surface, model.field)
    for x in model.states(20, spread):
        i = int(model.rng.integers(model.surface.points.shape[1]))
        total = np.ones(len(x))
        square = surface.add_displacement(model.surface, i, x, 0.3, scratch, total)
        expected = twins.anchor_displacement(model.surface, i, x)
        np.testing.assert_allclose(total, 1.0 + 0.3 * expected, atol=1e-10)
        assert square == pytest.approx((expected**2).sum(), rel=1e-10, abs=1e-12)


def test_add_displacement_goes_on_straight_beyond_its_reach(model):
    """Along a ray the surface of one anchor is a straight line from 1.5 radii on, and continuous there."""
    scratch = surface.make_scratch(model.surface, model.field)
    D, d = model.surface.points.shape[0], model.field.weights.shape[0]
    direction = model.surface.frames[0, 0]
    heights = []
    for reach in (1.5 - 1e-9, 1.5 + 1e-9, 2.0, 3.0, 4.0):
        total = np.zeros(D)
        x = model.surface.points[:, 0] + reach * model.surface.radii[0] * direction
        surface.add_displacement(model.surface, 0, x, 1.0, scratch, total)
        heights.append(model.surface.frames[0, d:] @ total)
    np.testing.assert_allclose(heights[0], heights[1], atol=1e-8)
    np.testing.assert_allclose(heights[3] - heights[2], heights[4] - heights[3], atol=1e-12)


@pytest.mark.parametrize("spread", [0.0, 0.1, 2.0])
def test_displacement(model, spread):
    scratch = surface.make_scratch(model.surface, model.field)
    for x in model.states(20, spread):
        normal = np.empty(len(x))
        square = surface.displacement(model.surface, model.field, x, scratch, normal)
        expected, basis, nearest, doubt = twins.displacement(model.surface, model.field, x)
        np.testing.assert_allclose(normal, expected, atol=1e-10)
        np.testing.assert_allclose(scratch.basis, basis, atol=1e-10)
        assert square == pytest.approx(nearest, abs=1e-12)
        # A square root of a difference of squares: eps of the squares is half the digits of the root.
        assert scratch.doubt[0] == pytest.approx(doubt, abs=1e-7)


def test_displacement_where_all_anchors_are_one_point():
    """No width to blend over: equal weights, no division by zero."""
    table = monomials(1, 1)
    points = np.tile([[1.0], [2.0]], (1, 4))
    frames = np.tile(np.eye(2), (4, 1, 1))
    sheet = surface.Surface(points, frames, np.zeros((4, 1, 2)), np.ones(4), *table)
    field = surface.Field(np.zeros((2, 1)), 1.0, np.array([[[1.0], [0.0]]]))
    normal = np.empty(2)
    surface.displacement(sheet, field, np.array([1.5, 2.25]), surface.make_scratch(sheet, field), normal)
    np.testing.assert_allclose(normal, [0.0, 0.25], atol=1e-15)
