"""`Push`: a force on a body of the robot for a while."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.motion import Array


@dataclass(frozen=True)
class Push:
    """A force on a body of the robot for a while.

    Attributes:
        time: when it begins [s].
        body: name, or number of the joint that moves it, from 1 on.
        force: (3,) [N] in world axes, at the body's centre of mass.
        duration: [s].
    """

    time: float
    body: str | int
    force: Any
    duration: float

    def __post_init__(self) -> None:
        force = np.asarray(self.force, np.float64)
        if force.shape != (3,) or not np.isfinite(force).all():
            raise InputError(f"Push: force {self.force!r}; expected three numbers [N].")
        if not (np.isfinite(self.time) and np.isfinite(self.duration) and self.time >= 0 and self.duration > 0):
            raise InputError(f"Push: at {self.time!r} s for {self.duration!r} s; expected seconds, from 0 on.")
        object.__setattr__(self, "force", tuple(force.tolist()))

    @property
    def end(self) -> float:
        """When it ends [s]."""
        return self.time + self.duration

    def at(self, time: float) -> Array:
        """Force (3,) at a time [s]."""
        return np.array(self.force) if self.time <= time < self.end else np.zeros(3)
