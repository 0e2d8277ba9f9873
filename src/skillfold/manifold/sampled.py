"""Paths around obstacles by sampling: trees on the manifold, shortcuts, then the same path made smooth."""

from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.check import MOST
from skillfold.manifold.terrain import Terrain

Array = np.ndarray[Any, np.dtype[np.float64]]

STEP = 0.15  # rms radii between nodes of a tree
TARGETS = (400, 2000, 2000, 2000)  # toward which trees grow, before they start anew
ROOM = 4000  # nodes of both trees together
SHORTCUTS, MORE_SHORTCUTS = 30, 150  # tried before a path is made smooth, and where it cannot be
COARSE = (24, 48, 96)  # states of the path that is made smooth, the more where the fewer do not keep clear
SMOOTH_STEPS, SMOOTHED = 40, 2e-3  # of the smoothing at most, and its last step in rms radii
RENEWING = (10, 15, 15, 30)  # steps with which an earlier path is bent, and more where they do not suffice
MENDING = 8  # the same with more states, which mend what the fewer left between them
CAP = 0.3  # longest step of a state, rms radii


@dataclass(frozen=True)
class Found:
    """A clear path and how it was found.

    Attributes:
        path: (n, D) whole coordinates; empty where there is none.
        iterations: targets of the trees and steps of the smoothing.
        smooth: whether it could be made smooth; else it is the shortened way of the trees.
        seconds: until the first clear path was there.
    """

    path: Array
    iterations: int
    smooth: bool
    seconds: float


def sampled_path(terrain: Terrain, ends: Array, spacing: float, seed: int) -> Found:
    """A clear path between ends (2, D), with states no farther apart than `spacing`; whole coordinates.

    Where none is found, or it cannot be read as a path on the surface, other samples are drawn.
    """
    begun, tried = perf_counter(), 0
    rng = np.random.default_rng(seed)
    seconds = None
    for count in TARGETS:
        first, used = terrain.connected(ends, draw_targets(terrain, rng, count), STEP, ROOM)
        tried += used
        if not len(first):
            continue
        seconds = perf_counter() - begun if seconds is None else seconds
        short = terrain.shortened(first, rng.random((SHORTCUTS, 2)), STEP)
        path, iterations = smoothed(terrain, short, spacing)
        tried += iterations
        if len(path):
            return Found(path, tried, True, seconds)
        shorter = terrain.shortened(short, rng.random((MORE_SHORTCUTS, 2)), STEP)
        path = _as_it_is(terrain, (shorter, short, first), spacing)
        if len(path):
            return Found(path, tried, False, seconds)
    return Found(np.empty((0, ends.shape[1])), tried, False, seconds or perf_counter() - begun)


def _as_it_is(terrain: Terrain, ways: tuple[Array, ...], spacing: float) -> Array:
    """The first of the ways that is clear on the surface between its states too, dense; empty where none is."""
    for way in ways:
        path, settled = terrain.settled(way, states_for(way, spacing), smooth=False)
        if settled and terrain.is_clear(path, 0.0) and terrain.holds(path):
            return path
    return np.empty((0, ways[0].shape[1]))


def draw_targets(terrain: Terrain, rng: np.random.Generator, count: int) -> Array:
    """States between neighbouring anchors, and anywhere within the samples' extent along free directions."""
    model = terrain.model
    edges = model.edges[rng.integers(len(model.edges), size=count)]
    share = rng.random((count, 1))
    inner = model.anchors[edges[:, 0]] + share * (model.anchors[edges[:, 1]] - model.anchors[edges[:, 0]])
    extent = model.free_extent / model.scale
    return np.hstack([inner, rng.uniform(-extent, extent, (count, len(extent)))])


def smoothed(terrain: Terrain, rough: Array, spacing: float) -> tuple[Array, int]:
    """The rough path made short and smooth, dense and clear; empty where that fails, and the steps it took.

    Where it leads far out it is held within the edge of the demonstrations, if that keeps clear too.
    """
    total = 0
    for count in COARSE:
        coarse, _ = terrain.settled(rough, count, smooth=False)
        bent, iterations = _bent(terrain, coarse, SMOOTH_STEPS)
        total += iterations
        path = _read_smoothly(terrain, bent, spacing)
        if terrain.leads_out(bent):
            bent, iterations = _bent(terrain, bent, SMOOTH_STEPS, True)
            total += iterations
            held = _read_smoothly(terrain, bent, spacing) if iterations else path
            path = held if len(held) else path
        if len(path):
            return path, total
    return np.empty((0, rough.shape[1])), total


def renewed(terrain: Terrain, earlier: Array, spacing: float) -> tuple[Array, int]:
    """The same of an earlier path, which few states and mostly few steps make clear again.

    Where those states keep clear but not the way between them, it takes more states; else more steps. What is clear
    then, if by less than the margin, is kept as well: it leads on at once.
    """
    bent, total = terrain.settled(earlier, COARSE[0], smooth=False)[0], 0
    for limit in RENEWING:
        bent, iterations = _bent(terrain, bent, limit)
        total += iterations
        if terrain.keeps_clear(bent):
            path = _read_smoothly(terrain, bent, spacing)
            if len(path):
                return path, total
            bent, iterations = _bent(terrain, terrain.settled(bent, COARSE[1], smooth=True)[0], MENDING)
            total += iterations
            break
    return _read_smoothly(terrain, bent, spacing, 0.0), total


def _bent(terrain: Terrain, coarse: Array, limit: int, held: bool = False) -> tuple[Array, int]:
    bent, iterations, _ = terrain.bent(coarse, terrain.obstacles.margin, CAP, SMOOTHED, limit, held)
    return bent, iterations


def _read_smoothly(terrain: Terrain, coarse: Array, spacing: float, margin: float | None = None) -> Array:
    """The smooth path through few states, dense; empty where it keeps no margin, the terrain's unless given."""
    path, settled = terrain.settled(coarse, states_for(coarse, spacing), smooth=True)
    return path if settled and terrain.is_clear(path, margin) and terrain.holds(path) else path[:0]


def states_for(path: Array, spacing: float) -> int:
    """How many states a path needs for that spacing; no more than the check looks at."""
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    return int(np.clip(np.ceil(1.02 * length / spacing) + 1, 4, MOST))
