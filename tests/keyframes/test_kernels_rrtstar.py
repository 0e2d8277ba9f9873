"""The tree of PCTC-RRT* against a plain twin that sums costs anew, and its laws."""

import numpy as np
import pytest

from keyframes import planner_twins as twins
from keyframes.asked import asked
from manifold.kernels import callable_of
from skillfold.keyframes.kernels import nodes as _nodes
from skillfold.keyframes.kernels import rrtstar as kernel
from skillfold.planning.tree import LOST

nodes = callable_of(_nodes)


@pytest.fixture(scope="module", params=[100.0, 60.0])
def world(request):
    return asked(request.param)


def batch(world, count, seed=0):
    return world.leg.targets.draw(np.random.default_rng(seed), count)


def grown(world, count=60, seed=0, first=False, limit=300):
    tree = world.tree(limit)
    kernel.plant(world.table, tree.table.entries, world.start)
    used = kernel.grow(world.table, tree.table.entries, *batch(world, count, seed), first)
    return tree, used


def sums(world, tree):
    """Costs along parents, edge by edge."""
    found = np.zeros(tree.count)
    for node in range(tree.count):
        at = node
        while tree.nodes.parents[at] >= 0:
            above = tree.nodes.parents[at]
            found[node] += twins.gap(world.question.turning, tree.nodes.q[above], tree.nodes.q[at])
            at = above
    return found


def test_plant(world):
    tree = world.tree()
    kernel.plant(world.table, tree.table.entries, world.start)
    assert tree.count == 1
    np.testing.assert_array_equal(tree.nodes.q[0], world.start)
    assert (tree.nodes.parents[0], tree.nodes.costs[0], tree.nodes.goals[0]) == (-1, 0.0, 0)
    white = world.leg.metric @ world.leg.chart.to_chart(world.robot.forward(world.start))
    np.testing.assert_allclose(tree.nodes.z[0], white, atol=1e-9)


@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("kinds", [kernel.FROM_TREE, kernel.FROM_START, kernel.FROM_FAR, kernel.JOIN, kernel.END])
def test_grow(world, kinds, first):
    """`extend`, `get_inside`, `connect`, `try_add`, `add` and all below: the same nodes hang on the same ones."""
    targets, _, froms, starts = batch(world, 25, kinds)
    if kinds >= kernel.JOIN:
        starts = world.states(25, 7, 0.1)
    kinds = np.full(25, kinds)
    tree, twin = world.tree(), twins.Tree(twins.Twin(world), world.start)
    kernel.plant(world.table, tree.table.entries, world.start)
    used = kernel.grow(world.table, tree.table.entries, targets, kinds, froms, starts.copy(), first)
    assert used == twin.grow(targets, kinds, starts, first) and (first or used == 25)
    n = tree.count
    assert n == len(twin.q) > 1
    np.testing.assert_allclose(tree.nodes.q[:n], twin.q, atol=1e-6)
    np.testing.assert_allclose(tree.nodes.z[:n], twin.z, atol=1e-4)
    np.testing.assert_array_equal(tree.nodes.parents[:n], twin.parents)
    np.testing.assert_array_equal(tree.nodes.goals[:n], twin.goals)
    np.testing.assert_allclose(tree.nodes.costs[:n], [twin.cost(i) for i in range(n)], atol=1e-6)
    np.testing.assert_array_equal(tree.nodes.weights[:n], twin.weights)


def test_costs_are_sums_along_parents(world):
    """After many rewirings too: the printed algorithm leaves costs stale."""
    tree, _ = grown(world, 150)
    np.testing.assert_allclose(tree.nodes.costs[: tree.count], sums(world, tree), atol=1e-9)


def test_children_and_parents_agree(world):
    tree, _ = grown(world, 150)
    seen = []
    for node in range(tree.count):
        child = tree.nodes.children[node]
        while child >= 0:
            assert tree.nodes.parents[child] == node
            seen.append(child)
            child = tree.nodes.siblings[child]
    assert sorted(seen) == list(range(1, tree.count))


def test_all_nodes_are_inside_clear_and_within_limits(world):
    tree, _ = grown(world, 100)
    states = tree.nodes.q[: tree.count]
    assert tree.count > 30
    assert world.leg.hold.contains(world.robot.forward(states)).all()
    assert (world.obstacles.clearance(states) > 0.0).all()
    assert world.robot.space.contains(states, 1e-12).all()


def test_goals_are_inside_the_goal(world):
    tree, _ = grown(world, 150)
    inside = world.leg.goal.contains(world.robot.forward(tree.nodes.q[: tree.count]))
    assert inside[tree.goals()].all() and len(tree.goals())


def test_grow_stops_at_the_first_goal_or_when_full(world):
    tree, used = grown(world, 200, first=True)
    assert used < 200 and tree.goals().tolist() == [tree.count - 1]
    tree, used = grown(world, 200, limit=20)
    assert tree.count == 20 and used < 200


def test_same_targets_same_bits(world):
    a, b = grown(world)[0], grown(world)[0]
    np.testing.assert_array_equal(a.nodes.q[: a.count], b.nodes.q[: b.count])
    np.testing.assert_array_equal(a.nodes.costs[: a.count], b.nodes.costs[: b.count])


def test_prove_and_forget(world):
    """Nodes whose way is clear stay; behind a blocked edge all is lost, and later targets never see it again."""
    tree, _ = grown(world, 150)
    twin, n = twins.Twin(world), tree.count
    good = next(i for i in range(n - 1, 0, -1) if tree.nodes.parents[i] >= 0)
    blocked = 3  # moved into the box, where no edge to it is clear
    tree.nodes.q[blocked] = inside_of_the_box(world)
    hanging = below(tree, blocked)
    for node in range(1, n):
        if node in hanging:
            continue
        clear = all(twin.edge_is_clear(tree.nodes.q[a], tree.nodes.q[b]) for a, b in way(tree, node))
        if not clear:
            continue
        assert kernel.prove(world.table, tree.table.entries, node)
        assert all(tree.nodes.proven[b] for _, b in way(tree, node))
        good = node
        break
    assert not kernel.prove(world.table, tree.table.entries, max(hanging))
    lost = np.flatnonzero(tree.nodes.parents[:n] == LOST)
    assert set(lost) == hanging
    assert not tree.nodes.goals[lost].any() and np.isinf(tree.nodes.costs[lost]).all()
    assert tree.nodes.parents[good] >= 0
    kernel.grow(world.table, tree.table.entries, *batch(world, 40, 9), False)
    assert not np.isin(tree.nodes.parents[n : tree.count], lost).any()
    assert np.isfinite(tree.nodes.q[n : tree.count]).all()


def way(tree, node):
    found = []
    while tree.nodes.parents[node] >= 0:
        found.append((int(tree.nodes.parents[node]), node))
        node = int(tree.nodes.parents[node])
    return found


def below(tree, top):
    return {i for i in range(tree.count) if top == i or any(a == top for a, _ in way(tree, i))}


def inside_of_the_box(world):
    states = world.states(400, 11, 0.5)
    return states[world.obstacles.clearance(states).argmin()]


def test_tree_at_and_whitened(world):
    """`put` wrote what Python reads, slot by slot."""
    tree, _ = grown(world, 30)
    assert tree.table.entries[::3].tolist() == [array.ctypes.data for array in tree.nodes]
    out, y = np.empty(6), world.leg.targets.inside(1, 3)[0]
    nodes.whitened(world.problem, y, out)
    np.testing.assert_allclose(out, world.leg.metric @ y, atol=1e-9)


@pytest.mark.parametrize("dof", [1, 6, 30])
def test_near_radius(dof):
    for count in (1, 2, 30, 20_000):
        assert nodes.near_radius(count, dof) == pytest.approx(twins.near_radius(count, dof))


def test_nearest_and_has_room(world):
    tree, _ = grown(world, 60)
    n, rng = tree.count, np.random.default_rng(0)
    for white in tree.nodes.z[:n] + rng.normal(size=(n, 6)):
        square = tree.nodes.weights[:n] * ((tree.nodes.z[:n] - white) ** 2).sum(1)
        assert nodes.nearest(tree.nodes, white) == square.argmin()
    assert nodes.has_room(tree.nodes)
    tree.nodes.size[0] = len(tree.nodes.q)
    assert not nodes.has_room(tree.nodes)
