"""The neighbourhood graph over the samples: grown until it is one piece, temporal neighbours linked."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import KDTree

from skillfold.errors import DisconnectedError

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

GROWN = 4  # times the neighbours asked for, before parts are joined by their shortest links alone
TOO_LONG = 10.0  # times the median edge: a link this long joins parts that belong to different skills


@dataclass(frozen=True)
class Graph:
    """Undirected edges between neighbouring samples.

    Attributes:
        edges: (E, 2), each pair once, first < second.
        lengths: (E,).
        neighbors: how many each sample was given to start with.
    """

    edges: Indices
    lengths: Array
    neighbors: int

    @property
    def median(self) -> float:
        """ℓ, the typical distance between neighbours (section IV-A3)."""
        return float(np.median(self.lengths))

    def stride(self, n_samples: int) -> float:
        """Half of the shortest way that joins all samples is in steps longer than this.

        Where several samples stand about each place, most edges are short, and yet the way is from place to place.
        """
        steps = np.sort(minimum_spanning_tree(self.matrix(n_samples)).data)
        way = np.cumsum(steps)
        return float(steps[np.searchsorted(way, 0.5 * way[-1])])

    def matrix(self, n_samples: int) -> Any:
        """Sparse symmetric matrix of edge lengths."""
        i, j = self.edges.T
        half = coo_matrix((np.maximum(self.lengths, 1e-300), (i, j)), shape=(n_samples, n_samples))
        return (half + half.T).tocsr()


def _unique(pairs: Indices) -> Indices:
    low, high = np.minimum(*pairs.T), np.maximum(*pairs.T)
    count = int(high.max(initial=0)) + 1
    codes = np.sort(low * count + high)  # far faster than by rows
    unique = np.column_stack(np.divmod(codes[np.diff(codes, prepend=-1) > 0], count))
    return unique[unique[:, 0] != unique[:, 1]]


def nearest_pairs(points: Array, neighbors: int) -> Indices:
    """Each point with its nearest ones; (E, 2)."""
    found = np.asarray(KDTree(points).query(points, min(neighbors + 1, len(points)))[1])[:, 1:]
    return _unique(np.column_stack([np.repeat(np.arange(len(points)), found.shape[1]), found.ravel()]))


def temporal_pairs(groups: Indices) -> Indices:
    """Consecutive samples of the same recording."""
    first = np.flatnonzero(groups[1:] == groups[:-1])
    return np.column_stack([first, first + 1])


def _labels(edges: Indices, n: int) -> tuple[int, Indices]:
    matrix = coo_matrix((np.ones(len(edges)), edges.T), shape=(n, n))
    return connected_components(matrix, directed=False)


def _shortest_links(points: Array, labels: Indices, count: int) -> Indices:
    """The shortest pairs that would join all parts: a spanning tree over the parts."""
    parts = [np.flatnonzero(labels == part) for part in range(count)]
    trees = [KDTree(points[part]) for part in parts]
    gap = np.zeros((count, count))
    pair = np.zeros((count, count, 2), dtype=np.int64)
    for a in range(count):
        for b in range(a + 1, count):
            distance, index = map(np.asarray, trees[b].query(points[parts[a]]))
            best = int(distance.argmin())
            gap[a, b] = max(float(distance[best]), 1e-300)
            pair[a, b] = parts[a][best], parts[b][index[best]]
    a, b = minimum_spanning_tree(gap).nonzero()
    return pair[a, b]


def _describe(labels: Indices, groups: Indices | None) -> str:
    sizes = np.bincount(labels)
    names = []
    for part in np.argsort(-sizes)[:4]:
        where = f"{sizes[part]} samples"
        if groups is not None:
            members = ", ".join(str(g) for g in np.unique(groups[labels == part])[:6])
            where += f" (demonstrations {members})"
        names.append(where)
    return "; ".join(names)


def build_graph(
    points: Array,
    neighbors: int,
    groups: Indices | None = None,
    too_long: float = TOO_LONG,
    scale: float = 1.0,
) -> Graph:
    """Graph over points (N, D), grown until it is connected.

    Args:
        points: samples, recordings one after the other.
        neighbors: of each sample to start with.
        groups: (N,) number of each sample's recording, or None for a cloud without order.
        too_long: times the typical distance, the longest link that may join parts.
        scale: of the points, for messages: how long a unit of theirs is for the user.

    Raises:
        DisconnectedError: where only a longer link would make it one piece.
    """
    temporal = temporal_pairs(groups) if groups is not None else np.empty((0, 2), dtype=np.int64)
    most = min(GROWN * neighbors, len(points) - 1)
    k = min(neighbors, most)
    edges = first = _unique(np.vstack([nearest_pairs(points, k), temporal]))
    while (parts := _labels(edges, len(points))[0]) > 1 and k < most:
        k = min(k + max(2, k // 2), most)
        edges = _unique(np.vstack([nearest_pairs(points, k), temporal]))
    if parts > 1:
        edges = _join(points, first, groups, too_long, scale)
    lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    return Graph(edges, lengths, neighbors)


def _join(points: Array, edges: Indices, groups: Indices | None, too_long: float, scale: float) -> Indices:
    """Add the shortest links between the parts, unless one of them is too long."""
    count, labels = _labels(edges, len(points))
    links = _shortest_links(points, labels, count)
    gaps = np.linalg.norm(points[links[:, 0]] - points[links[:, 1]], axis=1)
    typical = _typical_gap(points, edges, groups)
    if gaps.max() > too_long * typical:
        raise DisconnectedError(
            f"The samples fall into {count} parts: {_describe(labels, groups)}. The widest gap is "
            f"{scale * gaps.max():.3g}, more than {too_long:g} times the typical distance {scale * typical:.3g}. "
            "Fit each part as a skill of its own, or record the motions between them."
        )
    return _unique(np.vstack([edges, links]))


def _typical_gap(points: Array, edges: Indices, groups: Indices | None) -> float:
    """Median edge; for recordings at least the median distance from one to another of them."""
    typical = float(np.median(np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)))
    if groups is None or len(np.unique(groups)) < 2:
        return typical
    others = [KDTree(points[groups != g]).query(points[groups == g])[0] for g in np.unique(groups)]
    return max(typical, float(np.median(np.concatenate(others))))


def align_frames(frames: Array, graph: Graph) -> Array:
    """Turn local tangent bases (N, D, d) so that neighbours agree: Procrustes along a spanning tree.

    The turn that brings a basis to its parent's is the same whatever way the parent itself is turned, so all are
    found at once, and multiplied up to the root over twice as many generations in each round.
    """
    _, parents = breadth_first_order(graph.matrix(len(frames)), 0, directed=False)
    ancestors = np.maximum(parents, 0)  # the root has none but itself
    turns = _nearest_turns(np.swapaxes(frames, 1, 2) @ frames[ancestors])
    turns[0] = np.eye(frames.shape[2])
    while ancestors.any():
        turns = turns @ turns[ancestors]
        ancestors = ancestors[ancestors]
    return frames @ turns


def _nearest_turns(matrices: Array) -> Array:
    """The orthogonal matrix nearest to each of (n, d, d): for curves, the sign of a number."""
    if matrices.shape[1] == 1:
        return np.where(matrices < 0.0, -1.0, 1.0)
    u, _, vt = np.linalg.svd(matrices)
    return u @ vt
