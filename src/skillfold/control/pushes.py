"""`Push`: a force on a body of the robot for a while."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.motion import Array
from skillfold.robots.poses import read_numbers


@dataclass(frozen=True)
class Push:
    """A force on a body of the robot for a while.

    Attributes:
        time: when it begins [s].
        body: name, or number of the joint that moves it, from 1 on.
        force: (3,) [N] in world axes, at the body's centre of mass.
        duration: [s].

    Raises:
        InputError: no three numbers of force, no times.
    """

    time: float
    body: str | int
    force: Any
    duration: float

    def __post_init__(self) -> None:
        force = read_numbers(self.force, "Push: force", "three numbers [N]")
        if force.shape != (3,):
            raise InputError(f"Push: force {self.force!r}; expected three numbers [N].")
        times = read_numbers((self.time, self.duration), "Push: time and duration", "seconds, from 0 on")
        if times.shape != (2,) or not (times[0] >= 0 and times[1] > 0):
            raise InputError(f"Push: at {self.time!r} s for {self.duration!r} s; expected seconds, from 0 on.")
        object.__setattr__(self, "force", tuple(force.tolist()))

    @property
    def end(self) -> float:
        """When it ends [s]."""
        return self.time + self.duration

    def at(self, time: float) -> Array:
        """Force (3,) at a time [s]."""
        return np.array(self.force) if self.time <= time < self.end else np.zeros(3)
