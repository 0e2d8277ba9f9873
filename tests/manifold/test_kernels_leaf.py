"""Kernels of leaf, against their twins on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import leaf, projection
from manifold.random_models import SHAPES, random_model


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(11, *request.param)


@pytest.mark.parametrize(("rate", "steps"), [(0.1, 300), (0.7, 7), (1.0, 0)])
def test_follow_leaf(model, rate, steps):
    states, starts = model.states(6, 0.2), model.states(6, 0.0)
    found = leaf.follow_leaf(model.table, states, starts, rate, steps)
    expected = [twins.follow_leaf(model.field, *pair, rate, steps) for pair in zip(states, starts, strict=True)]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_field_bases(model):
    states = model.states(10, 1.0)
    expected = [twins.tangent_basis(model.field, x)[0] for x in states]
    np.testing.assert_allclose(leaf.field_bases(model.table, states), expected, atol=1e-10)
    K, w = (4 * -(-n // 4) for n in (model.field.centres.shape[1], model.field.weights[:, :, 0].size))
    found = np.empty((10, *model.field.weights.shape[:2]))
    leaf.bases_at(model.table, states, np.empty(K), np.empty(w), found)
    np.testing.assert_allclose(found, expected, atol=1e-10)


@pytest.fixture(scope="module")
def ends(model):
    """Pairs of states on the surface, far from each other."""
    anchors = model.surface.points.T
    pairs = []
    for i in model.rng.choice(len(anchors), 5, replace=False):
        far = np.linalg.norm(anchors - anchors[i], axis=1).argsort()[-3]
        on, _ = projection.project_states(model.table, model.trust, anchors[[i, far]])
        pairs.append((on[0], on[1]))
    return pairs


def bent(start, goal, n, rng):
    """A first path beside the straight line, its ends as given."""
    share = np.linspace(0.0, 1.0, n)[:, None]
    return start + share * (goal - start) + 0.05 * np.sin(np.pi * share) * rng.normal(size=start.shape)


@pytest.mark.parametrize("n", [3, 4, 12])
def test_one_step_of_relax_on_field(model, ends, n):
    for start, goal in ends:
        path = bent(start, goal, n, model.rng)
        expected, _, moved = twins.relax_on_field(model.field, path, 0.0, 1)
        found = leaf.relax_on_field(model.table, path, 0.0, 1)
        assert found == pytest.approx((1, moved), abs=1e-10)
        np.testing.assert_allclose(path, expected, atol=1e-10)


def test_relax_on_field_until_it_settles(model, ends):
    for start, goal in ends:
        path = bent(start, goal, 10, model.rng)
        expected, iterations, _ = twins.relax_on_field(model.field, path, 1e-9, 50)
        found = leaf.relax_on_field(model.table, path, 1e-9, 50)
        assert found[0] == iterations < 50
        np.testing.assert_allclose(path, expected, atol=1e-10)


def test_normal_projector(model):
    basis, _ = twins.tangent_basis(model.field, model.states(1)[0])
    out = np.empty((basis.shape[1], basis.shape[1]))
    leaf.normal_projector(basis, out)
    np.testing.assert_allclose(out, np.eye(len(out)) - basis.T @ basis, atol=1e-14)
