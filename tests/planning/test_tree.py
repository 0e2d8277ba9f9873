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


def random_tree(count, seed):
    """Parents, children and siblings of nodes hung at random, and costs whose steps are known."""
    rng = np.random.default_rng(seed)
    parents, children, siblings = np.full((3, count), -1)
    steps, costs = rng.random(count), np.zeros(count)
    for node in range(1, count):
        tree.hang(parents, children, siblings, node, int(rng.integers(node)))
        costs[node] = costs[parents[node]] + steps[node]
    return parents, children, siblings, costs, rng


def children_of(children, siblings, node):
    found, at = [], children[node]
    while at >= 0:
        found.append(int(at))
        at = siblings[at]
    return found


def below(parents, top):
    """By walking up from every node."""
    found = set()
    for node in range(len(parents)):
        at = node
        while at >= 0 and at != top:
            at = parents[at]
        if at == top:
            found.add(node)
    return found


@pytest.mark.parametrize("seed", range(4))
def test_hang_and_unhang(seed):
    parents, children, siblings, _, rng = random_tree(40, seed)
    for node in rng.permutation(np.arange(1, 40)):
        tree.unhang(parents, children, siblings, int(node))
        assert node not in children_of(children, siblings, parents[node])
        # Anywhere but below itself.
        new = rng.choice(sorted(set(range(40)) - below(parents, node)))
        tree.hang(parents, children, siblings, int(node), int(new))
        for other in range(40):
            assert sorted(children_of(children, siblings, other)) == np.flatnonzero(parents == other).tolist()


@pytest.mark.parametrize("seed", range(4))
def test_lower_costs(seed):
    """Of all that hangs on a node, and of nothing else."""
    parents, children, siblings, costs, rng = random_tree(50, seed)
    for top in rng.integers(0, 50, 12):
        before, lower = costs.copy(), sorted(below(parents, top))
        tree.lower_costs(parents, children, siblings, costs, int(top), 0.125)
        before[lower] -= 0.125
        np.testing.assert_array_equal(costs, before)


@pytest.mark.parametrize("seed", range(4))
def test_cut(seed):
    parents, children, siblings, costs, rng = random_tree(50, seed)
    for top in rng.permutation(np.arange(1, 50))[:10]:
        if parents[top] < 0:
            continue  # lost already
        before, lost = parents.copy(), below(parents, top)
        tree.cut(parents, children, siblings, costs, int(top))
        assert (parents[sorted(lost)] == tree.LOST).all() and np.isinf(costs[sorted(lost)]).all()
        kept = sorted(set(range(50)) - lost)
        np.testing.assert_array_equal(parents[kept], before[kept])
        for node in kept:
            if parents[node] != tree.LOST:
                assert sorted(children_of(children, siblings, node)) == np.flatnonzero(parents == node).tolist()
