"""OMPL's constrained planners on a learnt manifold: what `skill.plan(..., obstacles=...)` is compared with.

OMPL samples its own way, by projection (`projected`) or over charts of the manifold (`atlas`), with RRT-Connect and
then its own simplification. It is given the learnt function with its analytic Jacobian and the same clearance, all
compiled; a state is valid if it is clear and as near to the demonstrations as a plan of ours must be. Needs the extra
`peers`.
"""

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.errors import InputError, MissingExtraError
from skillfold.experiments.learnt_constraint import LearntConstraint
from skillfold.motion import Array

SPACES = ("projected", "atlas")
TOLERANCE = 1e-4  # of the constraint, in state units
DELTA = 0.05  # of OMPL's steps along the manifold, in state units: valid states lie no farther apart
ROOM = 1e-6  # beyond joint limits, for states that lie on them


@dataclass(frozen=True)
class PeerPlan:
    """What OMPL found.

    Attributes:
        space: "projected" or "atlas".
        solved: whether it reached the goal in time.
        first_seconds: until its first valid path.
        seconds: until that was simplified.
        states: (n, D) of the simplified path, on the manifold at every step; empty where there is none.
    """

    space: str
    solved: bool
    first_seconds: float
    seconds: float
    states: Array

    @property
    def length(self) -> float:
        """Of the path; infinite where there is none."""
        if not self.solved:
            return float("inf")
        return float(np.linalg.norm(np.diff(self.states, axis=0), axis=1).sum())


class OmplPeer:
    """A skill's manifold in OMPL; for one thread.

    Args:
        skill: a fitted `SkillManifold`.
        obstacles: what `plan(obstacles=...)` takes, or None.
        space: "projected" or "atlas".
        tolerance, delta: of OMPL's constraint and of its steps, in state units.

    Raises:
        MissingExtraError: OMPL is not installed.
        InputError: an unknown space.
    """

    def __init__(
        self, skill: Any, obstacles: Any, space: str, tolerance: float = TOLERANCE, delta: float = DELTA
    ) -> None:
        if space not in SPACES:
            raise InputError(f"OMPL: space {space!r}; possible: {', '.join(SPACES)}.")
        self._base, self._geometric, self._util = _ompl()
        self.space, self.learnt, self._skill = space, LearntConstraint(skill), skill
        self._constraint = _constraint(self._base, self.learnt, tolerance)
        self._bounds = _box(skill, obstacles)
        self._compiled = None if obstacles is None else obstacles.compiled()
        self._delta = delta
        self._no_gradient = np.empty(0)

    def plan(self, start: Array, goal: Array, seed: int = 1, time_limit: float = 5.0) -> PeerPlan:
        """A path between two states, projected first; the time to set OMPL up for a query counts.

        OMPL has one seed for all of its planners in a process.
        """
        self._util.RNG.setSeed(seed)
        self._util.setLogLevel(self._util.LogLevel.LOG_NONE)
        began = perf_counter()
        setup = self._setup(self._skill.project(np.stack([start, goal])))
        status = setup.solve(time_limit)
        first = perf_counter() - began
        if not (status and setup.haveExactSolutionPath()):
            return PeerPlan(self.space, False, first, first, np.empty((0, len(start))))
        setup.simplifySolution()
        whole = perf_counter() - began
        path = setup.getSolutionPath()
        path.interpolate()
        states = np.array([self._read(state) for state in path.getStates()])
        return PeerPlan(self.space, True, first, whole, states)

    def valid(self, state: Any) -> bool:
        """Whether a state is clear, and near enough to the demonstrations."""
        x = self._read(state)
        compiled = self._compiled
        clear = compiled is None or compiled.clearance(x, self._no_gradient, compiled.arguments) > 0.0
        return clear and self.learnt.supported(x)

    def _setup(self, ends: Array) -> Any:
        base = self._base
        ambient = base.RealVectorStateSpace(ends.shape[1])
        ambient.setBounds(self._real_bounds())
        kind = {"projected": base.ProjectedStateSpace, "atlas": base.AtlasStateSpace}[self.space]
        space = kind(ambient, self._constraint)
        information = base.ConstrainedSpaceInformation(space)
        space.setDelta(self._delta)
        setup = self._geometric.SimpleSetup(information)
        setup.setStateValidityChecker(self.valid)
        setup.setPlanner(self._geometric.RRTConnect(information))
        states = [space.allocState() for _ in ends]
        for state, values in zip(states, ends, strict=True):
            state.copy(values.tolist())
            if self.space == "atlas":
                space.anchorChart(state)
        setup.setStartAndGoalStates(*states)
        return setup

    def _real_bounds(self) -> Any:
        lower, upper = self._bounds
        bounds = self._base.RealVectorBounds(len(lower))
        for i in range(len(lower)):
            bounds.setLow(i, float(lower[i]))
            bounds.setHigh(i, float(upper[i]))
        return bounds

    def _read(self, state: Any) -> Array:
        return np.array([state[i] for i in range(self.learnt.n_dims)])


def _box(skill: Any, obstacles: Any) -> tuple[Array, Array]:
    """Limits; where there are none, twice the box of what was demonstrated."""
    anchors = skill.model.moved(np.tile(skill.model.centre, (len(skill.model.anchors), 1)), skill.model.anchors)
    low, high = anchors.min(axis=0), anchors.max(axis=0)
    room = 0.5 * (high - low) + skill.model.scale
    lower, upper = (low - room, high + room) if obstacles is None else obstacles.bounds
    return np.maximum(lower, low - room) - ROOM, np.minimum(upper, high + room) + ROOM


def _constraint(base: Any, learnt: LearntConstraint, tolerance: float) -> Any:
    """OMPL's own kind of constraint."""

    class Constraint(base.Constraint):
        def function(self, x: Array, out: Array) -> None:
            out[:] = learnt.value(x)

        def jacobian(self, x: Array, out: Array) -> None:
            out[:] = learnt.jacobian(x)

    return Constraint(learnt.n_dims, learnt.codim, tolerance)


def _ompl() -> tuple[Any, Any, Any]:
    try:
        from ompl import base, geometric, util  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise MissingExtraError("OMPL is not installed: pip install 'skillfold[peers]'.") from error
    return base, geometric, util
