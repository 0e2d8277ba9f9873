"""A planner's question, small and quick, as compiled loops take it and as plain code does."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.spatial.transform import Rotation

from skillfold import Box, Robot, Scene
from skillfold.keyframes import pairs
from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.compiled import compiled_constraint
from skillfold.keyframes.envelope import SoftEnvelope
from skillfold.keyframes.gaussians import PoseGaussian
from skillfold.keyframes.grown import REACH, Grown, Question
from skillfold.keyframes.kernels.problem import Held, Problem
from skillfold.keyframes.legs import Leg
from skillfold.keyframes.rrtstar import search

UNITS = np.repeat([1.0, LENGTH], 3)
TURN = 2 * np.pi


def gaussian(pose, metres, radians, gate=12.0):
    spread = np.diag(np.square([*np.broadcast_to(metres, 3), *np.broadcast_to(radians, 3)]))
    return PoseGaussian(np.asarray(pose), spread, np.array([gate, gate]), 7)


@lru_cache
def arm():
    return Robot.load("jaco")


@dataclass
class Asked:
    """All that kernels take: of an arm whose tool goes a short way past a box."""

    robot: Robot
    obstacles: object
    envelope: SoftEnvelope
    start: np.ndarray
    alpha: float

    @cached_property
    def narrow(self):
        return self.envelope.reduced(self.alpha)

    @cached_property
    def leg(self) -> Leg:
        asked = pairs.Asked(self.robot, self.obstacles, self.alpha, True, 0.0, search)
        return pairs._crossing(asked, self.envelope, self.narrow, self.start, pairs.GOAL_SLACK)

    @cached_property
    def question(self) -> Question:
        return self.leg.question(self.start)

    @cached_property
    def problem(self) -> Problem:
        """The same as one tuple, which those loops take that others call."""
        hold, goal = compiled_constraint(self.leg.hold), compiled_constraint(self.leg.goal)
        clear = self.obstacles.compiled()
        return Problem(
            self.robot.compiled_tool(),
            Held(hold.excess, hold.project, hold.arguments, self.leg.level),
            Held(goal.excess, goal.project, goal.arguments, self.leg.goal_level),
            clear.clearance,
            clear.edge,
            clear.arguments,
            self.question.margin,
            *self.robot.limits,
            self.question.turning.astype(np.int64),
            self.leg.chart.middle,
            self.leg.axis,
            self.leg.metric,
            REACH,
        )

    @cached_property
    def table(self):
        return self.question.table.entries

    def tree(self, limit=300):
        return Grown(limit, self.robot.dof)

    def states(self, count, seed=0, spread=0.15):
        """Joint positions about the start."""
        rng = np.random.default_rng(seed)
        lower, upper = self.robot.limits
        return np.clip(self.start + spread * rng.normal(size=(count, self.robot.dof)), lower, upper)


@lru_cache
def asked(alpha=100.0):
    """The arm moves its tool 30 cm sideways, past a box on its way."""
    robot = arm()
    start = robot.home
    pose = robot.forward(start)
    turn = Rotation.from_rotvec([0.0, 0.0, 0.4]) * Rotation.from_quat(pose[3:], scalar_first=True)
    there = np.concatenate([pose[:3] + np.array([0.25, 0.05, 0.05]), turn.as_quat(scalar_first=True)])
    envelope = SoftEnvelope.between(
        gaussian(pose, [0.02, 0.03, 0.04], 0.12), gaussian(there, [0.03, 0.02, 0.03], 0.12)
    )
    middle = 0.5 * (pose[:3] + there[:3])
    box = Box(pose=(*(middle - [0.0, 0.0, 0.19]), 1.0, 0.0, 0.0, 0.0), size=(0.04, 0.2, 0.2))
    return Asked(robot, robot.obstacles(Scene([box])), envelope, start, alpha)
