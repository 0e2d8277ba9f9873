"""The printed algorithm against plain twins: one descent, one node, and what it does not keep."""

import numpy as np
import pytest

from keyframes import planner_twins as twins
from keyframes.asked import UNITS, asked
from manifold.kernels import callable_of
from skillfold.keyframes.kernels import descent as _descent
from skillfold.keyframes.kernels import printed as _printed
from skillfold.keyframes.kernels import problem as _problem
from skillfold.keyframes.kernels import rrtstar as kernel

descent, printed, problem = callable_of(_descent), callable_of(_printed), callable_of(_problem)


@pytest.fixture(scope="module")
def world():
    return asked()


def whole_step(axis, y, target):
    """Eq. 4 without its factor: line 5's offset from a place that may lie beyond the axis, line 16's within."""
    way = axis[1] - axis[0]
    beyond = (way * UNITS) @ ((target - axis[0]) * UNITS) / ((way * UNITS) @ (way * UNITS))
    offset = target - (axis[0] + beyond * way)
    centre = axis[0] + twins.along_axis(axis, y) * way
    return (target - y) + (centre + offset - y)


def step_size(world, y, target):
    """Eq. 6, with the child's covariance, and backtracking."""
    metric = world.leg.metric
    step = whole_step(world.leg.axis, y, target)
    goal, line = (np.linalg.norm(metric @ d) for d in (target - y, step - (target - y)))
    size = 1.0 / np.hypot(goal, line)
    for _ in range(_printed.HALVINGS):
        if np.linalg.norm(metric @ (y + size * step - target)) <= goal:
            return size
        size /= 2
    return 0.0


def random_pair(world, seed):
    y, target = world.leg.targets.inside(2, seed)
    return y + np.random.default_rng(seed).normal(size=6) * 0.3, target


def test_whole_step_and_off_by(world):
    out = np.empty(6)
    for seed in range(20):
        y, target = random_pair(world, seed)
        printed.whole_step(world.leg.axis, y, target, out)
        np.testing.assert_allclose(out, whole_step(world.leg.axis, y, target), atol=1e-12)
        assert printed.off_by(y, target) == pytest.approx(np.linalg.norm((y - target) * UNITS))


def test_white_length_and_step_size(world):
    for seed in range(20):
        y, target = random_pair(world, seed)
        wanted = np.linalg.norm(world.leg.metric @ (target - y))
        assert printed.white_length(world.problem, y, target) == pytest.approx(wanted)
        step = whole_step(world.leg.axis, y, target)
        found = printed.step_size(world.problem, y, target, step, np.empty(6))
        assert found == pytest.approx(step_size(world, y, target))


def test_move_by_both(world):
    """q + J⁺(e1 + e2), by NumPy's pseudo-inverse."""
    work, chart, twin = problem.make_work(6), world.leg.chart, twins.Twin(world)
    for seed, q in enumerate(world.states(6)):
        y, onward = world.leg.targets.inside(2, seed)
        descent.face(world.problem, q, work)
        found = q.copy()
        printed.move_by_both(world.problem, found, y, onward, work)
        e1 = twins.twist(chart.to_pose(y), chart.to_pose(onward))
        e2 = twins.twist(world.robot.forward(q), chart.to_pose(onward))
        np.testing.assert_allclose(found, q + np.linalg.pinv(twin.jacobian(q)) @ (e1 + e2), atol=1e-3)


def planted(world, limit=400):
    tree = world.tree(limit)
    kernel.plant(world.table, tree.table.entries, world.start)
    return tree


def test_grow_printed(world):
    """`extend_printed` and `rewire_printed` inside: edges are clear, parents make a tree, costs never too low."""
    tree, rng = planted(world, 3000), np.random.default_rng(0)
    targets, starts = world.leg.targets.inside(30, 1), rng.uniform(0, 2 * np.pi, (30, 6))
    used = _printed.grow_printed(world.table, tree.table.entries, targets, starts)
    n, twin = tree.count, twins.Twin(world)
    assert n > 50 and (used == 30 or tree.goals().tolist() == [n - 1])
    for node in range(1, n):
        parent = tree.nodes.parents[node]
        length = twins.gap(world.question.turning, tree.nodes.q[parent], tree.nodes.q[node])
        assert twin.edge_is_clear(tree.nodes.q[parent], tree.nodes.q[node])
        assert printed.above(tree.nodes, 0, node) and not printed.above(tree.nodes, node, int(parent))
        # A parent rewired later costs less than when this node was hung on it: the sum is never above the cost.
        assert tree.nodes.costs[node] >= tree.nodes.costs[parent] + length - 1e-9


def test_grow_printed_keeps_to_its_room(world):
    tree, rng = planted(world, 12), np.random.default_rng(0)
    targets, starts = world.leg.targets.inside(30, 1), rng.uniform(0, 2 * np.pi, (30, 6))
    assert _printed.grow_printed(world.table, tree.table.entries, targets, starts) < 30
    assert tree.count == 12


def test_extend_printed_steers_from_the_nearest_pose(world):
    """One step of η toward q from the node whose pose is nearest to y, not to q."""
    tree, work, white = planted(world), problem.make_work(6), np.empty(6)
    y = world.leg.chart.to_chart(world.robot.forward(world.start))
    direction = np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
    node = printed.extend_printed(world.problem, tree.nodes, world.start + 2.0 * direction, y, work, white)
    assert node == 1
    np.testing.assert_allclose(tree.nodes.q[1], world.start + 0.3 * direction, atol=1e-12)
    assert tree.nodes.costs[1] == pytest.approx(0.3)
