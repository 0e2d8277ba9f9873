"""The tangent field, against its twin on random models."""

import numba
import numpy as np
import pytest

from manifold import twins
from manifold.kernels import tangents
from manifold.random_models import SHAPES, random_model
from skillfold.jit import njit
from skillfold.lanes import load, store
from skillfold.manifold import kernels
from skillfold.manifold.kernels import tabled


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(7, *request.param)


@numba.njit
def kernels_of(t):
    return tabled.matrix(t, tabled.CENTRES).copy(), tabled.matrix(t, tabled.WEIGHTS).copy()


def bases_at(model, states):
    centres, weights = kernels_of(model.table)
    bases, memory = np.empty((len(states), len(model.field.weights), states.shape[1])), map(np.empty, weights.shape)
    assert tangents.tangent_bases(centres, model.field.precision, weights, states, *memory, bases)
    return bases


@pytest.mark.parametrize("spread", [0.0, 1.0, 1e4])
def test_features_at(model, spread):
    """The largest is 1, and those that fill up are next to nothing."""
    centres = kernels_of(model.table)[0]
    states, features = model.states(5, spread), np.empty(centres.shape[1])
    for i, x in enumerate(states):
        tangents.features_at(centres, model.field.precision, states, i, np.empty(4), features)
        square = ((model.field.centres - x[:, None]) ** 2).sum(0)
        expected = np.exp((square.min() - square) * model.field.precision)
        np.testing.assert_allclose(features[: len(expected)], expected, rtol=1e-9, atol=1e-16)
        assert features[len(expected) :].max(initial=0.0) < 1e-16


def test_tangent_bases(model):
    states = model.states(20, spread=1.0)
    expected = [twins.tangent_basis(model.field, x)[0] for x in states]
    np.testing.assert_allclose(bases_at(model, states), expected, atol=1e-10)


def test_tangent_bases_far_away_are_those_of_the_nearest_centre(model):
    x = 1e4 * model.rng.normal(size=len(model.surface.points))
    k = np.linalg.norm(model.field.centres - x[:, None], axis=0).argmin()
    expected = twins.orthonormalise(model.field.weights[:, :, k])[0]
    np.testing.assert_allclose(bases_at(model, x[None])[0], expected, atol=1e-10)


@pytest.mark.parametrize("turned", [0.0, 0.1, 1.0, 5.0])
def test_stand_in(model, turned):
    """Rows turned by more and more away from the surface, of which those that lie across it are replaced."""
    s = model.surface
    ordered = [twins.nearest(s.points, x) for x in model.states(40)]
    nearest, squares = (np.array(values) for values in zip(*ordered, strict=True))
    weights = np.array([twins.blend_weights(square) for square in squares])
    rows = s.tangents[nearest[:, 0]] * s.radii[nearest[:, 0], None, None]
    rows = rows + turned * model.rng.normal(size=rows.shape)
    bases = np.array([twins.orthonormalise(row)[0] for row in rows])
    expected = [twins.stand_in(s, *known) for known in zip(nearest[:, :-1], weights, bases, strict=True)]
    replaced = np.array([not np.array_equal(a, b) for a, b in zip(expected, bases, strict=True)])
    assert replaced.any() == (turned > 0.5)
    tangents.stand_in(
        s.charts, s.radii, nearest, weights, np.empty(s.charts.shape[2]), np.empty(rows.shape[1:]), bases
    )
    np.testing.assert_allclose(bases, expected, atol=1e-9)


def test_a_direction_across_comes_from_the_anchors_and_another_stays():
    model = random_model(3, *SHAPES[-1])
    s, (d, D) = model.surface, model.field.weights.shape[:2]
    whole = np.linalg.qr(model.rng.normal(size=(D, D)))[0].T
    surface = s._replace(charts=s.charts.copy(), radii=np.ones_like(s.radii))
    surface.charts[:, 1:, :d] = whole[:d].T
    basis = np.concatenate([whole[: d - 1], whole[d : d + 1]])[None]
    nearest, weights = np.array([[0, 1, 2]]), np.array([[0.7, 0.3]])
    tangents.stand_in(
        surface.charts, surface.radii, nearest, weights, np.empty(s.charts.shape[2]), np.empty((d, D)), basis
    )
    np.testing.assert_allclose(basis[0].T @ basis[0], whole[:d].T @ whole[:d], atol=1e-12)


def test_along_chart(model):
    s, states = model.surface, model.states(len(model.surface.rows))
    bases, row = np.array([twins.tangent_basis(model.field, x)[0] for x in states]), np.empty(s.charts.shape[2])
    for j, basis in enumerate(bases):
        expected = ((basis @ s.tangents[j].T * s.radii[j]) ** 2).sum()
        assert tangents.along_chart(s.charts, s.radii, j, basis, row) == pytest.approx(expected, rel=1e-12)


def test_lend(model):
    s, x = model.surface, model.states(1)[0]
    nearest, squares = twins.nearest(s.points, x)
    weights, basis = twins.blend_weights(squares), twins.tangent_basis(model.field, x)[0]
    expected = twins.lend(s, nearest[:-1], weights, 0.3, basis)
    tangents.lend(s.charts, s.radii, nearest, weights, 0.3, np.empty(basis.shape), basis)
    np.testing.assert_allclose(basis, expected, atol=1e-9)


@njit
def all_falling(x, out):
    store(kernels.tangents.falling(load(x, 0)), out, 0)


def test_falling():
    x, found = np.array([0.0, -1e-9, -1.0, -39.9]), np.empty(4)
    all_falling(x, found)
    np.testing.assert_allclose(found, np.exp(x), rtol=1e-10, atol=1e-13)


def test_falling_ends_in_next_to_nothing():
    found = np.empty(4)
    all_falling(np.array([-40.0, -41.0, -1e5, -1e300]), found)
    assert (found > 0.0).all()
    assert found.max() < 1e-17


def test_remove_tangential(model):
    states = model.states(10)
    bases, vectors = bases_at(model, states), model.rng.normal(size=states.shape)
    expected = vectors - np.einsum("iac,iab,ib->ic", bases, bases, vectors)
    tangents.remove_tangential(bases, vectors, np.empty(bases.shape[1]))
    np.testing.assert_allclose(vectors, expected, atol=1e-13)


def test_keep_tangential(model):
    """There may be more bases than vectors."""
    states = model.states(10)
    bases, vectors = bases_at(model, states), model.rng.normal(size=states[:7].shape)
    expected = np.einsum("iac,iab,ib->ic", bases[:7], bases[:7], vectors)
    tangents.keep_tangential(bases, vectors, np.empty(bases.shape[1]))
    np.testing.assert_allclose(vectors, expected, atol=1e-13)
