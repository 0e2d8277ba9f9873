"""`PointObstacles`: points in the space of states to keep away from, as in section IV-B of paper 000."""

import threading
from functools import cache
from typing import Any

import numpy as np

from skillfold.clearance import Compiled, pointers
from skillfold.errors import InputError
from skillfold.planning import point_distances as loops
from skillfold.recordings import LARGEST, shortened
from skillfold.tables import Array, Indices, Table, table_of

FORBIDDEN = 0.5  # of the reach: the ball about each point that no path may enter
STEPS_A_REACH = 16  # at which a path is checked


class PointObstacles:
    """Points that trace a region to avoid, each acting on states nearer than its reach (βℓ in section IV-B1).

    The outer half of the reach is what planners try to keep, the inner half is forbidden: `clearance` is the distance
    to the nearest point less half the reach. May be asked from several threads at once.

    Attributes:
        points: (m, D), in the units of the states.
        reach: of each point, in the same; the paper's βℓ, where ℓ is the usual distance between neighbouring samples.
    """

    def __init__(self, points: Any, reach: float) -> None:
        """See above.

        Raises:
            InputError: points of another shape than (m, D) or not finite, or a reach that is not above zero.
        """
        self.points = _read(points)
        reach = float(reach) if isinstance(reach, np.floating) else reach
        real = isinstance(reach, int | float | np.integer) and not isinstance(reach, bool)
        if not (real and 0 < reach < LARGEST):
            raise InputError(f"reach {reach!r}; expected a number above zero, in the units of the states.")
        self.reach = float(reach)
        self._local = threading.local()

    def __reduce__(self) -> tuple[Any, ...]:
        return (PointObstacles, (self.points, self.reach))

    def __repr__(self) -> str:
        return f"PointObstacles({len(self.points)} points in {self.points.shape[1]} dimensions, reach {self.reach:g})"

    @property
    def margin(self) -> float:
        """What planners try to keep: the outer half of the reach."""
        return (1.0 - FORBIDDEN) * self.reach

    @property
    def resolution(self) -> float:
        """Distance between states at which a path is checked."""
        return self.reach / STEPS_A_REACH

    @property
    def bounds(self) -> tuple[Array, Array]:
        """No limits (D,)."""
        infinite = np.full(self.points.shape[1], np.inf)
        return -infinite, infinite

    def clearance(self, q: Any) -> Array:
        """Signed distance (...,) of states (..., D) from the forbidden balls.

        Raises:
            InputError: q of another shape or not finite.
        """
        states, shape = self._states(q)
        out = np.empty(len(states))
        loops.clearances(states, self._table().entries, out, np.empty((0, states.shape[1])))
        return out.reshape(shape)[()]

    def clearance_gradient(self, q: Any) -> Array:
        """Derivative (..., D) of the clearance: the unit vector away from the nearest point."""
        states, shape = self._states(q)
        gradients = np.empty(states.shape)
        loops.clearances(states, self._table().entries, np.empty(len(states)), gradients)
        return gradients.reshape(*shape, states.shape[1])

    def nearest(self, q: Any) -> str:
        """The nearest point of a state (D,), in words."""
        states, shape = self._states(q)
        if shape:
            raise InputError(f"nearest: states of shape {np.shape(q)}; expected one, ({self.points.shape[1]},).")
        return f"obstacle point {int(((self.points - states[0]) ** 2).sum(1).argmin())}"

    def compiled(self) -> Compiled:
        """Functions for compiled loops with their arguments, for the thread that asks."""
        table = self._table()
        return Compiled(*_functions(), table.entries, len(self.points), True, table)

    def _table(self) -> Table:
        found = getattr(self._local, "table", None)
        if found is None:
            arrays = {
                loops.POINTS: np.ascontiguousarray(self.points.T),
                loops.RADIUS: np.array([FORBIDDEN * self.reach]),
                loops.SQUARES: np.zeros(len(self.points)),
            }
            found = self._local.table = table_of(arrays, loops.SLOTS)
        return found

    def _states(self, q: Any) -> tuple[Array, tuple[int, ...]]:
        states, expected = _numbers(q), f"expected finite numbers (..., {self.points.shape[1]})"
        if states is None:
            raise InputError(f"States {shortened(q)}; {expected}.")
        if states.ndim == 0 or states.shape[-1] != self.points.shape[1]:
            raise InputError(f"States of shape {states.shape}; {expected}.")
        return np.ascontiguousarray(states.reshape(-1, states.shape[-1])), states.shape[:-1]


def _numbers(values: Any) -> Array | None:
    """As float64, where they are numbers whose squares are numbers too."""
    try:
        array = np.asarray(values)
        array = array.astype(np.float64) if array.dtype.kind in "iuf" and not np.ma.is_masked(values) else None
    except (TypeError, ValueError):
        return None
    return array if array is not None and (np.abs(array) < LARGEST).all() else None


def _read(points: Any) -> Array:
    array = _numbers(points)
    if array is None or array.ndim != 2 or array.size == 0:
        raise InputError("Obstacle points: expected finite numbers (m, D), one row a point; m and D at least 1.")
    array.flags.writeable = False
    return array


def _clearance(q: Array, gradient: Array, arguments: Indices) -> float:
    return loops.clearance(q, gradient, arguments)


def _within(q: Array, reach: float, near: Array, gradients: Array, arguments: Indices) -> int:
    return loops.within(q, reach, near, gradients, arguments)


def _edge(start: Array, end: Array, margin: float, arguments: Indices) -> float:
    return loops.edge(start, end, margin, arguments)


@cache
def _functions() -> tuple[Any, Any, Any]:
    return pointers(_clearance, _within, _edge)
