"""Clearance for loops that stay compiled: functions of one type each, and their arguments."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import pointer
from skillfold.robots import distances, edges
from skillfold.robots.tables import Array, Indices, Table


class Compiled(NamedTuple):
    """Functions that a compiled loop can take as arguments, to be called with `arguments` last.

    Their types say nothing of robots: a loop that takes them serves any obstacles that answer alike, and is compiled
    once. Keep this object as long as they are in use: the arguments are addresses of what `owner` holds.

    Attributes:
        clearance: (q (dof,), gradient (dof,) or (0,), arguments) → clearance, NaN if q is not finite; fills in the
            gradient.
        within: (q, reach, distances (n,), gradients (n, dof), arguments) → how many distances are below reach;
            -1 if q is not finite.
        edge: (start, end, margin, arguments) → share of the straight edge that is clear; 1 is all of it, 0 if
            an end is not finite.
        arguments: int64 array of one robot in one scene, for one thread.
        capacity: how many distances `within` can find at most.
        owner: what the arguments point to.
    """

    clearance: Any
    within: Any
    edge: Any
    arguments: Indices
    capacity: int
    owner: Table


def compiled_for(table: Table, capacity: int) -> Compiled:
    """The functions with a table of obstacles."""
    return Compiled(*_functions(), table.entries, capacity, table)


def _clearance(q: Array, gradient: Array, arguments: Indices) -> float:
    return distances.clearance(q, gradient, arguments)


def _within(q: Array, reach: float, near: Array, gradients: Array, arguments: Indices) -> int:
    return distances.within(q, reach, near, gradients, arguments)


def _edge(start: Array, end: Array, margin: float, arguments: Indices) -> float:
    return edges.edge(start, end, margin, arguments)


@cache
def _functions() -> tuple[Any, Any, Any]:
    """Compiled at first use, or found on disk."""
    row, rows, table = np.empty(0), np.empty((0, 0)), np.empty(0, np.int64)
    return (
        pointer(_clearance, 0.0, row, row, table),
        pointer(_within, 0, row, 0.0, row, rows, table),
        pointer(_edge, 0.0, row, row, 0.0, table),
    )
