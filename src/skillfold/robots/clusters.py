"""Points in clusters, so that one bounding sphere speaks for many."""

from typing import Any

import numpy as np

from skillfold.tables import Array, Indices

FULL = 32  # points of a cluster at most


def clustered(points: Array) -> tuple[Indices, Indices]:
    """Order (n,) of points (n, 3) by cluster, and the first of each cluster with n at the end.

    Halves along the longest side until few are left.
    """
    parts: list[np.ndarray[Any, np.dtype[np.int64]]] = []
    stack = [np.arange(len(points))]
    while stack:
        part = stack.pop()
        if len(part) <= FULL:
            parts.append(part)
            continue
        side = int(np.ptp(points[part], axis=0).argmax())
        part = part[np.argsort(points[part, side], kind="stable")]
        stack += [part[len(part) // 2 :], part[: len(part) // 2]]
    starts = np.cumsum([0, *(len(part) for part in parts)])
    return np.concatenate(parts), starts.astype(np.int64)


def spheres(points: Array, starts: Indices) -> tuple[Array, Array]:
    """Bounding spheres of clusters: centres (C, 3) and radii (C,)."""
    counts = np.diff(starts)
    low, high = np.minimum.reduceat(points, starts[:-1]), np.maximum.reduceat(points, starts[:-1])
    centres = (low + high) / 2
    away = np.linalg.norm(points - np.repeat(centres, counts, axis=0), axis=1)
    return centres, np.maximum.reduceat(away, starts[:-1])
