"""Four numbers side by side, against NumPy."""

import numba
import numpy as np
import pytest

from skillfold.jit import njit
from skillfold.lanes import LANES, larger, load, padded, smaller, spread, store


@njit
def combined(a, b, number, out):
    for start in range(0, a.size, LANES):
        x, y = load(a, start), load(b, start)
        store(x * y + spread(number) - y, out, start)


@pytest.mark.parametrize("shape", [(4,), (3, 8), (2, 3, 4)])
def test_arithmetic(shape):
    """Of arrays of any shape, number after number."""
    rng = np.random.default_rng(0)
    a, b, out = rng.normal(size=(3, *shape))
    combined(a, b, 0.5, out)
    np.testing.assert_allclose(out, a * b + 0.5 - b, atol=1e-15)


@njit
def compared(a, b, out):
    store(smaller(load(a, 0), load(b, 0)), out, 0)
    store(larger(load(a, 0), load(b, 0)), out, 4)


def test_the_smaller_and_the_larger():
    """Of what cannot be compared the first."""
    a, b, out = np.array([1.0, 5.0, np.nan, -np.inf]), np.array([2.0, -3.0, 1.0, 0.0]), np.zeros(8)
    compared(a, b, out)
    np.testing.assert_array_equal(out, [1.0, -3.0, np.nan, -np.inf, 2.0, 5.0, np.nan, 0.0])


@njit
def moved(a, start, out, where):
    store(load(a, start), out, where)


def test_four_numbers_from_anywhere():
    """Rows need not begin where a register would have it."""
    a, out = np.arange(20.0), np.zeros(20)
    moved(a, 3, out, 9)
    np.testing.assert_array_equal(out, [0.0] * 9 + [3.0, 4.0, 5.0, 6.0] + [0.0] * 7)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_stays_so(value):
    a, out = np.array([1.0, value, 2.0, value]), np.zeros(4)
    combined(a, np.ones(4), 1.0, out)
    np.testing.assert_array_equal(out, a)


def test_a_scalar_is_spread_by_hand():
    """So that nobody wonders what a number and four of them make."""

    @numba.njit
    def mixed(a):
        store(load(a, 0) * 2.0, a, 0)

    with pytest.raises(numba.TypingError):
        mixed(np.ones(4))


def test_padded():
    assert [padded(n) for n in (0, 1, 4, 5, 12)] == [0, 4, 4, 8, 12]
