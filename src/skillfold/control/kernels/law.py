"""The law of control: what of a vector lies across the manifold, feedback with two stiffnesses, limits."""

import math
from typing import Any

import numpy as np

from skillfold.jit import njit

Array = np.ndarray[Any, np.dtype[np.float64]]

QUICK = 0.02  # seconds in which a velocity that nears its limit is turned


@njit
def across(kept: Array, basis: Array, vector: Array, work: Array, out: Array) -> None:
    """What of a vector (D,) lies across the tangent space, into `out`.

    Args:
        kept: (D, E) orthonormal columns, the directions that are modelled; along all others everything is allowed.
        basis: (d, E) orthonormal rows, the tangents among them.
        vector: (D,).
        work: (E,).
        out: (D,).
    """
    D, E = kept.shape
    for e in range(E):
        s = 0.0
        for c in range(D):
            s += kept[c, e] * vector[c]
        work[e] = s
    for a in range(basis.shape[0]):
        s = 0.0
        for e in range(E):
            s += basis[a, e] * work[e]
        for e in range(E):
            work[e] -= s * basis[a, e]
    for c in range(D):
        s = 0.0
        for e in range(E):
            s += kept[c, e] * work[e]
        out[c] = s


@njit
def stiffness(base: float, most: float, reach: float, distance: float) -> float:
    """ω² [1/s²] of the pull onto the manifold, which grows with the distance from it (section IV-D)."""
    return base * (1.0 + (most - 1.0) * min(distance / reach, 1.0))


@njit
def eased(pull: float, calm: float, most: float) -> tuple[float, float]:
    """ω² and 2ζω, the latter held to `most` with the same ζ."""
    share = min(most / calm, 1.0)
    return share * share * pull, share * calm


@njit
def feedback(
    gains: Array, off: Array, along: Array, off_speed: Array, along_speed: Array, most: float, out: Array
) -> None:
    """Acceleration (D,) against errors off and along the manifold and their velocities, all (D,).

    Gains: ω² and 2ζω along, then ω², ζ, the most that it grows by, and the distance at which it has, off. Neither
    2ζω is larger than `most`: one over the time until the next answer, in which a velocity then dies at most.
    """
    square = 0.0
    for c in range(off.size):
        square += off[c] ** 2
    pull = stiffness(gains[2], gains[4], gains[5], math.sqrt(square))
    pull, calm = eased(pull, 2.0 * gains[3] * math.sqrt(pull), most)
    lead, drag = eased(gains[0], gains[1], most)
    for c in range(off.size):
        out[c] = -lead * along[c] - drag * along_speed[c] - pull * off[c] - calm * off_speed[c]


@njit
def bound(vector: Array, limit: Array) -> None:
    """Shorten a vector (D,) until it keeps the limits (D,)."""
    share = 1.0
    for c in range(vector.size):
        if abs(vector[c]) > limit[c]:
            share = min(share, limit[c] / abs(vector[c]))
    for c in range(vector.size):
        vector[c] *= share


@njit
def restrain(
    q: Array,
    qd: Array,
    lower: Array,
    upper: Array,
    velocity: Array,
    rise: Array,
    reaction: Array,
    interval: float,
    out: Array,
) -> None:
    """Bound an acceleration (D,) so that velocities keep their limit, and let a stop before the ends of the range.

    All (D,); `rise` is what braking may take, `reaction` the most there is; `interval` [s] between answers.
    """
    quick = max(QUICK, interval)
    for c in range(q.size):
        top = min(velocity[c], math.sqrt(2.0 * rise[c] * max(upper[c] - q[c], 0.0)))
        bottom = min(velocity[c], math.sqrt(2.0 * rise[c] * max(q[c] - lower[c], 0.0)))
        most = max((top - qd[c]) / quick, -reaction[c])
        least = min((-bottom - qd[c]) / quick, reaction[c])
        out[c] = min(max(min(max(out[c], least), most), -reaction[c]), reaction[c])
