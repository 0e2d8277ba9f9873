"""The surface and the field evaluated at states, against their twins on random models."""

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import evaluated, scratch_memory
from manifold.random_models import SHAPES, random_model
from skillfold.manifold.kernels.scratch import SLOTS, evaluator
from skillfold.manifold.kernels.surface import Field
from skillfold.manifold.kernels.tabled import tabled
from skillfold.manifold.model import as_maps, build_surface
from skillfold.manifold.polynomials import monomials


@pytest.fixture(params=SHAPES, ids=str, scope="module")
def model(request):
    return random_model(7, *request.param)


def test_make_scratch(model):
    D, M = model.surface.points.shape
    scratch = scratch_memory.make_scratch(model.table, 6)
    assert scratch.distances.shape == (M,)
    assert scratch.nearest.shape == scratch.squares.shape == (6, min(8, M - 1) + 1)
    assert scratch.starts.shape == scratch.start_squares.shape == (4,)
    assert scratch.bases.shape == (6, model.field.weights.shape[0], D)


def test_scratch_memory_is_in_its_table(model):
    """Each array is where its slot says, with as many rows and columns."""
    scratch = scratch_memory.make_scratch(model.table, 3)
    given = scratch._asdict()
    for name in ("model", "table", "evaluator", "starts", "start_squares"):
        given.pop(name)
    entries = scratch.table.reshape(-1, 3)
    assert len(entries) == SLOTS == len(given)
    by_address = {array.ctypes.data: array for array in given.values()}
    for where, rows, columns in entries:
        array = by_address.pop(where)
        assert rows * columns == array.size
        assert columns == (array.shape[-1] if array.ndim > 1 else array.size)


@pytest.mark.parametrize("spread", [0.0, 0.05, 0.5, 20.0])
def test_find_nearest(model, spread):
    """Among the neighbours of the anchor that was nearest before, or among all: the same."""
    scratch = scratch_memory.make_scratch(model.table, 50)
    for _ in range(2):
        states = model.states(50, spread) + 1e-9 * model.rng.normal(size=(50, len(model.surface.points)))
        scratch_memory.find_nearest(states, scratch)
        expected = [twins.nearest(model.surface.points, x) for x in states]
        np.testing.assert_array_equal(scratch.nearest, [order for order, _ in expected])
        np.testing.assert_allclose(scratch.squares, [square for _, square in expected], atol=1e-12, rtol=1e-12)


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
    scratch = scratch_memory.make_scratch(model.table, 1)
    for i in range(20):
        scratch_memory.evaluate(states[i : i + 1], scratch)
        np.testing.assert_allclose(scratch.normals[0], together[i], atol=1e-14)


def test_evaluate_where_all_anchors_are_one_point():
    """No width to blend over: equal weights, no division by zero."""
    points = np.tile([[1.0], [2.0]], (1, 4))
    maps = as_maps(np.tile(np.eye(2), (4, 1, 1)), np.zeros((4, 1, 2)), np.ones(4))
    sheet = build_surface(points, *maps, np.ones(4), monomials(1, 1))
    field = Field(np.zeros((2, 1)), 1.0, np.array([[[1.0], [0.0]]]))
    table = tabled(sheet, field, np.zeros(2), np.eye(2), 1.0, evaluator())
    scratch = scratch_memory.make_scratch(table.entries, 1)
    scratch_memory.evaluate(np.array([[1.5, 2.25]]), scratch)
    np.testing.assert_allclose(scratch.normals[0], [0.0, 0.25], atol=1e-15)


def test_evaluate_where_the_field_lies_across_the_surface():
    """The displacement from a straight line is not along it, whatever the field says."""
    points = np.array([np.linspace(-1.0, 1.0, 9), np.zeros(9)])
    maps = as_maps(np.tile(np.eye(2), (9, 1, 1)), np.zeros((9, 1, 2)), np.ones(9))
    line = build_surface(points, *maps, np.ones(9), monomials(1, 1))
    field = Field(np.zeros((2, 1)), 1.0, np.array([[[0.0], [1.0]]]))
    table = tabled(line, field, np.zeros(2), np.eye(2), 1.0, evaluator())
    scratch = scratch_memory.make_scratch(table.entries, 1)
    scratch_memory.evaluate(np.array([[1.5, 0.25]]), scratch)
    np.testing.assert_allclose(scratch.normals[0], [0.0, 0.25], atol=1e-15)
    np.testing.assert_allclose(scratch.bases[0], [[1.0, 0.0]], atol=1e-15)
