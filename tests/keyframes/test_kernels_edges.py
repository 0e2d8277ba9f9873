"""Edges against plain twins, on the Jaco; and that what they call inside is so between the poses looked at."""

import numpy as np
import pytest

from keyframes import planner_twins as twins
from keyframes.asked import TURN, asked
from manifold.kernels import callable_of
from skillfold.keyframes.kernels import edges as _edges
from skillfold.keyframes.kernels import problem as _problem

edges, problem = callable_of(_edges), callable_of(_problem)
TURNING = np.array([1, 0, 0, 1])


@pytest.fixture(scope="module", params=[100.0, 60.0])
def world(request):
    return asked(request.param)


@pytest.fixture(scope="module")
def work():
    return problem.make_work(6)


def pairs_of(world, count=80):
    states = world.states(2 * count, 3, 0.09)
    return list(zip(states[:count], states[count:], strict=True))


def test_squared_gap_and_facing():
    rng, out = np.random.default_rng(0), np.empty(4)
    for a, b in rng.uniform(-8, 8, (20, 2, 4)):
        edges.facing(TURNING, a, b, out)
        assert edges.squared_gap(TURNING, a, b) == pytest.approx(((out - a) ** 2).sum())
        np.testing.assert_allclose(out - a, twins.difference(TURNING == 1, a, b), atol=1e-12)
        np.testing.assert_allclose((out - b)[TURNING == 0], 0.0)
        turns = (out - b) / TURN
        np.testing.assert_allclose(turns, np.round(turns), atol=1e-12)


def test_wound():
    rng, out = np.random.default_rng(0), np.empty(4)
    for a, b in rng.uniform(-20, 20, (20, 2, 4)):
        edges.wound(TURNING, a, b, out)
        np.testing.assert_allclose(b - out - a, twins.difference(TURNING == 1, a, b), atol=1e-12)
        np.testing.assert_allclose(out / TURN, np.round(out / TURN), atol=1e-12)
    edges.wound(TURNING, np.zeros(4), np.array([3.1, 9.0, -9.0, -3.1]), out)
    np.testing.assert_array_equal(out, 0.0)


def test_excess_at(world, work):
    twin = twins.Twin(world)
    for a, b in pairs_of(world, 6):
        for share in (0.0, 0.3, 1.0):
            found = edges.excess_at(world.problem, a, b, share, work)
            assert found == pytest.approx(twin.excess(world.robot.forward(a + share * (b - a))), abs=1e-6)


def test_is_clear(world):
    states = world.states(60, 5, 0.6)
    found = [edges.is_clear(world.problem, q) for q in states]
    assert found == (world.obstacles.clearance(states) > world.question.margin).tolist()
    assert set(found) == {False, True}


def test_stays_inside(world, work):
    twin, answers = twins.Twin(world), []
    for a, b in pairs_of(world):
        if twin.is_inside(world.robot.forward(a)):
            answers.append(edges.stays_inside(world.problem, a, b, work))
            assert answers[-1] == twin.stays_inside(a, b)
    assert set(answers) == {False, True}


def test_what_stays_inside_is_inside_everywhere(world, work):
    """Within half a percent of a gate beyond the level, at poses a tenth as far apart."""
    shares = np.linspace(0, 1, 200)[:, None]
    for a, b in pairs_of(world):
        if twins.Twin(world).is_inside(world.robot.forward(a)) and edges.stays_inside(world.problem, a, b, work):
            squares, _ = world.leg.hold.membership(world.robot.forward(a + shares * (b - a)))
            assert np.sqrt(squares.max()) - 1.0 <= world.leg.level + 0.005


def test_seems_to_hold_and_edge_is_clear(world, work):
    twin = twins.Twin(world)
    for a, b in pairs_of(world, 30):
        assert edges.seems_to_hold(world.problem, a, b, work) == twin.seems_to_hold(a, b)
        assert edges.edge_is_clear(world.problem, a, b, work) == twin.edge_is_clear(a, b)
