"""Paths bent by springs: Algorithm 2 of paper 000, for comparison; it is local and slow to settle."""

from typing import Any

import numpy as np

from skillfold.manifold.kernels.springs import relax_springs
from skillfold.manifold.terrain import Terrain

Array = np.ndarray[Any, np.dtype[np.float64]]

TOLERANCE = 1e-5  # of the last step, rms radii
LIMIT = 2000  # iterations
TORN = 1e6  # rms radii: states so far away come back no more


def sprung(terrain: Terrain, path: Array) -> tuple[Array, int, bool]:
    """The path (n, D) after obstacles and springs came to rest; iterations, and whether they did.

    Where they tear it apart instead, it is left as it was.
    """
    moved_path = path.copy()
    capacity = max(terrain.compiled.capacity, 1)
    iterations, moved = relax_springs(
        terrain.model.table,
        terrain.chart,
        terrain.barrier,
        moved_path,
        terrain.obstacles.margin,
        capacity,
        TOLERANCE,
        LIMIT,
    )
    held = bool((np.abs(moved_path) < TORN).all())
    return moved_path if held else path, int(iterations), held and bool(moved < TOLERANCE)
