"""References as knots: evaluated between them, and spliced to the motion under way.

Knots are (n, 3, D): position, velocity and acceleration at even times. Between two of them lies the quintic that
meets both, so the whole is twice continuously differentiable.
"""

import math
from typing import Any

import numpy as np

from skillfold.jit import njit

Array = np.ndarray[Any, np.dtype[np.float64]]

GROWTH = 1.4  # of the time of a splice that breaks the limits
LOOKED = 8  # places a step at which a reference is looked at
STILL = 1e-9  # velocity of a reference at rest


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
def overrun(knots: Array, step: float, velocity: Array, acceleration: Array, work: Array) -> float:
    """Largest share of the limits (D,) that a reference takes, also between its knots; work (3, D)."""
    found = 0.0
    for i in range(LOOKED * (knots.shape[0] - 1) + 1):
        evaluate(knots, step, step * i / LOOKED, work)
        found = max(found, excess(work, velocity, acceleration))
    return found


@njit
def mix(
    knots: Array, step: float, state: Array, duration: float, delay: int, k: int, work: Array, out: Array
) -> None:
    """Knot k (3, D) of what leads from a state (3, D) to the reference within `duration`; work (3, D).

    The reference begins after `delay` knots; before, it rests where it begins.
    """
    T, u = duration, min(k * step / duration, 1.0)
    w = u * u * u * (10.0 + u * (6.0 * u - 15.0))
    dw = 30.0 * u * u * (1.0 - u) * (1.0 - u) / T
    ddw = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (T * T)
    brake(state, duration, u * T, work)
    late, moving = max(k - delay, 0), 1.0 if k >= delay else 0.0
    for c in range(state.shape[1]):
        gap, slip = knots[late, 0, c] - work[0, c], moving * knots[late, 1, c] - work[1, c]
        bend = moving * knots[late, 2, c] - work[2, c]
        out[0, c] = work[0, c] + w * gap
        out[1, c] = work[1, c] + w * slip + dw * gap
        out[2, c] = work[2, c] + w * bend + 2.0 * dw * slip + ddw * gap


@njit
def worst(
    knots: Array,
    step: float,
    state: Array,
    duration: float,
    delay: int,
    velocity: Array,
    acceleration: Array,
    work: Array,
) -> float:
    """Largest share of the limits (D,) that a splice takes; work (2, 3, D)."""
    found = 0.0
    for k in range(1, math.ceil(duration / step)):
        mix(knots, step, state, duration, delay, k, work[0], work[1])
        found = max(found, excess(work[1], velocity, acceleration))
    return found


@njit
def splice(
    knots: Array,
    step: float,
    state: Array,
    shortest: float,
    spare: int,
    velocity: Array,
    acceleration: Array,
    work: Array,
) -> tuple[float, int]:
    """Lead from a state (3, D) over to a reference (changed in place) with weights that are smooth in time.

    Takes `shortest` seconds, or as many as keep the limits (D,); if that does not help, a reference that begins at
    rest begins later. Of all that break a limit, the one that does so least. Work (2, 3, D); the last `spare` knots
    may be lost to a delay. Returns the seconds taken, and the knots by which the reference begins later.
    """
    speed = 0.0
    for c in range(velocity.size):
        speed = max(speed, abs(knots[0, 1, c]))
    longest = max(spare * step, shortest)
    duration, best, delay, least = shortest, shortest, 0, math.inf
    while least > 1.0 and duration <= longest:
        for late in range(3):
            wait = int(0.5 * late * duration / step) if speed < STILL else 0
            share = worst(knots, step, state, duration, wait, velocity, acceleration, work)
            if share < 0.999 * least:
                best, delay, least = duration, wait, share
            if least <= 1.0 or (wait == 0 and late > 0):
                break
        duration *= GROWTH
    count = math.ceil(best / step)
    for k in range(knots.shape[0] - 1, -1, -1):  # from the last on: what is read was not written yet
        source = knots[k - delay]
        if k < count:
            mix(knots, step, state, best, delay, k, work[0], work[1])
            source = work[1]
        for i in range(3):
            for c in range(velocity.size):
                knots[k, i, c] = source[i, c]
    return best, delay
