"""What planners know of a constraint on the tool's pose, and the same for loops that stay compiled."""

from typing import Any, NamedTuple, Protocol

import numpy as np

from skillfold.errors import InputError

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]


class PoseConstraint(Protocol):
    """Anything learnt or written by hand that holds for poses of a tool.

    Lengths of pose differences are metres, a radian as `charts.LENGTH` metres. What else a constraint may have, and
    planners then use: `sample(count, seed)` → poses (count, 7) that hold it, and `compiled()` → `CompiledConstraint`;
    without them poses are drawn by the robot and projected, and compiled loops call back into Python.
    """

    def distance(self, poses: Any, /) -> Any:
        """How far (...,) [m] poses (..., 7) lie outside; 0 inside."""
        ...

    def project(self, poses: Any, /) -> Any:
        """The nearest poses (..., 7) inside."""
        ...


class CompiledConstraint(NamedTuple):
    """Functions that a compiled loop can take as arguments, to be called with `arguments` last.

    Their types say nothing of the constraint: a loop that takes them serves all, and is compiled once.

    Attributes:
        excess: (pose (7,), arguments) → at most 0 inside, above it outside; for envelopes √d² − 1 in gates, else
            metres. Cheap.
        project: (pose (7,), out (7,), arguments) → the excess of the pose; fills in the nearest pose inside.
        arguments: int64 array, usually a table (see `skillfold.tables`).
        owner: what the arguments point to.
    """

    excess: Any
    project: Any
    arguments: Indices
    owner: Any


def generator(count: Any, seed: Any) -> np.random.Generator:
    """What draws `count` samples from `seed`, once both were found to be whole numbers of at least 0.

    Raises:
        InputError: they are not.
    """
    for name, value in (("count", count), ("seed", seed)):
        whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if not (whole and value >= 0):
            raise InputError(f"{name}: {value!r:.40}; expected a whole number, at least 0.")
    return np.random.default_rng(seed)
