"""OMPL on a Soft-Envelope: what PCTC-RRT* is compared with. Needs the extra `peers`.

RRT-Connect from the same start; goals (joint positions in the child's gate, clear) are found for it by inverse
kinematics before its clock starts. Poses outside are either rejected, in plain joint space (`rejection`),
or states are projected onto the constraint "distance from the envelope = 0" in OMPL's projected space (`projected`).
Its checker and its constraint are the same compiled functions that our planner calls; it looks at edges at steps.
"""

from dataclasses import dataclass
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from skillfold.errors import InputError, MissingExtraError
from skillfold.jit import njit
from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.kernels.descent import tool_pose, twist
from skillfold.motion import Array
from skillfold.robots.kinematics import Tool, frame_jacobian
from skillfold.tables import Indices

SPACES = ("rejection", "projected")
TOLERANCE = 1e-4  # metres of OMPL's constraint
DELTA = 0.02  # rad between the states of an edge that OMPL looks at
AROUND = np.pi  # to each side of the start that a continuous joint is sampled


class Held(NamedTuple):
    """The envelope's compiled functions."""

    excess: Any
    project: Any
    arguments: Indices


class Clear(NamedTuple):
    """The obstacles' compiled function."""

    clearance: Any
    arguments: Indices


class Peer(NamedTuple):
    """What OMPL's callbacks look at, and scratch: poses, a difference of poses, a Jacobian, nothing."""

    tool: Tool
    hold: Held
    clear: Clear
    pose: Array
    inside: Array
    way: Array
    jacobian: Array
    none: Array


@njit
def is_valid(q: Array, problem: Peer) -> bool:
    """Whether joint positions (D,) are clear and their pose is inside."""
    hold, clear = problem.hold, problem.clear
    tool_pose(problem.tool, q, problem.pose)
    return (
        hold.excess(problem.pose, hold.arguments) <= 0.0 and clear.clearance(q, problem.none, clear.arguments) > 0.0
    )


@njit
def slope(q: Array, problem: Peer, out: Array) -> float:
    """Distance [m] of a pose from the envelope, 0 inside, and its gradient (D,) by joint positions q."""
    tool, hold, way, jacobian = problem.tool, problem.hold, problem.way, problem.jacobian
    tool_pose(tool, q, problem.pose)
    out[:] = 0.0
    if hold.project(problem.pose, problem.inside, hold.arguments) <= 0.0:
        return 0.0
    twist(problem.pose, problem.inside, way)
    distance = np.sqrt(np.sum(way**2))
    jacobian[:] = 0.0
    frame_jacobian(tool.machine, tool.body, problem.pose[:3], jacobian)
    for k in range(q.size):
        for c in range(6):
            out[k] -= way[c] * jacobian[c, k] * (1.0 if c < 3 else LENGTH) / max(distance, 1e-12)
    return distance


@dataclass(frozen=True)
class PeerPath:
    """What OMPL found: whether, until when [s], and the states (n, D)."""

    solved: bool
    seconds: float
    states: Array


class EnvelopePeer:
    """A robot's joint space with an envelope and obstacles in OMPL; for one thread.

    Args:
        robot: whose tool is held inside.
        obstacles: of that robot.
        envelope: a `SoftEnvelope`.
        start: joint positions (D,).
        goals: (n, D) joint positions.
        space: "rejection" or "projected".

    Raises:
        MissingExtraError: OMPL is not installed.
        InputError: an unknown space.
    """

    def __init__(self, robot: Any, obstacles: Any, envelope: Any, start: Array, goals: Array, space: str) -> None:
        if space not in SPACES:
            raise InputError(f"OMPL: space {space!r}; possible: {', '.join(SPACES)}.")
        self._base, self._geometric, self._util = _ompl()
        self.space, self.start = space, start
        hold, clear = envelope.compiled(), obstacles.compiled()
        self._owners = robot, hold, clear
        self._problem = Peer(
            robot.compiled_tool(),
            Held(hold.excess, hold.project, hold.arguments),
            Clear(clear.clearance, clear.arguments),
            *(np.empty(size) for size in (7, 7, 6, (6, robot.dof), 0)),
        )
        self._bounds = _around(robot, start)
        turned = np.where(np.isfinite(robot.limits.lower), 0.0, 2 * np.pi)
        self.goals = goals - turned * np.round((goals - start) / (2 * np.pi))

    def plan(self, seed: int = 1, time_limit: float = 5.0) -> PeerPath:
        """The first path; the time to set OMPL up for a query counts. OMPL has one seed for a whole process."""
        self._util.RNG.setSeed(seed)
        self._util.setLogLevel(self._util.LogLevel.LOG_NONE)
        began = perf_counter()
        setup = self._setup()
        status = setup.solve(time_limit)
        seconds = perf_counter() - began
        if not (status and setup.haveExactSolutionPath()):
            return PeerPath(False, seconds, np.empty((0, len(self.start))))
        path = setup.getSolutionPath()
        path.interpolate()
        return PeerPath(True, seconds, np.array([self._read(state) for state in path.getStates()]))

    def valid(self, state: Any) -> bool:
        """Whether a state is clear and its pose inside; in the projected space the constraint sees to the latter."""
        return bool(is_valid(self._read(state), self._problem))

    def distance(self, q: Array) -> tuple[float, Array]:
        """Distance of the pose from the envelope [m], and its gradient (D,)."""
        gradient = np.empty(len(self.start))
        return slope(np.ascontiguousarray(q, np.float64), self._problem, gradient), gradient

    def _setup(self) -> Any:
        base, dof = self._base, len(self.start)
        ambient = base.RealVectorStateSpace(dof)
        ambient.setBounds(self._real_bounds())
        if self.space == "projected":
            self._constraint = _constraint(base, self, dof)
            space = base.ProjectedStateSpace(ambient, self._constraint)
            information = base.ConstrainedSpaceInformation(space)
            space.setDelta(DELTA)
        else:
            space = ambient
            information = base.SpaceInformation(space)
            information.setStateValidityCheckingResolution(DELTA / space.getMaximumExtent())
        setup = self._geometric.SimpleSetup(information)
        setup.setStateValidityChecker(self.valid)
        setup.setPlanner(self._geometric.RRTConnect(information))
        goal = base.GoalStates(information)
        for values in self.goals:
            goal.addState(self._state(space, values))
        setup.setStartState(self._state(space, self.start))
        setup.setGoal(goal)
        return setup

    def _state(self, space: Any, values: Array) -> Any:
        state = space.allocState()
        if self.space == "projected":
            state.copy(values.tolist())
        else:
            for i, value in enumerate(values.tolist()):
                state[i] = value
        return state

    def _real_bounds(self) -> Any:
        bounds = self._base.RealVectorBounds(len(self.start))
        for i, (low, high) in enumerate(zip(*self._bounds, strict=True)):
            bounds.setLow(i, float(low))
            bounds.setHigh(i, float(high))
        return bounds

    def _read(self, state: Any) -> Array:
        return np.array([state[i] for i in range(len(self.start))])


def _around(robot: Any, start: Array) -> tuple[Array, Array]:
    lower, upper = robot.limits
    around = AROUND + 1e-6
    return np.where(np.isfinite(lower), lower, start - around), np.where(np.isfinite(upper), upper, start + around)


def _constraint(base: Any, peer: EnvelopePeer, dof: int) -> Any:
    """OMPL's own kind of constraint: the distance from the envelope is zero."""

    class Constraint(base.Constraint):
        def function(self, x: Array, out: Array) -> None:
            out[:] = peer.distance(x)[0]

        def jacobian(self, x: Array, out: Array) -> None:
            out[:] = peer.distance(x)[1]

    return Constraint(dof, 1, TOLERANCE)


def _ompl() -> tuple[Any, Any, Any]:
    try:
        from ompl import base, geometric, util  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise MissingExtraError("OMPL is not installed: pip install 'skillfold[peers]'.") from error
    return base, geometric, util
