"""The modelled surface at states, against its twins on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import evaluated, surface
from manifold.random_models import SHAPES, random_model
from skillfold.manifold.kernels.surface import BLENDED, REACH


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


def room(model):
    """Memory for a place, a row, coordinates and monomials."""
    s, d = model.surface, len(model.field.weights)
    place, row = np.zeros(s.maps.shape[2]), np.zeros(max(8, s.charts.shape[2]))
    return place, row, np.ones((d + 1, BLENDED)), np.empty((s.parents.size, BLENDED))


def from_one_anchor(model, i, x):
    """`displace` with all the weight on one anchor."""
    s = model.surface
    normals, doubts = np.empty((1, len(x))), np.empty(1)
    layout, all_of_it = (s.parents, s.factors, s.degrees), (np.array([[i]]), np.ones((1, 1)))
    surface.displace(s.charts, s.maps, *layout, x[None], *all_of_it, *room(model), normals, doubts)
    assert doubts[0] == pytest.approx(0.0, abs=1e-6)
    return normals[0]


@pytest.mark.parametrize("spread", [0.1, 3.0])
def test_locate(model, spread):
    s = model.surface
    place, row, coordinates, _ = room(model)
    for j, x in enumerate(model.states(BLENDED, spread)):
        i = int(model.rng.integers(len(s.rows)))
        place[: len(x)] = x
        beyond = surface.locate(s.charts, i, place, row, coordinates, j)
        expected = s.tangents[i] @ (x - s.rows[i])
        assert beyond == coordinates[-1, j] == pytest.approx(max(1.0, np.linalg.norm(expected) / REACH))
        np.testing.assert_allclose(coordinates[:-1, j], expected / beyond, atol=1e-13)


def test_multiply(model):
    s, (_, _, coordinates, monomials) = model.surface, room(model)
    coordinates[:-1] = model.rng.normal(size=coordinates[:-1].shape)
    surface.multiply(s.parents, s.factors, coordinates, monomials)
    exponents = twins.powers(len(coordinates) - 1, s.degrees[-1])
    expected = np.prod(coordinates[:-1].T[:, None] ** exponents, axis=2)
    np.testing.assert_allclose(monomials, expected.T, atol=1e-12)


def test_go_on_straight(model):
    s, (_, _, coordinates, monomials) = model.surface, room(model)
    coordinates[-1], monomials[:] = model.rng.uniform(1.0, 3.0, BLENDED), 2.0
    surface.go_on_straight(s.degrees, coordinates, monomials)
    np.testing.assert_allclose(monomials, 2.0 + 2.0 * np.outer(s.degrees, coordinates[-1] - 1.0), atol=1e-14)


def test_blend_maps(model):
    s, (place, row, _, monomials) = model.surface, room(model)
    m = min(BLENDED, len(s.rows) - 1)
    nearest, weights = model.rng.permutation(len(s.rows))[None, :m], model.rng.dirichlet(np.ones(m))[None]
    x, normals = model.states(1)[0], np.empty((1, len(s.points)))
    place[: len(x)], monomials[:] = x, model.rng.normal(size=monomials.shape)
    spread = surface.blend_maps(s.maps, place, 0, nearest, weights, monomials, row, normals)
    away = [x - s.rows[i] - s.bends[i] @ monomials[:, j] for j, i in enumerate(nearest[0])]
    mean = np.average(away, axis=0, weights=weights[0])
    np.testing.assert_allclose(normals[0], mean, atol=1e-13)
    assert spread**2 == pytest.approx(((away - mean) ** 2).sum(1) @ weights[0], abs=1e-12)


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
