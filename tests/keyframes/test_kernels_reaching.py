"""Descents to the goal against the plain twin."""

import numpy as np

from keyframes import planner_twins as twins
from keyframes.asked import asked
from skillfold.keyframes.kernels import reaching


def test_reach():
    world = asked()
    twin, goals = twins.Twin(world), world.leg.targets.goal(6, 1)
    starts = np.vstack([np.tile(world.start, (2, 1)), world.robot.sample(4, 3)])
    found, used = starts.copy(), 0
    while used < 6:
        at = reaching.reach(world.table, found[used:], goals[used:])
        for i in range(used, 6 if at < 0 else used + at + 1):
            state, reached = plainly(world, twin, starts[i], goals[i])
            assert reached == (at >= 0 and i == used + at)
            np.testing.assert_allclose(found[i], state, atol=1e-6)
        used = 6 if at < 0 else used + at + 1


def plainly(world, twin, q, target):
    before = np.inf
    for _ in range(reaching.STEPS):
        q, left = twin.descend(q, target, False)
        pose = world.robot.forward(q)
        if twin.is_goal(pose) and twin.is_inside(pose):
            return q, True
        if left > reaching.PROGRESS * before:
            break
        before = left
    return q, False
