"""Penalties that push the states of a path off obstacles and limits."""

from typing import Any

import numpy as np

from skillfold.jit import inlined, inner
from skillfold.manifold.kernels.small import norm
from skillfold.manifold.kernels.walking import Chart, to_slope
from skillfold.planning.barrier import Barrier, within_at

Array = np.ndarray[Any, np.dtype[np.float64]]

STIFF = 10.0  # of a penalty, where the spring between neighbouring states has 1
# Of a limit: an obstacle asks for more room than it must have, a limit for hardly any, and between them it must win.
STIFF_LIMIT = 100.0
BLUNT = 0.1  # of the steepest gradient: flatter ones are not taken for an infinite depth
SIGHT = 3.0  # margins, up to which clearance is told
INSET = 0.005  # rms radii that a path keeps from limits


@inlined
def push_off_obstacles(
    chart: Chart,
    barrier: Barrier,
    state: Array,
    normal: Array,
    tangents: Array,
    margin: float,
    steepest: float,
    distances: Array,
    gradients: Array,
    slope: Array,
    stiffness: Array,
    force: Array,
) -> tuple:
    """Penalties ½ STIFF ((margin − c) / ‖∇c‖)² at one state (D,), along its tangents (d, D), added to what is there.

    A clearance over its gradient is a way in the space of states, whatever it was measured in. Returns the least
    clearance, SIGHT margins at most, and the steepest gradient seen so far.
    """
    least = SIGHT * margin
    count = max(within_at(barrier.within)(state, least, distances, gradients, barrier.arguments), 0)
    for p in range(count):
        least = min(least, distances[p])
        to_slope(chart, gradients[p], slope)
        steepest = max(steepest, norm(slope))
        if distances[p] < margin:
            add_push(slope, margin - distances[p], steepest, STIFF, normal, tangents, stiffness, force)
    return least, steepest


@inlined
def push_off_limits(
    chart: Chart, state: Array, normal: Array, tangents: Array, slope: Array, stiffness: Array, force: Array
) -> None:
    """The same for the limits of coordinates."""
    for c in range(state.size):
        over = state[c] - chart.upper[c] + INSET * chart.scale
        under = chart.lower[c] - state[c] + INSET * chart.scale
        if max(over, under) > 0.0:
            for k in range(state.size):
                slope[k] = chart.scale * chart.axes[k, c] * (-1.0 if over > under else 1.0)
            add_push(slope, max(over, under), 0.0, STIFF_LIMIT, normal, tangents, stiffness, force)


@inner
def add_push(
    slope: Array,
    depth: float,
    steepest: float,
    stiff: float,
    normal: Array,
    tangents: Array,
    stiffness: Array,
    force: Array,
) -> None:
    """One penalty of a depth with this gradient (D,), into stiffness (d, d) and force (d,)."""
    d, D = tangents.shape
    weight, ahead = 0.0, 0.0
    for c in range(D):
        weight += slope[c] ** 2
        ahead += slope[c] * normal[c]
    weight = stiff / max(weight, (BLUNT * steepest) ** 2, 1e-300)
    for a in range(d):
        s = 0.0
        for c in range(D):
            s += tangents[a, c] * slope[c]
        force[a] += weight * s * (depth + ahead)
        for b in range(d):
            t = 0.0
            for c in range(D):
                t += tangents[b, c] * slope[c]
            stiffness[a, b] += weight * s * t
