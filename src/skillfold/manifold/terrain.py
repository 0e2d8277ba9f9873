"""A learnt manifold among obstacles, as the compiled loops want it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.check import sag
from skillfold.clearance import Clearance, Compiled
from skillfold.manifold.kernels.detours import bend_clear, first_blocked, settle_path
from skillfold.manifold.kernels.geodesic import refine, resample
from skillfold.manifold.kernels.trees import search
from skillfold.manifold.kernels.walking import Chart, Support
from skillfold.manifold.model import Model
from skillfold.manifold.projection import FAR, OnManifold, usual
from skillfold.planning.barrier import Barrier, barrier_of
from skillfold.spaces import StateSpace

Array = np.ndarray[Any, np.dtype[np.float64]]

FARTHEST = 3.0  # spacings of the samples: trees do not go farther from the nearest anchor, unless the ends do


@dataclass(frozen=True, eq=False)
class Terrain:
    """The surface with what stands in the way.

    Whole coordinates (D,): those of the surface, then the free directions; scaled and turned, lengths as `model`'s
    inner ones.

    Attributes:
        model: the manifold.
        obstacles: what to keep clear of.
        margin: clearance that edges keep; in the obstacles' own unit.
        chart, barrier, support: for the compiled loops.
        compiled: what `barrier` points to.
    """

    model: Model
    obstacles: Clearance
    margin: float
    chart: Chart
    barrier: Barrier
    support: Support
    compiled: Compiled

    @classmethod
    def between(cls, model: Model, space: StateSpace, obstacles: Clearance, ends: Array, margin: float) -> "Terrain":
        """The terrain for paths between ends (2, D), which may lie farther out than is usual."""
        compiled = obstacles.compiled()
        lower, upper = obstacles.bounds
        axes = np.ascontiguousarray(np.hstack([model.kept, model.free]).T)
        chart = Chart(
            model.centre,
            model.scale,
            axes,
            np.maximum(lower, np.array(space.lower)),
            np.minimum(upper, np.array(space.upper)),
        )
        gaps = ((model.encode(ends)[:, None] - model.anchors[None]) ** 2).sum(2).min(1)
        farthest = max((FARTHEST * model.trust.spacing) ** 2, 2.0 * float(gaps.max()))
        support = Support(farthest, model.trust.ghost)
        return cls(model, obstacles, margin, chart, barrier_of(compiled), support, compiled)

    @property
    def _surface(self) -> tuple[Any, Support, Chart, Barrier]:
        return self.model.table, self.support, self.chart, self.barrier

    def coordinates(self, states: Array) -> Array:
        """Whole coordinates (..., D) of states (..., D)."""
        return ((states - self.chart.centre) @ self.chart.axes.T) / self.chart.scale

    def states(self, coordinates: Array) -> Array:
        """The reverse."""
        return self.chart.centre + self.chart.scale * coordinates @ self.chart.axes

    def connected(self, ends: Array, targets: Array, step: float, room: int) -> tuple[Array, int]:
        """A clear way of tree nodes between ends (2, D), empty where none was found; and how many targets it took."""
        path = np.empty((room, ends.shape[1]))
        count, used = search(*self._surface, ends, targets, np.empty((0, 2)), step, self.margin, path, 0)
        return path[:count], used

    def shortened(self, path: Array, picks: Array, step: float) -> Array:
        """The path with shortcuts between the places that `picks` (r, 2) name."""
        path = path.copy()
        none = np.empty((0, path.shape[1]))
        count, _ = search(*self._surface, path[[0, -1]], none, picks, step, self.margin, path, len(path))
        return path[:count]

    def bent(
        self, path: Array, margin: float, cap: float, tolerance: float, limit: int, held: bool = False
    ) -> tuple[Array, int, bool]:
        """The path (n, D) made short and kept a margin clear; iterations, and whether it settled.

        Where it is `held`, it keeps within the edge of the demonstrations besides, if it would leave that.
        """
        bent = path.copy()
        table, _, chart, barrier = self._surface
        capacity = max(self.compiled.capacity, 1)
        how, spacing = (capacity, cap, tolerance, limit), self.model.trust.spacing if held else 0.0
        iterations, moved = bend_clear(table, chart, barrier, bent, margin, *how, spacing)
        return bent, int(iterations), bool(moved < tolerance)

    def leads_out(self, path: Array) -> bool:
        """Whether a path (n, D) leads farther from the demonstrations than is usual."""
        return bool(OnManifold(self.model).inside(self.states(path)).max() > FAR)

    def settled(self, path: Array, count: int, smooth: bool) -> tuple[Array, bool]:
        """The path (n, D) read at `count` places and brought onto the surface; whether that was met everywhere.

        At even lengths; a smooth path is read as a smooth curve, another one as straight pieces.
        """
        if smooth and len(path) >= 4:
            curve = np.empty((count, path.shape[1]))
            refine(path, curve)
            path = curve
        dense = np.empty((count, path.shape[1]))
        resample(path, dense)
        return dense, bool(settle_path(self.model.table, self.support, dense))

    def holds(self, path: Array) -> bool:
        """Whether the surface holds half-way between the states of a dense path (n, D), too, as a check will ask.

        At creases, as where a joint comes to its limit, and outside the demonstrations it may bend within a step.
        """
        states = self.states(path)
        between = 0.5 * (states[1:] + states[:-1])
        tolerance = usual(self.model)
        off = OnManifold(self.model, tolerance).distance(between) - sag(states, np.arange(0.5, len(between)))
        return bool(off.max() <= tolerance)

    def keeps_clear(self, path: Array) -> bool:
        """Whether the states of a path (n, D) do, whatever lies between them."""
        states = self.states(path[1:-1])
        within = np.all((states >= self.chart.lower) & (states <= self.chart.upper))
        return bool(within) and bool(np.all(self.obstacles.clearance(states) > self.margin))

    def first_blocked(self, path: Array, margin: float | None = None) -> int:
        """Where the first edge of a path (n, D) starts that does not keep the margin, by default its own; or -1."""
        return int(first_blocked(self.chart, self.barrier, path, self.margin if margin is None else margin))

    def blocking(self, path: Array, edge: int) -> str:
        """What an edge of a path (n, D) runs into, in words."""
        there = self.states(path[edge + 1])
        beyond = np.maximum(there - self.chart.upper, self.chart.lower - there)
        if beyond.max() > 0.0:
            return f"the limits of coordinate {int(beyond.argmax())}"
        return self.obstacles.nearest(self.states(path[edge]))

    def is_clear(self, path: Array, margin: float | None = None) -> bool:
        """Whether there is no such edge."""
        return self.first_blocked(path, margin) < 0
