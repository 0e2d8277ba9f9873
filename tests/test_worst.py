"""The worst places of a path, against NumPy."""

import numpy as np
import pytest

from skillfold.worst import worst_places


def twin(over, outside, states):
    steps = np.linalg.norm(np.diff(states, axis=0), axis=1)
    places = [int(np.argmax(values)) for values in (over, outside, steps)]
    return *places, steps.max(), steps.sum()


@pytest.mark.parametrize(("n", "D", "between"), [(2, 1, 0), (50, 3, 0), (20, 7, 31)])
def test_worst_places(n, D, between):
    rng = np.random.default_rng(n)
    values, states = rng.normal(size=(2, n + between)), rng.normal(size=(n, D))
    found, expected = worst_places(*values, states), twin(*values, states)
    assert found[:3] == expected[:3]
    np.testing.assert_allclose(found[3:], expected[3:], rtol=1e-14)


@pytest.mark.parametrize("place", [0, 4, 9])
@pytest.mark.parametrize("which", [0, 1])
def test_what_is_no_number_is_the_worst(which, place):
    """Compared with anything it is not larger."""
    values = np.arange(20.0).reshape(2, 10)
    values[which, place] = np.nan
    assert worst_places(*values, np.zeros((10, 2)))[which] == place


def test_a_path_that_stays_where_it_is():
    assert worst_places(np.zeros(5), np.zeros(5), np.ones((5, 2))) == (0, 0, 0, 0.0, 0.0)
