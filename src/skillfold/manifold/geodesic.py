"""Shortest paths on the manifold (section IV-A): a first path, then both of the paper's conditions at once."""

from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from skillfold.manifold.kernels.geodesic import resample, solve_geodesic
from skillfold.manifold.kernels.holding import hold_geodesic
from skillfold.manifold.kernels.leaf import relax_on_field
from skillfold.manifold.model import Model

Array = np.ndarray[Any, np.dtype[np.float64]]

TOLERANCE = 1e-7  # of the last step, in rms radii of the data
LEAF_TOLERANCE = 1e-10  # the same, of the paper's own conditions
LIMIT = 100  # iterations
SLOW = 0.5  # share of a step that is taken where whole ones did not converge
CAP = 0.3  # longest step of a path state in one iteration, in rms radii


class Geodesic(NamedTuple):
    """A path and how it was found.

    Attributes:
        states: (n, D); what is free goes straight.
        iterations: of the relaxation.
        converged: whether its last step was below the tolerance.
        first: "grown" (Algorithm 1), "graph" (over the anchors, where growing did not meet or did not settle) or
            "recordings" (beside those that spread about it).
        own: whether it is solved with the surface's own tangents, as where the field's lie across it.
        held: whether it is held within the edge of the demonstrations, which the shortest would leave.
    """

    states: Array
    iterations: int
    converged: bool
    first: str
    own: bool = False
    held: bool = False


def geodesic(model: Model, ends: Array, points: int) -> Geodesic:
    """Between two ends (2, D), which stay as they are but for rounding; where they are the same, so do all states.

    Where the field's tangents lie across the surface somewhere along it, it is solved with the surface's own.
    """
    if np.array_equal(ends[0], ends[1]):
        return Geodesic(np.repeat(ends[:1], points, axis=0), 0, True, "grown")
    found = _solved(model, ends, points, "grown")
    if found.converged:
        return found
    way = graph_path(model, ends)
    over_anchors = model.path(ends[0], ends[1], way)
    for first, kind, rate in ((ends, "grown", 1.0), (over_anchors, "graph", 1.0), (over_anchors, "graph", SLOW)):
        found = _solved(model, first, points, kind, True, rate)
        if found.converged:
            return found
    return Geodesic(_even(model, ends, way, points), found.iterations, False, "graph")


def regrown(model: Model, ends: Array, points: int) -> Geodesic:
    """The same, but first found over the anchors: grown straight toward the goal, a path may cross between sheets."""
    over_anchors = model.path(ends[0], ends[1], graph_path(model, ends))
    found = _solved(model, over_anchors, points, "graph")
    return found if found.converged else _solved(model, over_anchors, points, "graph", True)


def within_edge(model: Model, found: Geodesic) -> Geodesic:
    """The same held within the edge of the demonstrations; as it is where it keeps there, or that does not settle."""
    if not found.converged:
        return found
    path = found.states.copy()
    for rate in (1.0, SLOW):
        how = TOLERANCE, CAP, LIMIT, found.own, rate
        iterations, moved = hold_geodesic(model.table, path, model.trust.spacing, *how)
        if iterations == 0:
            return found
        if moved < TOLERANCE:
            return found._replace(states=path, iterations=found.iterations + iterations, held=True)
    return found


def roundabout(model: Model, ends: Array, points: int) -> Geodesic:
    """The way over the anchors as it is.

    Where recordings spread, anchors lie too thick for a smooth surface: a path that wanders is no improvement.
    """
    return Geodesic(_even(model, ends, graph_path(model, ends), points), 0, False, "graph")


def _even(model: Model, ends: Array, way: Array, points: int) -> Array:
    path = np.empty((points, way.shape[1]))
    resample(way, path)
    return model.path(ends[0], ends[1], path)


def leaf_geodesic(model: Model, ends: Array, points: int) -> Geodesic:
    """The paper's own path: err_M alone, which aligns tangents along the path but ties it to no data.

    Solves the two fixed-point equations of the printed descent together; from the same first path.
    """
    first = geodesic(model, ends, points)
    path = model.encode(first.states)
    iterations, moved = relax_on_field(model.table, path, LEAF_TOLERANCE, LIMIT)
    states = model.path(ends[0], ends[1], path)
    return Geodesic(states, int(iterations), bool(moved < LEAF_TOLERANCE), first.first)


def _solved(model: Model, first: Array, points: int, kind: str, own: bool = False, rate: float = 1.0) -> Geodesic:
    path = np.empty((points, first.shape[1]))
    iterations, moved = solve_geodesic(model.table, first, model.step, path, TOLERANCE, CAP, LIMIT, own, rate)
    return Geodesic(path, iterations, moved < TOLERANCE, kind, own)


def graph_path(model: Model, ends: Array) -> Array:
    """The shortest way over neighbouring anchors between ends (2, D), both included; inner coordinates (n, D - f)."""
    anchors, ends = model.anchors, model.encode(ends)
    first, last = np.asarray(KDTree(anchors).query(ends)[1])
    i, j = model.edges.T
    lengths = np.maximum(np.linalg.norm(anchors[i] - anchors[j], axis=1), 1e-300)
    graph = coo_matrix((lengths, (i, j)), shape=(len(anchors), len(anchors)))
    before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)[1]
    way = [int(last)]
    while way[-1] != first and before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    return np.vstack([ends[:1], anchors[way[::-1]], ends[1:]])
