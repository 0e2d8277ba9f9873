"""The independent check that every path passes before a plan may say success.

It knows a constraint and obstacles only by what they can do: `judge` and `clearance` of states. It is told nothing
of how the path was found.
"""

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from skillfold.clearance import Clearance
from skillfold.motion import is_finite
from skillfold.spaces import StateSpace
from skillfold.worst import worst_places

Array = np.ndarray[Any, np.dtype[np.float64]]

OUTSIDE = 4.0  # times the usual distance to the demonstrations: a path farther out is not supported by them
JUMP = 5.0  # times the mean step: a longer one is no continuous motion
MOST = 20_000  # states that are looked at between those of a path; a longer one is looked at less closely
NO_END = np.full(1, np.inf)  # clearance where there is nothing to be clear of
SAG = 0.125  # of a second difference, and of its change: how far the chord of a smooth curve lies off it, half-way


class Constraint(Protocol):
    """Anything learnt or written by hand that can judge states."""

    def judge(self, states: Array, /) -> tuple[Any, Any]:
        """Two numbers for each of the states (n, D).

        Its distance from the constraint's surface, (n,), and how far outside the demonstrations it lies, (n,): 1 at
        the edge of what is usual.
        """
        ...


class Check(NamedTuple):
    """Verdict on a path, with the worst place and value of each condition.

    Places are states' indices; with obstacles a path is looked at between its states too, and 2.5 is half-way from
    state 2 to the next.

    Attributes:
        ok: whether every condition holds.
        reason: the first that does not, in words; empty where all hold.
        residual, residual_at: largest distance from the surface and the place that has it; between states, where it
            exceeds most what chords may be off.
        outside, outside_at: farthest outside the demonstrations, and where.
        length: of the path, in straight steps.
        jump, jump_at: longest step in mean steps, and where it starts.
        clearance, clearance_at: smallest clearance, and where; infinite without obstacles.
    """

    ok: bool
    reason: str
    residual: float
    residual_at: float
    outside: float
    outside_at: float
    length: float
    jump: float
    jump_at: int
    clearance: float = np.inf
    clearance_at: float = 0.0


def check_path(
    states: Array,
    constraint: Constraint,
    tolerance: float,
    space: StateSpace,
    still: float = 0.0,
    obstacles: Clearance | None = None,
) -> Check:
    """Check residual, support, continuity, limits and clearance of a path (n, D).

    A path may lead four times as far outside the demonstrations as is usual, or half as far again as its ends, where
    the user put these outside.

    Args:
        states: the path.
        constraint: what the path should hold.
        tolerance: largest distance from its surface. Between states that a user asked to lie far apart, straight
            chords may leave it by as much as the path bends there.
        space: coordinates and their limits.
        still: a step this short is no jump, however short the others are: a path that stays where it is steps from
            its given ends onto the surface and back.
        obstacles: what the path should keep clear of, also between its states, at their resolution.
    """
    if not is_finite(states):
        return _broken()
    looked, places = (states, range(len(states))) if obstacles is None else _looked_at(states, obstacles)
    distance, outside = map(np.asarray, constraint.judge(looked))
    over = distance if obstacles is None else distance - sag(states, np.asarray(places))
    a, b, c, longest, length = worst_places(over, outside, states)
    jump = longest / max(length / (len(states) - 1), 1e-300)
    allowed = max(OUTSIDE, 1.5 * float(outside[0]), 1.5 * float(outside[-1]))
    clear = NO_END if obstacles is None else np.atleast_1d(obstacles.clearance(looked))
    broken = _breaks_limits(looked, space, obstacles)
    d = 0 if obstacles is None else int(clear.argmin())
    reason = ""
    if not over[a] <= tolerance:
        reason = f"State {places[a]:.4g} lies {distance[a]:.2g} off the manifold, more than {tolerance:.2g}."
    elif not outside[b] <= allowed:
        reason = f"State {places[b]:.4g} lies outside the demonstrations, {outside[b]:.1f} times as far as is usual."
    elif not (jump <= JUMP or longest <= still):
        reason = f"The path jumps after state {c}, {jump:.1f} times its mean step."
    elif broken is not None:
        reason = f"State {places[broken]:.4g} breaks the limits of its coordinates."
    elif obstacles is not None and not clear[d] > 0.0:
        reason = f"State {places[d]:.4g} is not clear: {obstacles.nearest(looked[d])}, {clear[d]:.2g}."
    worst = (float(distance[a]), float(places[a]), float(outside[b]), float(places[b]), length, jump, c)
    return Check(not reason, reason, *worst, float(clear[d]), float(places[d]))


def _broken() -> Check:
    reason = "The path has numbers that are not finite."
    return Check(False, reason, np.inf, 0, np.inf, 0, np.inf, np.inf, 0, -np.inf, 0)


def _breaks_limits(states: Array, space: StateSpace, obstacles: Clearance | None) -> int | None:
    """The first of finite states outside the limits of its space, or of the obstacles' bounds; None without one."""
    if space.is_flat and not space.is_bounded and obstacles is None:
        return None
    within = space.contains(states, 1e-6 if space.is_flat else 1e-3)
    if obstacles is not None:
        lower, upper = obstacles.bounds
        within = within & ((states >= lower - 1e-9) & (states <= upper + 1e-9)).all(1)
    return None if within.all() else int(within.argmin())


def _looked_at(states: Array, obstacles: Clearance) -> tuple[Array, Array]:
    """The states and others between them at the obstacles' resolution (m, D); and their places (m,)."""
    lengths = np.linalg.norm(np.diff(states, axis=0), axis=1)
    resolution = max(obstacles.resolution, float(lengths.sum()) / MOST)
    counts = np.maximum(np.ceil(lengths / resolution - 1e-9), 1).astype(int)
    edges = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(edges)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[edges]
    looked = states[edges] + share[:, None] * (states[edges + 1] - states[edges])
    return np.vstack([looked, states[-1:]]), np.append(edges + share, len(states) - 1.0)


def sag(states: Array, places: Array) -> Array:
    """How far chords may lie off a smooth curve through the states, at places (m,); zero at the states themselves."""
    if len(states) < 3:
        return np.zeros(len(places))
    bends = np.linalg.norm(states[2:] - 2.0 * states[1:-1] + states[:-2], axis=1)
    bends = np.concatenate([bends[:1], bends, bends[-1:]])
    # Between states a path bends more than at them by as much as that changes from one to the next.
    changes = np.pad(np.linalg.norm(np.diff(states, 3, axis=0), axis=1), 2)
    most = np.maximum(bends[:-1], bends[1:]) + sliding_window_view(changes, 3).max(1)
    edges = np.minimum(places.astype(int), len(states) - 2)
    share = places - edges
    return 4.0 * share * (1.0 - share) * SAG * most[edges]
