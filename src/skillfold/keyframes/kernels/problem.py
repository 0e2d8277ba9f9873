"""What planners ask, for compiled loops: the problem, how it reaches them, and their scratch memory."""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import function_at, inner
from skillfold.robots.kinematics import Tool
from skillfold.tables import indices, matrix, scalar, vector

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

# Slots of a problem's table.
MACHINE, FRAME, PLACE = 0, 1, 2  # of the robot; body; (7,) offset and turn in it
FUNCTIONS = 3  # (5,) addresses: excess and projection of what is held, excess of the goal, clearance, edge
HOLD, GOAL, OBSTACLES = 4, 5, 6  # their arguments
NUMBERS = 7  # (4,) levels of what is held and of the goal, margin, reach
LIMITS, TURNING = 8, 9  # (2, D), (D,)
MIDDLE, AXIS, METRIC = 10, 11, 12
SLOTS = 13

FULL = 2.0 * math.pi


class Held(NamedTuple):
    """A constraint for compiled loops (see `skillfold.keyframes.constraint.CompiledConstraint`).

    Attributes:
        excess, project, arguments: of the constraint.
        level: the excess up to which poses count as inside.
    """

    excess: Any
    project: Any
    arguments: Indices
    level: float


class Problem(NamedTuple):
    """What a planner asks.

    Attributes:
        tool: whose pose is constrained.
        hold: what every pose holds.
        goal: where a path ends.
        clearance, edge, arguments: of the obstacles (see `skillfold.clearance.Compiled`).
        margin: clearance [m] that edges keep.
        lower, upper: (D,) limits of the joints.
        turning: (D,) 1 where a joint is continuous: its positions count up to full turns.
        middle: (4,) rotation of the chart (see `skillfold.keyframes.charts`).
        axis: (2, 6) chart coordinates of the parent's and the child's centre.
        metric: (6, 6) whitens chart coordinates: nearest is nearest in these.
        reach: η, longest edge of the tree and longest step of a descent [rad].
    """

    tool: Tool
    hold: Held
    goal: Held
    clearance: Any
    edge: Any
    arguments: Indices
    margin: float
    lower: Array
    upper: Array
    turning: Indices
    middle: Array
    axis: Array
    metric: Array
    reach: float


class Work(NamedTuple):
    """Scratch of one loop.

    Attributes:
        pose, wanted, passing: (7,).
        flat, step, other: (6,).
        q, state, end: (D,).
        jacobian: (6, D).
        square: (6, 6).
    """

    pose: Array
    wanted: Array
    passing: Array
    flat: Array
    step: Array
    other: Array
    q: Array
    state: Array
    end: Array
    jacobian: Array
    square: Array


@inner
def make_work(dof: int) -> Work:
    """Room for it."""
    return Work(
        np.empty(7),
        np.empty(7),
        np.empty(7),
        np.empty(6),
        np.empty(6),
        np.empty(6),
        np.empty(dof),
        np.empty(dof),
        np.empty(dof),
        np.empty((6, dof)),
        np.empty((6, 6)),
    )


_ROW, _TABLE = np.empty(0), np.empty(0, np.int64)
_excess_at = function_at(0.0, _ROW, _TABLE)
_project_at = function_at(0.0, _ROW, _ROW, _TABLE)
_edge_at = function_at(0.0, _ROW, _ROW, 0.0, _TABLE)


@inner
def problem_at(table: Indices) -> Problem:
    """The problem that a table describes."""
    place, functions, numbers = vector(table, PLACE), indices(table, FUNCTIONS), vector(table, NUMBERS)
    project, limits = _project_at(functions[1]), matrix(table, LIMITS)
    return Problem(
        Tool(indices(table, MACHINE), scalar(table, FRAME), place[:3], place[3:]),
        Held(_excess_at(functions[0]), project, indices(table, HOLD), numbers[0]),
        Held(_excess_at(functions[2]), project, indices(table, GOAL), numbers[1]),
        _project_at(functions[3]),
        _edge_at(functions[4]),
        indices(table, OBSTACLES),
        numbers[2],
        limits[0],
        limits[1],
        indices(table, TURNING),
        vector(table, MIDDLE),
        matrix(table, AXIS),
        matrix(table, METRIC),
        numbers[3],
    )
