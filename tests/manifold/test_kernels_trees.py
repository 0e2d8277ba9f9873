"""Trees on the surface and shortcuts against their twins, on random surfaces among random balls."""

import numpy as np
import pytest

from manifold import twins_around as twins
from manifold.kernels import trees
from manifold.random_terrains import TERRAINS, random_terrain

STEP, ROOM = 0.12, 300


@pytest.fixture(params=TERRAINS[:3], ids=str)
def terrain(request):
    return random_terrain(41, *request.param)


@pytest.fixture
def queries(terrain):
    """Ends on the surface, targets about it."""
    return [(terrain.on_surface(2), terrain.states(80, 0.1)) for _ in range(3)]


def margin(terrain):
    return 0.3 * terrain.margin


def compare(terrain, found, count, wanted):
    assert count == len(wanted)
    np.testing.assert_allclose(found[:count], wanted, atol=1e-8)
    if count:
        assert twins.first_blocked(terrain.land, found[:count], 0.99 * margin(terrain)) == -1
        assert np.linalg.norm(np.diff(found[:count], axis=0), axis=1).max() < 1.5 * STEP


@pytest.mark.parametrize("room", [ROOM, 12])
def test_connect(terrain, queries, room):
    """With room for all nodes, and with little."""
    met = []
    for ends, targets in queries:
        path = np.empty((2 * room, terrain.width))
        count, used = trees.connect(*terrain.arguments, ends, targets, STEP, margin(terrain), path)
        wanted, turns = twins.connect(terrain.land, ends, targets, STEP, margin(terrain), room)
        assert used == turns
        compare(terrain, path, count, wanted)
        if count:
            np.testing.assert_array_equal(path[[0, count - 1]], ends)
        met.append(count > 0)
    assert any(met) or room < ROOM


def test_connect_without_targets_finds_nothing(terrain, queries):
    path = np.empty((20, terrain.width))
    none = np.empty((0, terrain.width))
    assert trees.connect(*terrain.arguments, queries[0][0], none, STEP, margin(terrain), path) == (0, 0)


def test_extend(terrain, queries):
    for ends, targets in queries:
        tree = twins.Tree(ends[0], 40)
        states, parents = np.empty((2, 40, terrain.width)), np.full((2, 40), -1)
        states[1, 0] = ends[0]
        counts = np.ones(2, np.int64)
        for target in targets[:10]:
            newest = trees.extend(*terrain.arguments, states, parents, counts, 1, target, STEP, margin(terrain))
            wanted = tree.extend(terrain.land, target, STEP, margin(terrain))
            assert newest == (-1 if wanted is None else wanted)
            assert counts.tolist() == [1, len(tree.states)]
            np.testing.assert_array_equal(parents[1, : counts[1]], tree.parents)
            np.testing.assert_allclose(states[1, : counts[1]], tree.states, atol=1e-8)


def test_look_aside(terrain):
    node, one, other = terrain.states(3)
    out = np.empty(terrain.width)
    trees.look_aside(node, one, other, 0.3, out)
    np.testing.assert_allclose(out, twins.look_aside(node, one, other, 0.3), atol=1e-14)
    trees.look_aside(node, one, one, 0.3, out)
    np.testing.assert_array_equal(out, node)  # of two targets alike, no direction


def test_joined():
    """From the first root over both given nodes to the second root."""
    rng = np.random.default_rng(0)
    parents = np.array([[-1, 0, 0, 2, 3, 1], [-1, 0, 1, 1, 2, 0]])
    states = rng.normal(size=(2, 6, 4))
    path = np.empty((12, 4))
    count = trees.joined(states, parents, 4, 3, path)
    np.testing.assert_array_equal(path[:count], [*states[0, [0, 2, 3, 4]], *states[1, [3, 1, 0]]])
    assert trees.joined(states, parents, 0, 0, path) == 2
    np.testing.assert_array_equal(path[:2], states[:, 0])


def test_way():
    rng = np.random.default_rng(0)
    between, start, end = rng.normal(size=(5, 3)), rng.normal(size=3), rng.normal(size=3)
    assert trees.way(between, start, end) == pytest.approx(twins.way([start, *between, end]))
    assert trees.way(between[:0], start, end) == pytest.approx(np.linalg.norm(end - start))


def crooked(terrain, ends):
    """A clear path with detours: over a third state on the surface."""
    middle, targets = terrain.on_surface(1)[0], terrain.states(80, 0.1)
    legs = [
        twins.connect(terrain.land, np.stack(pair), targets, STEP, margin(terrain), ROOM)[0]
        for pair in ((ends[0], middle), (middle, ends[1]))
    ]
    return np.vstack([legs[0], legs[1][1:]]) if all(map(len, legs)) else None


def test_shorten(terrain, queries):
    shorter = 0
    for ends, _ in queries:
        first = crooked(terrain, ends)
        if first is None:
            continue
        picks = terrain.model.rng.random((25, 2))
        path = first.copy()
        count = trees.shorten(*terrain.arguments, path, len(path), picks, STEP, margin(terrain))
        compare(terrain, path, count, twins.shorten(terrain.land, first, picks, STEP, margin(terrain)))
        np.testing.assert_array_equal(path[[0, count - 1]], ends)
        assert twins.way(path[:count]) <= twins.way(first) * (1 + 1e-9)
        shorter += count < len(first)
    assert shorter


def test_search_connects_then_shortens(terrain, queries):
    """Or shortens alone, where a path is given."""
    for ends, targets in queries:
        picks, path = terrain.model.rng.random((15, 2)), np.empty((2 * ROOM, terrain.width))
        count, used = trees.search(*terrain.arguments, ends, targets, picks, STEP, margin(terrain), path, 0)
        first, turns = twins.connect(terrain.land, ends, targets, STEP, margin(terrain), ROOM)
        wanted = twins.shorten(terrain.land, first, picks, STEP, margin(terrain)) if len(first) else first
        assert used == turns
        compare(terrain, path, count, wanted)
        if len(first):
            again = first.copy()
            count, used = trees.search(
                *terrain.arguments, ends, targets, picks, STEP, margin(terrain), again, len(first)
            )
            assert used == 0
            compare(terrain, again, count, wanted)


def test_cut_blocked(terrain):
    """A chain with a ball astride its third edge, and branches before and after it."""
    balls = terrain.ball_centres()
    aside = np.zeros(terrain.width)
    aside[0] = 1.0
    chain = [balls[0] + offset * aside for offset in (30.0, 20.0, 10.0, -10.0, -20.0)]
    branches = [chain[1] + 1.0, chain[4] - 1.0]  # of a node before the ball, and of the last
    before = np.array([*chain, *branches])
    states, parents = before.copy(), np.array([-1, 0, 1, 2, 3, 1, 4])
    chart = terrain.land.chart
    chart = chart._replace(lower=np.full(terrain.width, -np.inf), upper=np.full(terrain.width, np.inf))
    work = np.empty((2, terrain.width))
    arguments = (chart, terrain.barrier, states, parents, len(states))
    assert trees.cut_blocked(*arguments, 2, 0.0, work)
    np.testing.assert_array_equal(states, before)
    assert not trees.cut_blocked(*arguments, 4, 0.0, work)
    lost = np.array([3, 4, 6])
    assert (parents[lost] == -2).all() and np.isinf(states[lost]).all()
    kept = np.array([0, 1, 2, 5])
    np.testing.assert_array_equal(states[kept], before[kept])
    assert parents[kept].tolist() == [-1, 0, 1, 1]
