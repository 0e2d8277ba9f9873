"""Anchored Newton: from points near the surface to its closest points to states."""

import math
from typing import Any

import numpy as np

from skillfold.jit import inlined, inner
from skillfold.manifold.kernels.scratch import Scratch, evaluate
from skillfold.manifold.kernels.surface import Flags
from skillfold.manifold.kernels.tangents import keep_tangential
from skillfold.tables import Indices

Array = np.ndarray[Any, np.dtype[np.float64]]

SLOWEST = 0.05  # rate of the step along the surface: where even that leaves the support, its edge is met
RETREAT = 0.3  # of the rate, where a step left the support
SURELY = 0.5  # of the tolerance: a step that by the last ones' shrinking leaves less is not looked at again
BACK_STEPS = 20  # straight onto the surface, at the end


@inner
def descend(
    farthest: float,
    most_doubt: float,
    cap: float,
    states: Array,
    points: Array,
    tolerance: float,
    steps: float,
    scratch: Scratch,
) -> Flags:
    """Anchored Newton from points (n, D; changed in place) to the surface's closest points to states (n, D).

    Each step goes along the surface toward the state and straight back onto it; both parts are capped. The step
    along shrinks where it overshoots, and where it would go `farthest` from the anchors or where these disagree by
    `most_doubt`: then it is taken again, shorter, and where it cannot be, the answer is the edge of that. While the
    steps get shorter, how the last two differ tells where all would end (Anderson's acceleration, one step back).
    Ends with steps straight back. All go on at once; those that have arrived drop out. Returns whether each met the
    surface (n,).
    """
    n, D = states.shape
    met, begun = np.zeros(n, np.bool_), np.zeros(n, np.bool_)
    rate, before, pulls, backs = np.ones(n), np.full(n, np.inf), np.empty(n), np.empty(n)
    previous, along, across = np.zeros((n, D)), np.zeros((n, D)), np.zeros((n, D))
    turned, share = np.empty(D), 0.0
    active, left = np.arange(n), n
    for _ in range(int(steps)):
        here = points[active[:left]]
        toward = states[active[:left]] - here
        evaluate(here, scratch)
        keep_tangential(scratch.bases, toward, scratch.along)
        going = 0
        for j in range(left):
            i = active[j]
            outside = scratch.squares[j, 0] > farthest**2 or scratch.doubts[j] > most_doubt
            if outside and begun[i]:
                shorter = shortened(rate[i], cap / pulls[i])
                if shorter == rate[i]:
                    for c in range(D):
                        points[i, c] = previous[i, c]
                    continue
                rate[i], share = shorter, 0.0
            else:
                off, pull, turn, turns = 0.0, 0.0, 0.0, 0.0
                for c in range(D):
                    step = toward[j, c] - scratch.normals[j, c]
                    change = step - (along[i, c] - across[i, c])
                    turn += step * change
                    turns += change**2
                    turned[c] = change + here[j, c] - previous[i, c]
                    previous[i, c], along[i, c], across[i, c] = here[j, c], toward[j, c], scratch.normals[j, c]
                    off += across[i, c] ** 2
                    pull += along[i, c] ** 2
                off, pull = math.sqrt(off), math.sqrt(pull)
                met[i] = off < tolerance and rate[i] * pull < tolerance
                if met[i]:
                    continue
                ratio = (off + pull) / before[i]  # 0 at the first point
                if ratio > 0.7:
                    rate[i] = max(0.6 * rate[i], SLOWEST)
                elif ratio < 0.5:
                    rate[i] = min(1.25 * rate[i], 1.0)
                shrinks = 0.0 < ratio < 0.5
                met[i] = shrinks and ratio * (off + pull) < SURELY * tolerance
                share = turn / turns if shrinks and rate[i] == 1.0 and off + pull < cap else 0.0
                before[i], begun[i] = off + pull, True
                pulls[i], backs[i] = max(pull, 1e-300), min(1.0, cap / max(off, 1e-300))
            forth = min(rate[i], cap / pulls[i])
            for c in range(D):
                straight = previous[i, c] + forth * along[i, c] - backs[i] * across[i, c]
                points[i, c] = straight - share * turned[c]
            if not met[i]:
                carry(scratch, j, going)
                active[going] = i
                going += 1
        left = going
        if left == 0:
            break
    step_back(points, tolerance, scratch, met)
    return met


@inner
def shortened(rate: float, most: float) -> float:
    """A smaller rate that makes a step shorter, which is `most` of the way at most; the same where there is none."""
    shorter = rate
    while shorter > SLOWEST and min(shorter, most) == min(rate, most):
        shorter = max(RETREAT * shorter, SLOWEST)
    return shorter if min(shorter, most) < min(rate, most) else rate


@inlined
def step_back(points: Array, tolerance: float, scratch: Scratch, met: Flags) -> None:
    """Straight from points (n, D; changed in place) to their feet, those left out that have `met` the surface."""
    active = np.flatnonzero(~met)
    left = len(active)
    for _ in range(BACK_STEPS):
        if left == 0:
            break
        here = points[active[:left]]
        evaluate(here, scratch)
        going = 0
        for j in range(left):
            i = active[j]
            off = 0.0
            for c in range(points.shape[1]):
                off += scratch.normals[j, c] ** 2
            if off < tolerance**2:
                met[i] = True
                continue
            for c in range(points.shape[1]):
                points[i, c] -= scratch.normals[j, c]
            carry(scratch, j, going)
            active[going] = i
            going += 1
        left = going


@inlined
def carry(scratch: Scratch, i: int, j: int) -> None:
    """State i goes on as state j: what is known of the anchors around it goes along."""
    if i != j:
        for k in range(scratch.around.shape[1]):
            scratch.around[j, k] = scratch.around[i, k]
        for c in range(scratch.origins.shape[1]):
            scratch.origins[j, c] = scratch.origins[i, c]
        scratch.known[j] = scratch.known[i]


@inlined
def begin_at(neighbours: Indices, scratch: Scratch, i: int, anchor: int) -> None:
    """State i begins at an anchor: its neighbours (see `Surface`) are looked at first."""
    scratch.known[i] = 0.0
    if neighbours.shape[1]:
        for k in range(scratch.around.shape[1]):
            scratch.around[i, k] = neighbours[anchor, k]
