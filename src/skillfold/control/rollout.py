"""`Rollout`: what happened in a closed loop, step by step."""

from dataclasses import dataclass, field
from os import PathLike
from typing import Any, NamedTuple, Self

import numpy as np

from skillfold.motion import Array, Trajectory

FALLEN = 0.6  # radians of tilt, beyond which a tumbler of twice its diameter lies or falls
LOST = 0.25  # metres from the tool: farther away a tumbler has left the tray


class Contact(NamedTuple):
    """Two shapes that touched: which, and from when to when [s]."""

    first: str
    second: str
    start: float
    end: float


@dataclass(frozen=True, eq=False, repr=False)
class Rollout:
    """What happened, at n steps of time; D joints.

    Attributes:
        times: (n,) [s].
        states, velocities, torques: (n, D).
        modes: (n,) words of the controller.
        distances: (n,) from the manifold as the controller saw it; NaN where it knows none.
        clearances: (n,) from obstacles and itself [m]; infinite where there is nothing.
        tool_poses: (n, 7) in the world.
        tumblers: (n, k, 7) poses of the tumblers in the world.
        step_times: (n,) seconds that the controller took.
        contacts: of the robot with obstacles and itself.
        names: of the joints.
        facts: anything else worth knowing, in JSON's types: robot, replans, seed, noise, step.
    """

    times: Array
    states: Array
    velocities: Array
    torques: Array
    modes: np.ndarray[Any, np.dtype[np.str_]]
    distances: Array
    clearances: Array
    tool_poses: Array
    tumblers: Array
    step_times: Array
    contacts: tuple[Contact, ...] = ()
    names: tuple[str, ...] = ()
    facts: dict[str, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        stands = f", {self.standing} of {self.tumblers.shape[1]} tumblers standing" if self.tumblers.shape[1] else ""
        return (
            f"Rollout({self.times[-1]:.3g} s, {len(self)} steps, {len(self.contacts)} contacts, "
            f"clearance {self.clearances.min():.3g} m at least{stands})"
        )

    @property
    def tilts(self) -> Array:
        """(n, k) angle [rad] of each tumbler with the vertical."""
        x, y = self.tumblers[..., 4], self.tumblers[..., 5]
        return np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0))

    @property
    def standing(self) -> int:
        """Tumblers that stand on the tray at the end."""
        near = np.linalg.norm(self.tumblers[-1, :, :3] - self.tool_poses[-1, :3], axis=1) < LOST
        return int((near & (self.tilts[-1] < FALLEN)).sum())

    @property
    def trajectory(self) -> Trajectory:
        """The states in time."""
        return Trajectory(self.times, self.states, self.names)

    def count(self, mode: str) -> int:
        """Steps in a mode."""
        return int((self.modes == mode).sum())

    def save(self, path: str | PathLike[str]) -> None:
        """Write everything to one sealed NPZ file, or a table of the steps to a CSV file, by the name's ending.

        Raises:
            SkillFileError: the file cannot be written, or ends in something else.
        """
        from skillfold.io.rollout_files import write_rollout

        write_rollout(path, self)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Self:
        """Read an NPZ file that `save` wrote; every array is checked.

        Raises:
            SkillFileError: the file is missing, damaged, or no rollout.
        """
        from skillfold.io.rollout_files import read_rollout

        arrays, contacts, names, facts = read_rollout(path)
        return cls(**arrays, contacts=tuple(Contact(*c) for c in contacts), names=names, facts=facts)
