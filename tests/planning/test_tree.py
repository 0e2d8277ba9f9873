"""Trees in arrays."""

import numpy as np
import pytest

from manifold.kernels import callable_of
from skillfold.planning import tree as _tree

tree = callable_of(_tree)


@pytest.mark.parametrize("D", [1, 3, 8])
def test_nearest_node(D):
    rng = np.random.default_rng(D)
    states = rng.normal(size=(40, D))
    for count in (1, 2, 17, 40):
        for target in rng.normal(size=(10, D)):
            wanted = np.linalg.norm(states[:count] - target, axis=1).argmin()
            assert tree.nearest_node(states, count, target) == wanted


def test_nearest_node_takes_the_first_of_those_as_near_and_none_beyond_the_count():
    states = np.array([[1.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [0.0, 0.0]])
    assert tree.nearest_node(states, 3, np.zeros(2)) == 0
    assert tree.nearest_node(states, 4, np.zeros(2)) == 3


def test_branch():
    """Up to the root along parents drawn at random, each an earlier node."""
    rng = np.random.default_rng(0)
    parents = np.array([-1, *(rng.integers(0, i) for i in range(1, 60))])
    out = np.empty(60, np.int64)
    for node in range(60):
        count = tree.branch(parents, node, out)
        way = out[:count]
        assert (way[0], way[-1]) == (node, 0)
        np.testing.assert_array_equal(parents[way[:-1]], way[1:])
