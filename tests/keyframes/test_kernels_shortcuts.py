"""Shortcuts: plain twins of their parts, and the laws of the whole."""

import numpy as np
import pytest

from keyframes import planner_twins as twins
from keyframes.asked import TURN, asked
from manifold.kernels import callable_of
from skillfold.keyframes.grown import dense, length_of
from skillfold.keyframes.kernels import shortcuts as _shortcuts
from skillfold.keyframes.kernels.shortcuts import shorten

shortcuts = callable_of(_shortcuts)


def lengths(path):
    return np.linalg.norm(np.diff(path, axis=0), axis=1)


@pytest.mark.parametrize("D", [1, 3, 6])
def test_step_length_and_point_at(D):
    rng, out = np.random.default_rng(D), np.empty(D)
    path = rng.normal(size=(9, D))
    count = 7
    places = np.concatenate([[0.0], np.cumsum(lengths(path[:count]))])
    for i in range(count - 1):
        assert shortcuts.step_length(path, i) == pytest.approx(lengths(path)[i])
    for way in rng.uniform(0, places[-1], 20):
        i = shortcuts.point_at(path, count, way, out)
        assert places[i] <= way <= places[i + 1]
        wanted = [np.interp(way, places, path[:count, k]) for k in range(D)]
        np.testing.assert_allclose(out, wanted, atol=1e-9)
    assert shortcuts.point_at(path, count, 2 * places[-1], out) == count - 2
    np.testing.assert_allclose(out, path[count - 1])


def test_splice():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 3))
    for count, i, j in ((8, 0, 6), (8, 2, 3), (5, 1, 2), (3, 0, 1), (8, 3, 6)):
        path = rng.normal(size=(12, 3))
        wanted = np.vstack([path[: i + 1], a, b, path[j + 1 : count]])
        more = shortcuts.splice(path, count, i, j, a, b)
        np.testing.assert_array_equal(path[:more], wanted)


def zigzag(world, seed):
    """A way that holds, with many bends."""
    twin, path = twins.Twin(world), [world.start]
    for q in world.states(80, seed, 0.05):
        if twin.seems_to_hold(path[-1], q) and twin.edge_is_clear(path[-1], q) and twin.is_clear(q):
            path.append(q)
        if len(path) == 9:
            break
    return np.array(path)


@pytest.mark.parametrize("seed", range(3))
def test_shorten(seed):
    """Never longer, the same ends, still inside and clear; rows behind the last are never touched."""
    world = asked()
    path = zigzag(world, seed)
    assert len(path) == 9
    room = np.full((60, 6), np.nan)
    room[:9] = path
    count = shorten(world.table, room, 9, np.random.default_rng(seed).random((25, 2)))
    short = room[:count]
    assert length_of(short) < 0.9 * length_of(path)
    np.testing.assert_array_equal(short[[0, -1]], path[[0, -1]])
    states = dense(short, 0.005)
    assert world.leg.hold.contains(world.robot.forward(states)).all()
    assert (world.obstacles.clearance(states) > 0.0).all()


def test_shorten_keeps_to_its_room():
    world = asked()
    path = zigzag(world, 0)
    room = path.copy()
    count = shorten(world.table, room, 9, np.random.default_rng(0).random((40, 2)))
    assert count <= 9 and length_of(room[:count]) <= length_of(path)
    assert shorten(world.table, room, count, np.empty((0, 2))) == count


@pytest.mark.parametrize("turns", [1, -2])
def test_shortcuts_of_a_way_that_winds_round_a_joint_are_the_ones_that_were_looked_at(turns):
    world = asked()
    way = np.array([0.0, 0.0, 0.0, 0.0, 0.0, TURN * turns])
    path = world.start + np.linspace(0.0, 1.0, 5 * abs(turns))[:, None] * way
    path = np.vstack([path, path[-1] + 0.01])
    room = np.vstack([path, np.empty((4, 6))])
    short = room[: shorten(world.table, room, len(path), np.array([[0.0, 1.0 - 1e-9]]))]
    np.testing.assert_allclose(short[-1], path[-1] - way, atol=1e-12)
    assert length_of(short) == pytest.approx(0.01 * np.sqrt(6), rel=1e-6)
    assert world.leg.hold.contains(world.robot.forward(dense(short, 0.005))).all()
