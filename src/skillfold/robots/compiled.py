"""Clearance for loops that stay compiled: functions of one type each, and their arguments."""

from functools import cache
from typing import Any

from skillfold.clearance import Compiled, Indices, pointers
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
    return pointers(_clearance, _within, _edge)
