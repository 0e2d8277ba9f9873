"""Quintic polynomials between two joint states: the naive planner of paper 000 (Craig 1989; Table I).

Each joint follows the one polynomial of degree five that meets position, velocity and acceleration at both ends.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from skillfold.errors import InputError
from skillfold.motion import Array, Trajectory


@dataclass(frozen=True)
class Quintic:
    """A motion of D joints over `duration` seconds; made by `between`.

    Attributes:
        coefficients: (6, D) of the powers of t / duration, constant first.
        duration: seconds.
    """

    coefficients: Array
    duration: float

    @classmethod
    def between(
        cls,
        start: Any,
        goal: Any,
        duration: float = 1.0,
        *,
        velocities: tuple[Any, Any] = (0.0, 0.0),
        accelerations: tuple[Any, Any] = (0.0, 0.0),
    ) -> Self:
        """The motion from start to goal, both (D,), at rest at both ends unless told otherwise.

        Args:
            start, goal: joint states.
            duration: seconds, positive.
            velocities, accelerations: at start and goal, per second and per second², each (D,) or one for all.

        Raises:
            InputError: not finite, ends of different shapes, no positive duration.
        """
        if not (np.isfinite(duration) and duration > 0):
            raise InputError(f"Quintic: duration {duration!r}; expected positive seconds.")
        first, last = _row(start, "start"), _row(goal, "goal")
        if first.shape != last.shape:
            raise InputError(f"Quintic: start {first.shape} and goal {last.shape}; expected the same shape.")
        v0, v1 = (duration * _like(first, v, "velocity") for v in velocities)
        a0, a1 = (duration**2 * _like(first, a, "acceleration") for a in accelerations)
        # What the last three powers have to add: position, velocity and acceleration at the goal.
        p, v, a = last - first - v0 - a0 / 2, v1 - v0 - a0, a1 - a0
        high = [10 * p - 4 * v + a / 2, -15 * p + 7 * v - a, 6 * p - 3 * v + a / 2]
        return cls(np.stack([first, v0, a0 / 2, *high]), float(duration))

    def position(self, times: Any) -> Array:
        """States (..., D) at times (...) from 0 to `duration`."""
        return self._derivative(times, 0)

    def velocity(self, times: Any) -> Array:
        """(..., D) per second."""
        return self._derivative(times, 1)

    def acceleration(self, times: Any) -> Array:
        """(..., D) per second²."""
        return self._derivative(times, 2)

    def trajectory(self, count: int = 101) -> Trajectory:
        """`count` states at even times."""
        times = np.linspace(0.0, self.duration, count)
        return Trajectory(times, self.position(times))

    def _derivative(self, times: Any, order: int) -> Array:
        shares = np.asarray(times, np.float64) / self.duration
        if not ((shares >= 0) & (shares <= 1 + 1e-12)).all():
            raise InputError(f"Quintic: times outside 0 to {self.duration:g} s.")
        powers = np.arange(6)
        factors = np.prod([powers - i for i in range(order)], axis=0) if order else np.ones(6)
        terms = factors * shares[..., None] ** np.maximum(powers - order, 0)
        return terms @ self.coefficients / self.duration**order


def rest_to_rest(shares: Array) -> Array:
    """Share of the way done at shares (n,) of the time, by the quintic that rests at both ends."""
    return shares**3 * (10 - 15 * shares + 6 * shares**2)


def timed(path: Array, shares: Array) -> Array:
    """States of a path (n, D) at shares (m,) of the time, its arc length following `rest_to_rest`; (m, D)."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    done = rest_to_rest(shares) * along[-1]
    return np.column_stack([np.interp(done, along, column) for column in path.T])


def _row(values: Any, name: str) -> Array:
    row = np.asarray(values, np.float64)
    if row.ndim != 1 or not np.isfinite(row).all():
        raise InputError(f"Quintic: {name} of shape {row.shape}; expected one finite joint state (D,).")
    return row


def _like(row: Array, values: Any, name: str) -> Array:
    given = np.asarray(values, np.float64)
    if given.shape not in ((), row.shape) or not np.isfinite(given).all():
        raise InputError(f"Quintic: {name} of shape {given.shape}; expected finite numbers {row.shape}, or one.")
    return np.broadcast_to(given, row.shape)
