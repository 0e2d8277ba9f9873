"""Shortest paths on the manifold (section IV-A): a first path, then both of the paper's conditions at once."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from skillfold.manifold.kernels.geodesic import grow_path, relax, relax_on_field, resample
from skillfold.manifold.model import Model

Array = np.ndarray[Any, np.dtype[np.float64]]

TOLERANCE = 1e-9  # of the last step, in rms radii of the data
LIMIT = 100  # iterations
GROWN = 2000  # states that a first path may have
CAP = 0.3  # longest step of a path state in one iteration, in rms radii


@dataclass(frozen=True)
class Geodesic:
    """A path in inner coordinates and how it was found.

    Attributes:
        states: (n, D - f).
        iterations: of the relaxation.
        converged: whether its last step was below the tolerance.
        first: "grown" (Algorithm 1) or "graph" (over the anchors, where growing did not meet or did not settle).
    """

    states: Array
    iterations: int
    converged: bool
    first: str


def geodesic(model: Model, start: Array, goal: Array, points: int) -> Geodesic:
    """From start to goal, inner coordinates (D - f,), which stay as they are."""
    grown = np.empty((GROWN, len(start)))
    count = grow_path(model.surface, model.field, start, goal, model.step, grown)
    if count:
        found = _relaxed(model, grown[:count], points, "grown")
        if found.converged:
            return found
    return _relaxed(model, graph_path(model, start, goal), points, "graph")


def leaf_geodesic(model: Model, start: Array, goal: Array, points: int) -> Geodesic:
    """The paper's own path: err_M alone, which aligns tangents along the path but ties it to no data.

    Solves the two fixed-point equations of the printed descent together; from the same first path.
    """
    first = geodesic(model, start, goal, points)
    path = first.states.copy()
    iterations, moved = relax_on_field(model.field, path, TOLERANCE, LIMIT)
    return Geodesic(path, int(iterations), bool(moved < TOLERANCE), first.first)


def _relaxed(model: Model, first: Array, points: int, kind: str) -> Geodesic:
    path = np.empty((points, first.shape[1]))
    resample(first, path)
    iterations, moved, _ = relax(model.surface, model.field, path, TOLERANCE, CAP, LIMIT)
    return Geodesic(path, int(iterations), bool(moved < TOLERANCE), kind)


def graph_path(model: Model, start: Array, goal: Array) -> Array:
    """The shortest way over neighbouring anchors; (n, D - f), start and goal included."""
    anchors = model.anchors
    first, last = KDTree(anchors).query(np.vstack([start, goal]))[1]
    i, j = model.edges.T
    lengths = np.maximum(np.linalg.norm(anchors[i] - anchors[j], axis=1), 1e-300)
    graph = coo_matrix((lengths, (i, j)), shape=(len(anchors), len(anchors)))
    before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)[1]
    way = [int(last)]
    while way[-1] != first and before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    return np.vstack([start, anchors[way[::-1]], goal])
