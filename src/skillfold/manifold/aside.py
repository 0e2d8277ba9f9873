"""Demonstrated routes pushed aside by obstacles: elsewhere they keep the way that the demonstrations took."""

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from skillfold.clearance import Clearance
from skillfold.manifold.kernels.detours import bend_aside
from skillfold.manifold.kernels.walking import Chart
from skillfold.planning.barrier import barrier_of
from skillfold.tables import Indices

Array = np.ndarray[Any, np.dtype[np.float64]]

REACH = 0.06  # of a path: how far a push is passed on along it
CAP = 0.05  # of a path's extent: longest step of a state in one iteration
TOLERANCE, LIMIT = 1e-4, 200  # of the last step, in extents; iterations
FEW = 101  # states that mostly come to rest


def aside_of(path: Array, given: Array, obstacles: Clearance, share: float = 1.0) -> Array:
    """The path (n, D) a share of the margin off obstacles, or itself where it is; states that were given (m, D) stay.

    Many states so close together may be pushed to and fro without end: then fewer are, and the rest in between.
    """
    clear, margin = np.atleast_1d(obstacles.clearance(path)), share * obstacles.margin
    if clear.min() >= margin:
        return path
    fixed = np.flatnonzero((path[:, None] == given[None]).all(2).any(1))
    aside, at_rest = _bent(path, fixed, obstacles, margin)
    if not at_rest and len(path) > FEW:
        rows = np.union1d(np.linspace(0, len(path) - 1, FEW).astype(int), fixed)
        few, _ = _bent(path[rows], np.searchsorted(rows, fixed), obstacles, margin)
        aside = path + PchipInterpolator(rows, few - path[rows])(np.arange(len(path)))
    aside[fixed] = path[fixed]
    return aside


def _bent(path: Array, fixed: Indices, obstacles: Clearance, margin: float) -> tuple[Array, bool]:
    """The path (n, D) pushed off obstacles between its fixed states; whether it came to rest."""
    compiled = obstacles.compiled()
    lower, upper = obstacles.bounds
    centre = path.mean(0)
    scale = float(np.sqrt(((path - centre) ** 2).sum(1).mean())) or 1.0
    chart = Chart(centre, scale, np.eye(len(centre)), lower, upper)
    barrier = barrier_of(compiled)
    moved, at_rest = (path - centre) / scale, True
    for first, last in pairwise(fixed):
        part = np.ascontiguousarray(moved[first : last + 1])
        if len(part) > 2:
            _, step = bend_aside(
                chart,
                barrier,
                part,
                margin,
                max(compiled.capacity, 1),
                REACH * len(path),
                CAP,
                TOLERANCE,
                LIMIT,
            )
            moved[first : last + 1] = part
            at_rest = at_rest and step < TOLERANCE
    return centre + scale * moved, at_rest
