"""Kernels of leaf, against their twins on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.random_models import SHAPES, random_model
from skillfold.manifold.kernels import leaf


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(11, *request.param)


def arrays(model):
    return model.surface, model.field


@pytest.mark.parametrize(("rate", "steps"), [(0.1, 300), (0.7, 7), (1.0, 0)])
def test_follow_leaf(model, rate, steps):
    states, starts = model.states(6, 0.2), model.states(6, 0.0)
    found = leaf.follow_leaf(model.field, states, starts, rate, steps)
    expected = [twins.follow_leaf(model.field, *pair, rate, steps) for pair in zip(states, starts, strict=True)]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_field_bases(model):
    states = model.states(10, 1.0)
    expected = [twins.tangent_basis(model.field, x)[0] for x in states]
    np.testing.assert_allclose(leaf.field_bases(model.field, states), expected, atol=1e-10)
