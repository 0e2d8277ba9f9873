"""Clearance for loops that stay compiled: functions of one type each, and their arguments."""

from functools import cache
from typing import Any

import numpy as np

from skillfold.clearance import Compiled, Indices, pointers
from skillfold.jit import compile_for
from skillfold.robots import distances, edges
from skillfold.tables import Array, Table


def compiled_for(table: Table, capacity: int) -> Compiled:
    """The functions with a table of obstacles."""
    return Compiled(*_functions(), table.entries, capacity, False, table)


@cache
def prepare_obstacles() -> None:
    """Have them ready, and what asks for many states at once."""
    _functions()
    table, rows = np.empty(0, np.int64), np.empty((0, 0))
    compile_for(distances.clearances, rows, table, rows.ravel(), rows)


def _clearance(q: Array, gradient: Array, arguments: Indices) -> float:
    return distances.clearance(q, gradient, arguments)


def _within(q: Array, reach: float, near: Array, gradients: Array, arguments: Indices) -> int:
    return distances.within(q, reach, near, gradients, arguments)


def _edge(start: Array, end: Array, margin: float, arguments: Indices) -> float:
    return edges.edge(start, end, margin, arguments)


@cache
def _functions() -> tuple[Any, Any, Any]:
    return pointers(_clearance, _within, _edge)
