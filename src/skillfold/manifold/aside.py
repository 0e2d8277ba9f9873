"""Demonstrated routes pushed aside by obstacles: elsewhere they keep the way that the demonstrations took."""

from itertools import pairwise
from typing import Any

import numpy as np

from skillfold.clearance import Clearance
from skillfold.manifold.kernels.detours import bend_aside
from skillfold.manifold.kernels.walking import Chart
from skillfold.planning.barrier import barrier_of

Array = np.ndarray[Any, np.dtype[np.float64]]

REACH = 0.06  # of a path: how far a push is passed on along it
CAP = 0.05  # of a path's extent: longest step of a state in one iteration
TOLERANCE, LIMIT = 1e-4, 200  # of the last step, in extents; iterations


def aside_of(path: Array, given: Array, obstacles: Clearance) -> Array:
    """The path (n, D) a margin off obstacles, or itself where it is; states that were given (m, D) stay."""
    clear = np.atleast_1d(obstacles.clearance(path))
    if clear.min() >= obstacles.margin:
        return path
    compiled = obstacles.compiled()
    lower, upper = obstacles.bounds
    centre = path.mean(0)
    scale = float(np.sqrt(((path - centre) ** 2).sum(1).mean())) or 1.0
    chart = Chart(centre, scale, np.eye(len(centre)), lower, upper)
    barrier = barrier_of(compiled)
    fixed = np.flatnonzero((path[:, None] == given[None]).all(2).any(1))
    moved = (path - centre) / scale
    for first, last in pairwise(fixed):
        part = np.ascontiguousarray(moved[first : last + 1])
        if len(part) > 2:
            bend_aside(
                chart,
                barrier,
                part,
                obstacles.margin,
                max(compiled.capacity, 1),
                REACH * len(path),
                CAP,
                TOLERANCE,
                LIMIT,
            )
            moved[first : last + 1] = part
    aside = centre + scale * moved
    aside[fixed] = path[fixed]
    return aside
