"""What planners, checks and controllers know of obstacles: how far off they are, and no more."""

from typing import Any, NamedTuple, Protocol

import numpy as np

from skillfold.motion import Array

Indices = np.ndarray[Any, np.dtype[np.int64]]


class Compiled(NamedTuple):
    """Functions that a compiled loop can take as arguments, to be called with `arguments` last.

    Their types say nothing of robots: a loop that takes them serves any obstacles that answer alike, and is compiled
    once. Keep this object as long as they are in use: the arguments are addresses of what `owner` holds.

    Attributes:
        clearance: (q (D,), gradient (D,) or (0,), arguments) → clearance, NaN if q is not finite; fills in the
            gradient.
        within: (q, reach, distances (n,), gradients (n, D), arguments) → how many distances are below reach;
            -1 if q is not finite.
        edge: (start, end, margin, arguments) → share of the straight edge that is clear; 1 is all of it, 0 if
            an end is not finite.
        arguments: int64 array, for one thread.
        capacity: how many distances `within` can find at most.
        exact: whether an edge costs no more than a state: then there is no use in looking at states first.
        owner: what the arguments point to.
    """

    clearance: Any
    within: Any
    edge: Any
    arguments: Indices
    capacity: int
    exact: bool
    owner: Any


class Clearance(Protocol):
    """Anything that states can run into: shapes around a robot, or points in the space of states."""

    @property
    def margin(self) -> float:
        """What planners try to keep; a path is valid down to a clearance of zero."""
        ...

    @property
    def resolution(self) -> float:
        """Distance between states at which a path is checked."""
        ...

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest values (D,) of the coordinates, infinite where there is no limit."""
        ...

    def clearance(self, q: Any, /) -> Any:
        """Signed distance (...,) from states (..., D) to what is nearest; below zero they overlap."""
        ...

    def nearest(self, q: Any, /) -> str:
        """What is nearest at a state (D,), in words."""
        ...

    def compiled(self) -> Compiled:
        """The same for compiled loops, for the thread that asks."""
        ...


def pointers(clearance: Any, within: Any, edge: Any) -> tuple[Any, Any, Any]:
    """Three plain functions as `Compiled` wants them; compiled now, or found on disk."""
    from skillfold.jit import pointer

    row, rows, table = np.empty(0), np.empty((0, 0)), np.empty(0, np.int64)
    return (
        pointer(clearance, 0.0, row, row, table),
        pointer(within, 0, row, 0.0, row, rows, table),
        pointer(edge, 0.0, row, row, 0.0, table),
    )
