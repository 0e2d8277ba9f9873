"""A model in a table: the same numbers come out."""

import numba
import numpy as np
import pytest

from manifold.random_models import SHAPES, random_model
from skillfold.manifold.kernels import tabled
from skillfold.manifold.kernels.scratch import evaluator


@numba.njit
def copied(t):
    surface = tabled.surface_at(t)
    reals = surface.charts.copy(), surface.maps.copy(), surface.points.copy()
    rest = surface.rows.copy(), surface.reaches.copy(), surface.radii.copy()
    whole = surface.neighbours.copy(), surface.parents.copy(), surface.factors.copy(), surface.degrees.copy()
    return reals, rest, whole


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_surface_at(shape):
    model = random_model(3, *shape)
    reals, rest, whole = copied(model.table)
    s = model.surface
    expected = (s.charts, s.maps, s.points), (s.rows, s.reaches, s.radii)
    for found, given in zip((*reals, *rest), (*expected[0], *expected[1]), strict=True):
        np.testing.assert_array_equal(found, given)
    for found, given in zip(whole, (s.neighbours, s.parents, s.factors, s.degrees), strict=True):
        np.testing.assert_array_equal(found, given)


@numba.njit
def field_of(t):
    centres, precision = tabled.matrix(t, tabled.CENTRES).copy(), tabled.vector(t, tabled.PRECISION)[0]
    return tabled.dimension(t), centres, precision, tabled.matrix(t, tabled.WEIGHTS).copy()


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_the_field_is_filled_up(shape):
    """With kernels far away that weigh nothing, to multiples of four."""
    model = random_model(3, *shape)
    field, (dim, centres, precision, weights) = model.field, field_of(model.table)
    d, D, K = field.weights.shape
    assert (dim, precision) == (d, field.precision)
    assert centres.shape[1] % 4 == weights.shape[1] % 4 == 0
    np.testing.assert_array_equal(centres[:, :K], field.centres)
    assert (centres[:, K:] == tabled.NOWHERE).all()
    np.testing.assert_array_equal(weights[:K, : d * D].T.reshape(d, D, K), field.weights)
    assert not weights[K:].any()
    assert not weights[:, d * D :].any()


@numba.njit
def encoded(t, states):
    return tabled.encode(t, states)


def test_encode():
    """Of four coordinates three are modelled."""
    rng = np.random.default_rng(5)
    model = random_model(3, *SHAPES[2])
    kept, centre, states = np.linalg.qr(rng.normal(size=(4, 3)))[0], rng.normal(size=4), rng.normal(size=(6, 4))
    table = tabled.tabled(model.surface, model.field, centre, kept, 2.5, evaluator())
    np.testing.assert_allclose(encoded(table.entries, states), (states - centre) @ kept / 2.5, atol=1e-14)


@numba.njit
def moved(t, states, inner, points):
    return tabled.moved(t, states, inner, points)


def test_moved():
    """What is free stays."""
    rng = np.random.default_rng(6)
    model = random_model(3, *SHAPES[2])
    kept, states = np.linalg.qr(rng.normal(size=(4, 3)))[0], rng.normal(size=(6, 4))
    inner, points = rng.normal(size=(2, 6, 3))
    table = tabled.tabled(model.surface, model.field, rng.normal(size=4), kept, 2.5, evaluator())
    expected = states + 2.5 * (points - inner) @ kept.T
    np.testing.assert_allclose(moved(table.entries, states, inner, points), expected, atol=1e-14)


@numba.njit
def decoded(t, start, goal, inner, path):
    tabled.decode_path(t, start, goal, inner, path)


def test_decode_path():
    """Its inner coordinates are those given, and what is free goes straight."""
    rng = np.random.default_rng(7)
    model = random_model(3, *SHAPES[2])
    kept, centre = np.linalg.qr(rng.normal(size=(4, 3)))[0], rng.normal(size=4)
    (start, goal), inner, path = rng.normal(size=(2, 4)), rng.normal(size=(6, 3)), np.empty((6, 4))
    table = tabled.tabled(model.surface, model.field, centre, kept, 2.5, evaluator())
    decoded(table.entries, start, goal, inner, path)
    np.testing.assert_allclose((path - centre) @ kept / 2.5, inner, atol=1e-14)
    free = np.eye(4) - kept @ kept.T
    np.testing.assert_allclose(path @ free, np.linspace(start, goal, 6) @ free, atol=1e-14)
