"""From one keyframe to the next: gates widened step by step, and the way into a reduced envelope."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.check import Check
from skillfold.keyframes.envelope import SoftEnvelope
from skillfold.keyframes.grown import Found, Targets
from skillfold.keyframes.legs import KEPT, Leg, Search, whitening
from skillfold.keyframes.region import PoseRegion
from skillfold.robots.obstacles import Obstacles
from skillfold.robots.robot import Robot

Array = np.ndarray[Any, np.dtype[np.float64]]

# Rungs of the ladder: how much wider gates are in d², share of the margin that is kept, share of the time left then.
# Passages narrower than the margin are gone through before gates are widened.
RUNGS = ((1.0, KEPT, 0.3), (1.0, 0.1 * KEPT, 0.3), (2.0, 0.1 * KEPT, 0.5), (4.0, 0.1 * KEPT, 1.0))
SLACK, GOAL_SLACK, ONWARD_SLACK = (
    0.01,
    0.03,
    0.15,
)  # of a gate's width: kept all along, at the end, before the next pair
TOLERANCE = 1e-6  # metres: rounding
DEEPER = 0.15  # of the way to the goal's centre that ends are looked for, inside its border
CHECKS = 3  # paths that may fail the check, which looks more closely, before there is none
ENTRY = 0.3  # share of the time for the way into a reduced envelope


@dataclass
class Outcome:
    """What became of a pair.

    Attributes:
        states: (n, D) path, `legs.SPACING` apart; empty where there is none.
        reason: why there is none, in words.
        factor: of the gates.
        kept: share of the margin that was kept.
        entered: from which state on poses are inside the reduced envelope.
        found: how the last search went.
        nodes, iterations: of all searches.
        check: of the states.
    """

    states: Array
    reason: str = ""
    factor: float = 1.0
    kept: float = KEPT
    entered: int = 0
    found: Found | None = None
    nodes: int = 0
    iterations: int = 0
    check: Check | None = None


@dataclass(frozen=True)
class Asked:
    """What all pairs of a plan share.

    Attributes:
        robot, obstacles: that moves, and that it keeps clear of.
        alpha: percent of the variance that the reduced envelope keeps; 100 is the full one.
        first: whether the first way is enough.
        begun: when the clock started, of `perf_counter`.
        search: that finds ways, such as `rrtstar.search`.
        once: whether the first answer stands, whatever the check says of it.
    """

    robot: Robot
    obstacles: Obstacles
    alpha: float
    first: bool
    begun: float
    search: Search
    once: bool = False


def plan_pair(
    asked: Asked, envelope: SoftEnvelope, start: Array, deadline: float, seed: int, last: bool = True
) -> Outcome:
    """A path from joint positions (D,) through an envelope into its child's gate; wider gates where there is none.

    Where this is not the last pair, the path ends deeper in the gate, which the next envelope sees in another chart.
    """
    outcome = Outcome(np.empty((0, len(start))))
    pose = asked.robot.forward(start)
    outside = float(envelope.distance(pose))
    for factor, kept, share in RUNGS:
        wide = envelope if factor == 1.0 else envelope.widened(factor)
        if not wide.contains(pose):
            outcome.reason = (
                f"The start lies {outside:.2g} m outside the envelope, beyond gates widened {factor:g} times."
            )
            continue
        outcome.factor, outcome.kept = factor, kept
        until = perf_counter() + (1.0 if asked.once else share) * max(deadline - perf_counter(), 0.0)
        _try_gate(asked, wide, start, until, seed, GOAL_SLACK if last else ONWARD_SLACK, outcome)
        if not outcome.reason or asked.once:
            break
    return outcome


def _try_gate(
    asked: Asked, wide: SoftEnvelope, start: Array, deadline: float, seed: int, slack: float, outcome: Outcome
) -> None:
    """One rung of the ladder: into the reduced envelope, if need be, and on to the goal."""
    narrow = wide.reduced(asked.alpha)
    here, parts, outcome.entered = start, [start[None]], 0
    if not narrow.contains(asked.robot.forward(start)):
        until = perf_counter() + ENTRY * max(deadline - perf_counter(), 0.0)
        entry = replace(_entry(asked, wide, narrow, start), kept=outcome.kept)
        states = checked_path(asked, entry, start, until, True, seed, outcome)
        if outcome.reason:
            outcome.reason = f"From the start, no way into the reduced envelope: {outcome.reason}"
            return
        here, outcome.entered = states[-1], len(states) - 1
        parts.append(states[1:])
    leg = replace(_crossing(asked, wide, narrow, here, slack), kept=outcome.kept)
    parts.append(checked_path(asked, leg, here, deadline, asked.first, seed, outcome)[1:])
    outcome.states = np.vstack(parts)


def checked_path(
    asked: Asked, leg: Leg, start: Array, deadline: float, first: bool, seed: int, outcome: Outcome
) -> Array:
    """The checked path of one leg; where there is none, the outcome has the reason."""
    nothing = np.empty((0, len(start)))
    for attempt in range(CHECKS):
        found, outcome.reason = leg.search(asked.search, start, asked.begun, deadline, first, seed + attempt)
        outcome.found = found
        outcome.nodes += found.nodes
        outcome.iterations += found.iterations
        if not outcome.reason and not len(found.path):
            wide = f", in gates widened {outcome.factor:g} times" if outcome.factor > 1.0 else ""
            outcome.reason = f"No way was found with {outcome.nodes} nodes{wide}."
        if outcome.reason:
            return nothing
        states, outcome.check = leg.checked(found.path)
        outcome.reason = outcome.check.reason
        if not outcome.reason or attempt == CHECKS - 1 or asked.once:
            return states
    return nothing


def _entry(asked: Asked, wide: SoftEnvelope, narrow: SoftEnvelope, start: Array) -> Leg:
    """Into the reduced envelope, where it is nearest first."""
    nearest = wide.chart.to_chart(narrow.project(asked.robot.forward(start)))

    def goal(count: int, seed: int) -> Array:
        targets = wide.chart.to_chart(narrow.sample(count, seed))
        targets[: count // 2] = nearest
        return targets

    return _leg(asked, wide, narrow, wide, start, goal)


def _crossing(asked: Asked, wide: SoftEnvelope, narrow: SoftEnvelope, start: Array, slack: float) -> Leg:
    """Through the envelope into the child's gate."""
    end, child = at_end(narrow), at_end(wide)
    return _leg(asked, narrow, child, wide, start, lambda n, seed: wide.chart.to_chart(end.sample(n, seed)), slack)


def _leg(
    asked: Asked,
    hold: SoftEnvelope,
    goal: PoseRegion,
    wide: SoftEnvelope,
    start: Array,
    goals: Callable[[int, int], Array],
    slack: float = GOAL_SLACK,
) -> Leg:
    chart = hold.chart

    def aim(states: Array) -> Array:
        nearest = chart.to_chart(goal.project(asked.robot.forward(states)))
        return nearest + DEEPER * (goal.ends[1] - nearest)

    targets = Targets(lambda n, seed: chart.to_chart(hold.sample(n, seed)), goals, asked.robot.sample, aim)
    # Where the start has less than the slack, poses may have as little.
    excess = float(np.sqrt(hold.membership(asked.robot.forward(start))[0])) - 1.0
    level = float(np.clip(excess, -SLACK, 0.0))
    metric = whitening(wide.covariances[-1])
    return Leg(
        asked.robot,
        asked.obstacles,
        hold,
        goal,
        level,
        -slack,
        TOLERANCE,
        chart,
        wide.ends,
        metric,
        targets,
    )


def at_end(region: PoseRegion) -> PoseRegion:
    """Its poses at s = 1 alone."""
    return PoseRegion(region.chart, region.ends[[1, 1]], region.covariances[[-1, -1]])
