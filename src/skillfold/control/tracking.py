"""`JointTracker`: a reference held in joint space alone, for comparison with what knows a manifold."""

from typing import TYPE_CHECKING, Any

import numpy as np

from skillfold.control.commands import Command
from skillfold.control.timing import Reference
from skillfold.robots.inverse import inverses

if TYPE_CHECKING:
    from skillfold.robots.robot import Robot


class JointTracker:
    """Computed torque along a reference: the same stiffness in every direction.

    Attributes:
        reference: what is followed.
        done: whether it has come to its end.
    """

    def __init__(
        self,
        reference: Reference,
        robot: "Robot",
        stiffness: float = 100.0,
        damping: float = 1.0,
        load: tuple[float, Any] = (0.0, (0.0, 0.0, 0.0)),
    ) -> None:
        """Get ready: `stiffness` is ω² [1/s²], `damping` ζ; `load` as for `ReactiveController`."""
        self.reference, self.done = reference, False
        self._dynamics, self._limits = robot.dynamics(*load).compiled(), robot.torque_limits
        self._stiffness, self._damping = stiffness, 2.0 * damping * float(np.sqrt(stiffness))

    def command(self, t: float, q: Any, qd: Any) -> Command:
        """What to do at a time t [s], positions q (D,) and velocities qd (D,)."""
        wanted = self.reference.at(t)
        self.done = t >= self.reference.duration
        back = self._stiffness * (wanted[0] - q) + self._damping * (wanted[1] - qd)
        acceleration = wanted[2] + back
        torque = np.empty((1, len(acceleration)))
        states = (np.asarray(row, np.float64)[None] for row in (q, qd, acceleration))
        inverses(*states, self._dynamics.arguments, torque)
        torque = np.clip(torque[0], -self._limits, self._limits)
        away = float(np.linalg.norm(wanted[0] - q))
        return Command(torque, "tracking", acceleration, wanted, np.nan, away, np.inf)
