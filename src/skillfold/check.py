"""The independent check that every path passes before a plan may say success.

It knows a constraint only by what it can do: `judge` a batch of states. It is told nothing of how the path was found.
"""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from skillfold.spaces import StateSpace

Array = np.ndarray[Any, np.dtype[np.float64]]

OUTSIDE = 4.0  # times the usual distance to the demonstrations: a path farther out is not supported by them
JUMP = 5.0  # times the mean step: a longer one is no continuous motion


class Constraint(Protocol):
    """Anything learnt or written by hand that can judge states."""

    def judge(self, states: Array, /) -> tuple[Any, Any]:
        """Two numbers for each of the states (n, D).

        Its distance from the constraint's surface, (n,), and how far outside the demonstrations it lies, (n,): 1 at
        the edge of what is usual.
        """
        ...


@dataclass(frozen=True)
class Check:
    """Verdict on a path, with the worst place and value of each condition.

    Attributes:
        ok: whether every condition holds.
        reason: the first that does not, in words; empty where all hold.
        residual, residual_at: largest distance from the surface and the index of the state that has it.
        outside, outside_at: farthest outside the demonstrations, and where.
        jump, jump_at: longest step in mean steps, and where it starts.
    """

    ok: bool
    reason: str
    residual: float
    residual_at: int
    outside: float
    outside_at: int
    jump: float
    jump_at: int


def check_path(
    states: Array, constraint: Constraint, tolerance: float, space: StateSpace, still: float = 0.0
) -> Check:
    """Check residual, support, continuity and limits of a path (n, D).

    A path whose ends the user put outside the demonstrations may lie as far outside as they do.

    Args:
        states: the path.
        constraint: what the path should hold.
        tolerance: largest distance from its surface.
        space: coordinates and their limits.
        still: a step this short is no jump, however short the others are: a path that stays where it is steps from
            its given ends onto the surface and back.
    """
    distance, outside = (np.asarray(values) for values in constraint.judge(states))
    moves = states[1:] - states[:-1]
    steps = np.sqrt(np.einsum("ic,ic->i", moves, moves))
    a, b, c = int(distance.argmax()), int(outside.argmax()), int(steps.argmax())
    jump = float(steps[c]) / max(float(steps.sum()) / len(steps), 1e-300)
    allowed = max(OUTSIDE, 1.5 * float(outside[0]), 1.5 * float(outside[-1]))
    within = space.contains(states, 1e-6 if space.is_flat else 1e-3)
    reason = ""
    if not np.isfinite(states).all():
        reason = "The path has numbers that are not finite."
    elif not distance[a] <= tolerance:
        reason = f"State {a} lies {distance[a]:.2g} off the manifold, more than {tolerance:.2g}."
    elif not outside[b] <= allowed:
        reason = f"State {b} lies outside the demonstrations, {outside[b]:.1f} times as far as is usual."
    elif not (jump <= JUMP or steps[c] <= still):
        reason = f"The path jumps after state {c}, {jump:.1f} times its mean step."
    elif not within.all():
        reason = f"State {int(within.argmin())} breaks the limits of its coordinates."
    return Check(not reason, reason, float(distance[a]), a, float(outside[b]), b, jump, c)
