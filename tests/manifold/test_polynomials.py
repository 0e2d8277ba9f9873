import math

import numpy as np
import pytest

from manifold import twins
from skillfold.manifold.polynomials import design, monomials

CASES = [(1, 1), (1, 5), (2, 3), (3, 2), (4, 4), (6, 1)]


@pytest.mark.parametrize(("dim", "degree"), CASES)
def test_there_are_as_many_as_there_must_be(dim, degree):
    table = monomials(dim, degree)
    assert len(table.parents) == len(table.factors) == len(table.degrees) == math.comb(dim + degree, degree)


@pytest.mark.parametrize(("dim", "degree"), CASES)
def test_values_are_products_of_powers(dim, degree):
    u = np.random.default_rng(0).normal(size=(5, 3, dim))
    exponents = twins.powers(dim, degree)
    expected = np.prod(u[..., None, :] ** exponents, axis=-1)
    np.testing.assert_allclose(design(u, monomials(dim, degree)), expected, rtol=1e-12)


@pytest.mark.parametrize(("dim", "degree"), CASES)
def test_the_order_is_by_degree_with_the_variables_first(dim, degree):
    """What reads slopes off a polynomial relies on it: monomials 1 to dim are the variables."""
    table = monomials(dim, degree)
    assert (np.diff(table.degrees) >= 0).all()
    np.testing.assert_array_equal(table.degrees, twins.powers(dim, degree).sum(1))
    u = np.random.default_rng(1).normal(size=(4, dim))
    np.testing.assert_array_equal(design(u, table)[:, 1 : 1 + dim], u)
    assert (table.parents[1:] < np.arange(1, len(table.parents))).all()
