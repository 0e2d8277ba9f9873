"""Choose-parent and rewiring alone, against a graph that is searched whole.

`tree_at`, `whitened`, `put`, `near_radius`, `has_room`, `nearest` and `forget` are tested with the tree that grows.
"""

from keyframes import planner_twins as twins
from keyframes.asked import asked
from manifold.kernels import callable_of
from skillfold.keyframes.kernels import nodes as _nodes
from skillfold.keyframes.kernels import problem as _problem
from skillfold.keyframes.kernels import rrtstar as kernel

nodes, problem = callable_of(_nodes), callable_of(_problem)


def test_add_chooses_the_best_parent_and_rewires():
    """`settle`, `choose_parent` and `rewire`: what is near hangs nowhere better, by edges that seem to hold."""
    world = asked()
    tree, twin, work = world.tree(), twins.Twin(world), problem.make_work(6)
    kernel.plant(world.table, tree.table.entries, world.start)
    states = [q for q in world.states(60, 2, 0.05) if twin.is_inside(world.robot.forward(q)) and twin.is_clear(q)]
    for q in states:
        if twin.seems_to_hold(world.start, q):
            work.pose[:] = world.robot.forward(q)
            before = tree.nodes.costs[: tree.count].copy()
            node = nodes.add(world.problem, tree.nodes, 0, q, work)
            nodes.settle(world.problem, tree.nodes, node, work)
            after = tree.nodes.costs
            # All are so near that every edge is tried: none to or from the new node would lower a cost.
            for other in range(node):
                length = twins.gap(world.question.turning, tree.nodes.q[other], q)
                assert after[other] <= before[other] + 1e-12
                assert after[other] <= after[node] + length + 1e-8 or not twin.seems_to_hold(q, tree.nodes.q[other])
                assert after[node] <= before[other] + length + 1e-8
    assert tree.count > 10
