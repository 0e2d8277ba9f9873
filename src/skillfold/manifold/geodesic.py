"""Shortest paths on the manifold (section IV-A): a first path, then both of the paper's conditions at once."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from skillfold.manifold.kernels.geodesic import resample, solve_geodesic
from skillfold.manifold.kernels.leaf import relax_on_field
from skillfold.manifold.model import Model

Array = np.ndarray[Any, np.dtype[np.float64]]

TOLERANCE = 1e-7  # of the last step, in rms radii of the data
LEAF_TOLERANCE = 1e-10  # the same, of the paper's own conditions
LIMIT = 100  # iterations
CAP = 0.3  # longest step of a path state in one iteration, in rms radii


@dataclass(frozen=True)
class Geodesic:
    """A path in inner coordinates and how it was found.

    Attributes:
        states: (n, D - f).
        iterations: of the relaxation.
        converged: whether its last step was below the tolerance.
        first: "grown" (Algorithm 1), "graph" (over the anchors, where growing did not meet or did not settle) or
            "recordings" (beside those that spread about it).
    """

    states: Array
    iterations: int
    converged: bool
    first: str


def geodesic(model: Model, start: Array, goal: Array, points: int) -> Geodesic:
    """From start to goal, inner coordinates (D - f,), which stay as they are."""
    found = _solved(model, np.array([start, goal]), points, "grown")
    if found.converged:
        return found
    over_anchors = graph_path(model, start, goal)
    found = _solved(model, over_anchors, points, "graph")
    if found.converged:
        return found
    # Where recordings spread, anchors lie too thick for a smooth surface: a path that wanders is no improvement.
    path = np.empty((points, len(start)))
    resample(over_anchors, path)
    return Geodesic(path, found.iterations, False, "graph")


def leaf_geodesic(model: Model, start: Array, goal: Array, points: int) -> Geodesic:
    """The paper's own path: err_M alone, which aligns tangents along the path but ties it to no data.

    Solves the two fixed-point equations of the printed descent together; from the same first path.
    """
    first = geodesic(model, start, goal, points)
    path = first.states.copy()
    iterations, moved = relax_on_field(model.field, path, LEAF_TOLERANCE, LIMIT)
    return Geodesic(path, int(iterations), bool(moved < LEAF_TOLERANCE), first.first)


def _solved(model: Model, first: Array, points: int, kind: str) -> Geodesic:
    path = np.empty((points, first.shape[1]))
    iterations, moved = solve_geodesic(model.table, first, model.step, path, TOLERANCE, CAP, LIMIT)
    return Geodesic(path, iterations, moved < TOLERANCE, kind)


def graph_path(model: Model, start: Array, goal: Array) -> Array:
    """The shortest way over neighbouring anchors; (n, D - f), start and goal included."""
    anchors = model.anchors
    first, last = np.asarray(KDTree(anchors).query(np.vstack([start, goal]))[1])
    i, j = model.edges.T
    lengths = np.maximum(np.linalg.norm(anchors[i] - anchors[j], axis=1), 1e-300)
    graph = coo_matrix((lengths, (i, j)), shape=(len(anchors), len(anchors)))
    before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)[1]
    way = [int(last)]
    while way[-1] != first and before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    return np.vstack([start, anchors[way[::-1]], goal])
