"""Obstacles as the compiled loops of planners take them.

Functions go by address: handing over the functions themselves costs 50 µs and more in every call from Python.
"""

from typing import Any, NamedTuple

import numpy as np

from skillfold.clearance import Compiled
from skillfold.jit import function_at

Indices = np.ndarray[Any, np.dtype[np.int64]]

_row, _rows, _table = np.empty(0), np.empty((0, 0)), np.empty(0, np.int64)
clearance_at = function_at(0.0, _row, _row, _table)
within_at = function_at(0, _row, 0.0, _row, _rows, _table)
edge_at = function_at(0.0, _row, _row, 0.0, _table)


class Barrier(NamedTuple):
    """Obstacles for compiled loops.

    Attributes:
        clearance, within, edge: addresses of what `Compiled` has, for `clearance_at`, `within_at`, `edge_at`.
        arguments, exact: as in `Compiled`, which must be kept as long.
    """

    clearance: int
    within: int
    edge: int
    arguments: Indices
    exact: bool


def barrier_of(compiled: Compiled) -> Barrier:
    """What the loops take of compiled obstacles."""
    clearance, within, edge = (each.address for each in (compiled.clearance, compiled.within, compiled.edge))
    return Barrier(clearance, within, edge, compiled.arguments, compiled.exact)
