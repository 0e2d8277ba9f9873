"""Anchored Newton against its twin on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import newton, scratch_memory
from manifold.random_models import SHAPES, random_model


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(11, *request.param)


def arrays(model):
    return model.surface, model.field


def room(model, n):
    """Scratch memory for n states."""
    return scratch_memory.make_scratch(model.table, n)


@pytest.mark.parametrize(("tolerance", "steps"), [(1e-10, 40), (1e-4, 5)])
@pytest.mark.parametrize("bounded", [False, True])
def test_descend(model, bounded, tolerance, steps):
    """All at once as one by one."""
    trust = model.trust
    limits = (trust.spacing, trust.doubt, trust.cap) if bounded else (np.inf, np.inf, trust.cap)
    states, starts = model.states(20, 0.3), model.states(20, 0.0)
    points = starts.copy()
    met = newton.descend(*limits, states, points, tolerance, float(steps), room(model, 20))
    for i in range(20):
        expected, good = twins.descend(*arrays(model), *limits, states[i], starts[i], tolerance, steps)
        assert met[i] == good
        np.testing.assert_allclose(points[i], expected, atol=1e-8)


def test_step_back(model):
    states = model.states(10, 0.3)
    points, met = states.copy(), np.zeros(10, bool)
    met[3] = True  # left where it is
    newton.step_back(points, 1e-10, room(model, 10), met)
    for i in set(range(10)) - {3}:
        expected, good = twins.step_back(*arrays(model), states[i], 1e-10)
        assert met[i] == good
        np.testing.assert_allclose(points[i], expected, atol=1e-9)
    np.testing.assert_array_equal(points[3], states[3])


@pytest.mark.parametrize("most", [0.01, 0.2, 0.5, 10.0])
@pytest.mark.parametrize("rate", [0.05, 0.12, 0.3, 1.0])
def test_shortened(rate, most):
    assert newton.shortened(rate, most) == twins.shortened(rate, most)


def test_carry_and_begin_at(model):
    """What is known of anchors goes from place to place, and says where they are looked for; never what is found."""
    states, scratch = model.states(4, 0.1), room(model, 4)
    scratch_memory.evaluate(states, scratch)
    newton.carry(scratch, 3, 1)
    for name in ("around", "origins", "known"):
        np.testing.assert_array_equal(getattr(scratch, name)[1], getattr(scratch, name)[3])
    newton.begin_at(model.surface.neighbours, scratch, 2, 4)
    assert scratch.known[2] == 0.0
    if model.surface.neighbours.shape[1]:
        np.testing.assert_array_equal(scratch.around[2], model.surface.neighbours[4, :16])
    scratch_memory.evaluate(states[[0, 3, 2, 1]].copy(), scratch)
    expected = [twins.nearest(model.surface.points, x)[0] for x in states[[0, 3, 2, 1]]]
    np.testing.assert_array_equal(scratch.nearest, expected)
