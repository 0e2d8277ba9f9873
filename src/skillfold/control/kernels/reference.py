"""References as knots: evaluated between them, and spliced to the motion under way.

Knots are (n, 3, D): position, velocity and acceleration at even times. Between two of them lies the quintic that
meets both, so the whole is twice continuously differentiable.
"""

import math
from typing import Any

import numpy as np

from skillfold.jit import njit

Array = np.ndarray[Any, np.dtype[np.float64]]

GROWTH = 1.25  # of a splice that breaks the limits
TRIES = 14


@njit
def evaluate(knots: Array, step: float, time: float, out: Array) -> None:
    """Position, velocity and acceleration (3, D) at a time [s]; at rest before the first and after the last knot."""
    last = knots.shape[0] - 1
    u = min(max(time / step, 0.0), float(last))
    k = min(int(u), last - 1)
    u -= k
    for c in range(knots.shape[2]):
        x, v, a = knots[k, 0, c], step * knots[k, 1, c], 0.5 * step * step * knots[k, 2, c]
        end_v, end_a = step * knots[k + 1, 1, c], 0.5 * step * step * knots[k + 1, 2, c]
        # What the parabola from the left leaves undone at the right end.
        p, r, s = knots[k + 1, 0, c] - x - v - a, end_v - v - 2.0 * a, end_a - a
        e = 10.0 * p - 4.0 * r + s
        f = -15.0 * p + 7.0 * r - 2.0 * s
        g = 6.0 * p - 3.0 * r + s
        out[0, c] = x + u * (v + u * (a + u * (e + u * (f + u * g))))
        out[1, c] = (v + u * (2.0 * a + u * (3.0 * e + u * (4.0 * f + u * 5.0 * g)))) / step
        out[2, c] = (2.0 * a + u * (6.0 * e + u * (12.0 * f + u * 20.0 * g))) / (step * step)


@njit
def brake(state: Array, duration: float, time: float, out: Array) -> None:
    """From a state (3, D) on to rest after `duration`: position, velocity, acceleration (3, D) at `time` before it.

    The polynomial from the state to rest where half the duration at its velocity would take it.
    """
    T, u = duration, time / duration
    for c in range(state.shape[1]):
        x, v, a = state[0, c], T * state[1, c], 0.5 * T * T * state[2, c]
        p, r, s = -0.5 * v - a, -v - 2.0 * a, -a
        e = 10.0 * p - 4.0 * r + s
        f = -15.0 * p + 7.0 * r - 2.0 * s
        g = 6.0 * p - 3.0 * r + s
        out[0, c] = x + u * (v + u * (a + u * (e + u * (f + u * g))))
        out[1, c] = (v + u * (2.0 * a + u * (3.0 * e + u * (4.0 * f + u * 5.0 * g)))) / T
        out[2, c] = (2.0 * a + u * (6.0 * e + u * (12.0 * f + u * 20.0 * g))) / (T * T)


@njit
def excess(state: Array, velocity: Array, acceleration: Array) -> float:
    """Largest share of the limits (D,) that a state (3, D) takes: above 1 it breaks one."""
    worst = 0.0
    for c in range(velocity.size):
        worst = max(worst, abs(state[1, c]) / velocity[c], abs(state[2, c]) / acceleration[c])
    return worst


@njit
def mix(knots: Array, step: float, state: Array, duration: float, k: int, work: Array, out: Array) -> None:
    """Knot k (3, D) of what leads from a state (3, D) to the reference within `duration`; work (3, D)."""
    u = k * step / duration
    T = duration
    w = u * u * u * (10.0 + u * (6.0 * u - 15.0))
    dw = 30.0 * u * u * (1.0 - u) * (1.0 - u) / T
    ddw = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (T * T)
    brake(state, duration, k * step, work)
    for c in range(state.shape[1]):
        gap, slip = knots[k, 0, c] - work[0, c], knots[k, 1, c] - work[1, c]
        out[0, c] = work[0, c] + w * gap
        out[1, c] = work[1, c] + w * slip + dw * gap
        out[2, c] = work[2, c] + w * (knots[k, 2, c] - work[2, c]) + 2.0 * dw * slip + ddw * gap


@njit
def splice(
    knots: Array, step: float, state: Array, shortest: float, velocity: Array, acceleration: Array, work: Array
) -> float:
    """Lead from a state (3, D) over to a reference (changed in place) with weights that are smooth in time.

    Takes `shortest` seconds, or as many as keep the limits (D,): what the ends ask for is a bound that none could
    keep. All knots but the last must be free to change. Work (2, 3, D). Returns the seconds taken.
    """
    longest = (knots.shape[0] - 1) * step
    duration, best, least = min(shortest, longest), min(shortest, longest), math.inf
    for _ in range(TRIES):
        worst = 0.0
        for k in range(1, math.ceil(duration / step)):
            mix(knots, step, state, duration, k, work[0], work[1])
            worst = max(worst, excess(work[1], velocity, acceleration))
        if worst < 0.999 * least:
            best, least = duration, worst
        if worst <= 1.0 or duration >= longest:
            break
        duration = min(GROWTH * duration, longest)
    for k in range(math.ceil(best / step)):
        mix(knots, step, state, best, k, work[0], work[1])
        for i in range(3):
            for c in range(velocity.size):
                knots[k, i, c] = work[1, i, c]
    return best
