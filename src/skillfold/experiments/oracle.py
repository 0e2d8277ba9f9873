"""Paths that are known to exist: true optimal poses over a grid of task positions, joined to a graph.

A planning case is solvable by construction when such a path is clear of its obstacles. Nothing here knows of skills
or planners. M grid poses, D joints.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from skillfold.motion import Array
from skillfold.tables import Indices

ENTRIES = 12  # grid poses that an end is joined to
Truth = Callable[[Array], Array]
"""Optimal poses (n, D) at the task positions of poses (n, D) near them; NaN where there are none."""


@dataclass(frozen=True)
class Oracle:
    """A graph of optimal poses.

    Attributes:
        poses: (M, D), rad.
        edges: (E, 2) neighbours.
        truth: what optimal poses are.
        spacing: rad between the states of a path, at most.
    """

    poses: Array
    edges: Indices
    truth: Truth
    spacing: float

    @classmethod
    def build(
        cls, lattice: Array, poses: Array, reach: float, longest: float, truth: Truth, spacing: float
    ) -> "Oracle":
        """Join the poses whose lattice places (M, m), in grid steps, are within `reach`.

        Args:
            lattice, poses: places and the optimal poses there; NaN where there are none.
            reach: of an edge, in grid steps.
            longest: of an edge, rad: a longer one jumps.
            truth, spacing: see above.
        """
        kept = np.isfinite(poses).all(axis=1)
        lattice, poses = lattice[kept], poses[kept]
        pairs = KDTree(lattice).query_pairs(reach + 1e-6, output_type="ndarray")
        lengths = np.linalg.norm(poses[pairs[:, 0]] - poses[pairs[:, 1]], axis=1)
        return cls(poses, pairs[lengths < longest].astype(np.int64), truth, spacing)

    def path(
        self, start: Array, goal: Array, clear: np.ndarray | None = None, longest: float = np.inf
    ) -> Array | None:
        """States (n, D) of the shortest path over the poses that are `clear` (M,); None where there is none.

        Edges that are longer than `longest` (rad) are not taken: they might jump over what is not clear.
        """
        clear = np.ones(len(self.poses), bool) if clear is None else clear
        nodes = np.vstack([self.poses, start, goal])
        edges = np.vstack([self.edges[clear[self.edges].all(axis=1)], *self._entries(start, goal, clear)])
        lengths = np.linalg.norm(nodes[edges[:, 0]] - nodes[edges[:, 1]], axis=1)
        short = lengths < longest
        entries = (lengths[short], tuple(edges[short].T))
        graph = csr_array(entries, shape=(len(nodes), len(nodes)))
        first, last = len(self.poses), len(self.poses) + 1
        far, before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)
        if not np.isfinite(far[last]):
            return None
        return self._dense(nodes[_walk(before, last)])

    def direct(self, start: Array, goal: Array) -> Array | None:
        """Optimal poses (n, D) at the positions of the straight line between two poses; None where it jumps."""
        return self._dense(np.stack([start, goal]))

    def _entries(self, start: Array, goal: Array, clear: np.ndarray) -> list[Indices]:
        """Edges (n, 2) from each end to the clear poses nearest to it."""
        found = []
        for index, end in enumerate((start, goal)):
            far = np.where(clear, np.linalg.norm(self.poses - end, axis=1), np.inf)
            nearest = np.argsort(far)[:ENTRIES]
            nearest = nearest[np.isfinite(far[nearest])]
            found.append(np.column_stack([np.full(len(nearest), len(self.poses) + index), nearest]))
        return found

    def _dense(self, corners: Array) -> Array | None:
        """Optimal poses along the straight lines between corners, at most about `spacing` apart."""
        states = self.truth(finely(corners, self.spacing))
        steps = np.linalg.norm(np.diff(states, axis=0), axis=1)
        return states if (steps < 5 * self.spacing).all() else None  # NaN is not below


def length(states: Array) -> float:
    """Of a path (n, D), rad."""
    return float(np.linalg.norm(np.diff(states, axis=0), axis=1).sum())


def finely(states: Array, spacing: float) -> Array:
    """States of a path (n, D) and others on the straight lines between them, at most `spacing` apart; (m, D)."""
    lengths = np.linalg.norm(np.diff(states, axis=0), axis=1)
    counts = np.maximum(1, np.ceil(lengths / spacing)).astype(int)
    at = np.concatenate([i + np.arange(n) / n for i, n in enumerate(counts)] + [[len(counts)]])
    return np.column_stack([np.interp(at, np.arange(len(states)), column) for column in states.T])


def _walk(before: Indices, last: int) -> list[int]:
    """Nodes from the first to the last."""
    nodes = [last]
    while before[nodes[-1]] >= 0:
        nodes.append(int(before[nodes[-1]]))
    return nodes[::-1]
