"""Projection kernels against their twins on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import projection, scratch_memory
from manifold.random_models import SHAPES, random_model


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(11, *request.param)


def arrays(model):
    return model.surface, model.field


def room(model, n):
    """Scratch memory for projections of n states."""
    return scratch_memory.make_scratch(model.table, 4 * n)


@pytest.mark.parametrize("spacing", [0.05, 0.5])
@pytest.mark.parametrize("sure", [0, 2, None])
def test_find_starts(model, sure, spacing):
    """With no sure anchors, with two, and with as many as there are; few of them around, or many."""
    flags = model.trust.sure if sure is None else np.arange(len(model.trust.sure)) < sure
    trust = model.trust._replace(sure=flags, spacing=spacing)
    scratch = room(model, 1)
    for state in model.states(10, 0.5):
        found = scratch.distances, scratch.starts, scratch.start_squares
        projection.find_starts(model.surface.points, spacing, flags, state, *found)
        np.testing.assert_array_equal(scratch.starts, twins.starts(model.surface, trust, state))


@pytest.mark.parametrize("spread", [0.02, 0.3, 2.0])
def test_project_states_in_batches_and_alone(model, spread):
    states = model.states(12, spread)
    points, met = projection.project_states(model.table, model.trust, states)
    for state, point, good in zip(states, points, met, strict=True):
        expected, found = twins.project_state(*arrays(model), model.trust, state)
        assert good == found
        np.testing.assert_allclose(point, expected, atol=1e-8)
        alone, found = projection.project_states(model.table, model.trust, state[None])
        assert found[0] == good
        np.testing.assert_allclose(alone[0], point, atol=1e-8)


@pytest.mark.parametrize(("spread", "ghost"), [(0.02, 0.03), (0.02, 1.0), (0.3, 1.0)])
def test_project_states_about_which_anchors_disagree(model, spread, ghost):
    """More than usually: on the surface and off it, about one sheet and about several."""
    trust = model.trust._replace(doubt=0.002, ghost=ghost)
    states = model.states(12, spread)
    on = projection.project_near(model.table, trust, states, states)[0]
    states = np.concatenate([states, on + 1e-5 * model.rng.normal(size=on.shape)])
    points, met = projection.project_states(model.table, trust, states)
    for state, point, good in zip(states, points, met, strict=True):
        expected, found = twins.project_state(*arrays(model), trust, state)
        assert good == found
        np.testing.assert_allclose(point, expected, atol=1e-8)


def test_project_states_in_several_blocks(model):
    states = model.states(projection.BLOCK + 3, 0.1)
    points, met = projection.project_states(model.table, model.trust, states)
    last = np.ascontiguousarray(states[-3:])
    out, good = np.empty_like(last), np.empty(3, bool)
    projection.project_block(model.trust, last, out, good, room(model, 3))
    np.testing.assert_allclose(points[-3:], out, atol=1e-8)
    np.testing.assert_array_equal(met[-3:], good)


def test_project_far_goes_no_farther_than_the_nearest_foot(model):
    states = model.states(12, 1.0)
    out = np.empty_like(states)
    met = projection.project_far(model.trust, states, out, room(model, 12))
    for state, point, good in zip(states, out, met, strict=True):
        first = model.surface.points.T[twins.starts(model.surface, model.trust, state)[0]]
        foot, found = twins.step_back(*arrays(model), first, 1e-10)
        assert good or not found
        if found:
            assert np.linalg.norm(state - point) <= np.linalg.norm(state - foot) + 1e-8


def test_project_near(model):
    states, starts = model.states(10, 0.2), model.states(10, 0.05)
    given = starts.copy()
    points, met = projection.project_near(model.table, model.trust, states, starts)
    np.testing.assert_array_equal(starts, given)
    for i, state in enumerate(states):
        expected, good = twins.descend(*arrays(model), np.inf, np.inf, model.trust.cap, state, starts[i])
        assert met[i] == good
        np.testing.assert_allclose(points[i], expected, atol=1e-8)


def test_bring_onto(model):
    """The same for the states of a model in a table."""
    states, starts = model.states(10, 0.1), model.states(10, 0.0)
    for found, expected in (
        (projection.bring_onto(model.table, model.trust, states), projection.project_states),
        (projection.bring_onto_near(model.table, model.trust, states, starts), projection.project_near),
    ):
        given = (states, starts)[: 1 if expected is projection.project_states else 2]
        points, met = expected(model.table, model.trust, *given)
        np.testing.assert_allclose(found[0], points, atol=1e-9)
        np.testing.assert_array_equal(found[1], met)


def test_gap(model):
    a, b = model.states(2, 1.0)
    assert projection.gap(a, b) == pytest.approx(((a - b) ** 2).sum(), rel=1e-12)
