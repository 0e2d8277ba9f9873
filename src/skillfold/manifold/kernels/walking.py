"""Steps on the surface that keep clear of obstacles: what samplers and shortcuts are made of.

States here are scaled and turned but whole: the D - f inner coordinates, then the f that are free.
"""

from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import inner
from skillfold.manifold.kernels.projection import gap
from skillfold.manifold.kernels.scratch import Scratch, evaluate
from skillfold.manifold.kernels.small import copy, keep_along, norm
from skillfold.planning.barrier import Barrier, clearance_at, edge_at

Array = np.ndarray[Any, np.dtype[np.float64]]

SETTLE_STEPS = 12  # straight back onto the surface after a step along it
ON_SURFACE = 1e-7  # rms radii
FLAT = 0.2  # of a direction must lie along the surface, and of a step be gained, for a walk to go on


class Chart(NamedTuple):
    """How whole states become coordinates: state = centre + scale · Σ z_k axes_k.

    Attributes:
        centre: (D,).
        scale: rms radius of the samples.
        axes: (D, D) orthonormal rows; the last f are free directions.
        lower, upper: (D,) limits of the state's own coordinates.
    """

    centre: Array
    scale: float
    axes: Array
    lower: Array
    upper: Array


class Support(NamedTuple):
    """Where the surface is believed: squared distance to the nearest anchor, and disagreement of the anchors."""

    farthest: float
    doubt: float


@inner
def to_state(chart: Chart, z: Array, state: Array) -> None:
    """The state (D,) with coordinates z (D,)."""
    copy(chart.centre, state)
    for k in range(z.size):
        for c in range(z.size):
            state[c] += chart.scale * z[k] * chart.axes[k, c]


@inner
def to_slope(chart: Chart, gradient: Array, out: Array) -> None:
    """The derivative by z (D,) of what has this gradient (D,) by the state."""
    for k in range(out.size):
        s = 0.0
        for c in range(out.size):
            s += chart.axes[k, c] * gradient[c]
        out[k] = chart.scale * s


@inner
def in_limits(chart: Chart, state: Array) -> bool:
    """Whether all coordinates of a state (D,) are."""
    inside = True
    for c in range(state.size):
        inside = inside and chart.lower[c] <= state[c] <= chart.upper[c]
    return inside


@inner
def settle(support: Support, z: Array, row: Array, scratch: Scratch) -> bool:
    """Bring z (D,) straight onto the surface; whether it got there, where that is believed.

    The tangents there are left in `scratch.bases[0]`. `row` is (1, D - f) scratch.
    """
    inner = row[0]
    for k in range(inner.size):
        inner[k] = z[k]
    off = 1.0
    for _ in range(SETTLE_STEPS):
        evaluate(row, scratch)
        normal = scratch.normals[0]
        off = norm(normal)
        for k in range(inner.size):
            inner[k] -= normal[k]
        if off < ON_SURFACE:
            break
    for k in range(inner.size):
        z[k] = inner[k]
    return off < ON_SURFACE and scratch.squares[0, 0] < support.farthest and scratch.doubts[0] < support.doubt


@inner
def edge_is_clear(chart: Chart, barrier: Barrier, a: Array, b: Array, margin: float, work: Array) -> bool:
    """Whether the straight edge between coordinates a and b (D,) keeps the margin; `work` is (2, D)."""
    to_state(chart, a, work[0])
    to_state(chart, b, work[1])
    return in_limits(chart, work[1]) and edge_at(barrier.edge)(work[0], work[1], margin, barrier.arguments) >= 1.0


@inner
def seems_clear(chart: Chart, barrier: Barrier, a: Array, b: Array, margin: float, work: Array) -> bool:
    """The same at less cost: where that is much, for the state b alone."""
    if barrier.exact:
        return edge_is_clear(chart, barrier, a, b, margin, work)
    to_state(chart, b, work[1])
    return (
        in_limits(chart, work[1])
        and clearance_at(barrier.clearance)(work[1], work[0, :0], barrier.arguments) > margin
    )


@inner
def walk(
    support: Support,
    chart: Chart,
    barrier: Barrier,
    start: Array,
    target: Array,
    step: float,
    margin: float,
    out: Array,
    scratch: Scratch,
) -> tuple:
    """Walk along the surface from start straight toward target (D,), as far as the way is clear.

    Each step goes along the tangents and straight back onto the surface; it only has to seem clear. Returns how many
    states were written to `out` (…, D), the start not among them, and whether the target is then no farther than a
    step.
    """
    D, inner = start.size, scratch.normals.shape[1]
    here, direction = start.copy(), np.empty(D)
    row, work, within = np.empty((1, inner)), np.empty((2, D)), scratch.along
    if not settle(support, here, row, scratch):
        return 0, False
    copy(start, here)
    count = 0
    left = np.sqrt(gap(here, target))
    while left > step:
        if count == len(out):
            return count, False
        for c in range(D):
            direction[c] = target[c] - here[c]
        keep_along(scratch.bases[0], direction[:inner], within)
        length = norm(direction)
        if length < FLAT * left:
            return count, False
        there = out[count]
        for c in range(D):
            there[c] = here[c] + step / length * direction[c]
        if not settle(support, there, row, scratch):
            return count, False
        before, left = left, np.sqrt(gap(there, target))
        if left > before - FLAT * step or not seems_clear(chart, barrier, here, there, margin, work):
            return count, False
        copy(there, here)
        count += 1
    return count, True
