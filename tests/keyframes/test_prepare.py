"""Time limits do not wait for compilers: all that a plan calls is ready before its clock starts."""

import subprocess
import sys

SCRIPT = """
import numpy as np
from numba.core import ccallback, dispatcher
from skillfold import Box, Robot
from skillfold.keyframes import constrained, planning
from skillfold.keyframes.hand_written import AxisUpright, TaskSpaceRegion
from skillfold.keyframes.skill import KeyframeSkill

class Anywhere:
    def distance(self, poses):
        return np.zeros(len(poses))

    def project(self, poses):
        return poses

robot = Robot.load("jaco")
ahead = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
way = np.stack([robot.forward(robot.home), robot.forward(robot.home) + 0.1 * ahead])
skill = KeyframeSkill.fit([way + 0.01 * i * ahead for i in range(4)])
planning.prepare()

def late(*given, **named):
    raise AssertionError("compiled while the clock runs")

dispatcher.Dispatcher.compile = ccallback.CFunc.compile = late
start, boxes = robot.home, [Box([0.4, 0.4, 0.1], [0.1, 0.1, 0.1])]
pose = robot.forward(start)
frame = TaskSpaceRegion(pose, -np.ones(6), np.ones(6))
for constraint in (Anywhere(), AxisUpright(tolerance=3.0), frame):
    for stop in ("first", "time"):
        plan = planning.plan_constrained(robot, constraint, start, pose + 0.02 * ahead, boxes, stop=stop)
        assert plan.success, plan.reason
for alpha in (100, 85):
    plan = skill.plan(robot, start, boxes, alpha=alpha, start_at=0)
    assert plan.success, plan.reason
"""


def test_nothing_is_compiled_while_the_clock_runs():
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", SCRIPT], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
