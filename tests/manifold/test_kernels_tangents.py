"""The tangent field, against its twin on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import tangents
from manifold.random_models import SHAPES, random_model


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(7, *request.param)


def bases_at(model, states):
    field, features = model.field, np.empty(model.field.centres.shape[1])
    bases = np.empty((len(states), field.weights.shape[0], states.shape[1]))
    assert tangents.tangent_bases(field.centres, field.precision, field.weights, states, features, bases)
    return bases


def test_tangent_bases(model):
    states = model.states(20, spread=1.0)
    expected = [twins.tangent_basis(model.field, x)[0] for x in states]
    np.testing.assert_allclose(bases_at(model, states), expected, atol=1e-10)


def test_tangent_bases_far_away_are_those_of_the_nearest_centre(model):
    x = 1e4 * model.rng.normal(size=len(model.surface.points))
    k = np.linalg.norm(model.field.centres - x[:, None], axis=0).argmin()
    expected = twins.orthonormalise(model.field.weights[:, :, k])[0]
    np.testing.assert_allclose(bases_at(model, x[None])[0], expected, atol=1e-10)


@pytest.mark.parametrize("x", [0.0, -1e-9, -0.3, -1.0, -17.3, -39.9])
def test_falling(x):
    assert tangents.falling(x) == pytest.approx(np.exp(x), rel=1e-12)


def test_falling_ends_in_next_to_nothing():
    assert 0.0 < tangents.falling(-1e300) < 1e-17


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
