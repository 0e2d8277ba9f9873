"""Clearance for loops that stay compiled: functions of one type each, and their arguments."""

from functools import cache
from typing import Any

import numpy as np

from skillfold.clearance import Compiled, Indices
from skillfold.jit import pointer
from skillfold.robots import distances, edges
from skillfold.tables import Array, Table


def compiled_for(table: Table, capacity: int) -> Compiled:
    """The functions with a table of obstacles."""
    return Compiled(*_functions(), table.entries, capacity, False, table)


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
