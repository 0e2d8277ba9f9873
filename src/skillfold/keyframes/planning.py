"""Plans of keyframe skills: pair after pair; and of any constraint on the tool's pose."""

from itertools import pairwise
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.keyframes.asking import obstacles_of, read_limits, read_start, start_trouble
from skillfold.keyframes.envelope import SoftEnvelope
from skillfold.keyframes.pairs import Asked, Outcome, plan_pair
from skillfold.motion import Path, Plan
from skillfold.robots.robot import Robot

Array = np.ndarray[Any, np.dtype[np.float64]]

ATTEMPTS = 4  # at a skill of several pairs: another end of the pair before may lead on


def plan_envelopes(
    envelopes: list[SoftEnvelope],
    robot: Robot,
    q_start: Any,
    scene: Any = None,
    alpha: float = 100.0,
    time_limit: float = 1.0,
    stop: str = "first",
    seed: int = 0,
    first_pair: int = 0,
) -> Plan:
    """A path through envelopes, one after the other."""
    begun = perf_counter()
    limit = read_limits(time_limit, stop, seed)
    obstacles = obstacles_of(robot, scene)
    start = read_start(robot, q_start)
    why = start_trouble(robot, obstacles, start)
    if why:
        return failed(robot, start[None], why, begun)
    asked = Asked(robot, obstacles, alpha, stop == "first", begun)
    outcomes: list[Outcome] = []
    for attempt in range(ATTEMPTS):
        while len(outcomes) < len(envelopes):
            i = len(outcomes)
            here = outcomes[-1].states[-1] if outcomes else start
            until = perf_counter() + (begun + limit - perf_counter()) / (1 if asked.first else len(envelopes) - i)
            outcomes.append(plan_pair(asked, envelopes[i], here, until, seed + 7919 * attempt))
            if outcomes[-1].reason:
                break
        if not outcomes[-1].reason or len(outcomes) == 1 or perf_counter() > begun + limit:
            break
        if attempt < ATTEMPTS - 1:
            del outcomes[-2:]
    return told(robot, start, outcomes, begun, first_pair, len(envelopes))


def told(
    robot: Robot, start: Array, outcomes: list[Outcome], begun: float, first_pair: int, asked: int
) -> Plan:
    """The plan that outcomes of pairs make."""
    done = [outcome for outcome in outcomes if not outcome.reason]
    parts = [start[None], *(outcome.states[1:] for outcome in done)]
    states = np.vstack(parts)
    last = outcomes[-1]
    checks = [outcome.check for outcome in outcomes if outcome.check is not None]
    factor = max(outcome.factor for outcome in outcomes)
    success = not last.reason
    reason = last.reason
    if success:
        reason = f"Path inside the envelope{'s' if asked > 1 else ''}."
        if factor > 1.0:
            reason = f"Path inside gates widened {factor:g} times in squared distance: no other was found."
    elif asked > 1:
        reason = f"Pair {first_pair + len(outcomes) - 1}: {reason}"
    path = Path(states, robot.names)
    first = [outcome.found.first for outcome in done if outcome.found is not None]
    stats = {
        "nodes": sum(outcome.nodes for outcome in outcomes),
        "iterations": sum(outcome.iterations for outcome in outcomes),
        "first_solution": first[-1] if success else np.nan,
        "gate_factor": factor,
        "costs": last.found.costs if last.found is not None else [],
        "pair": first_pair,
        "check": checks[-1] if checks else None,
        "entered": last.entered,
        "seconds": perf_counter() - begun,
    }
    residual = max((check.residual for check in checks), default=np.inf)
    return Plan(
        success, reason, path, path.length, residual, stats["iterations"], success, "envelope", stats=stats
    )


def failed(robot: Robot, states: Array, reason: str, begun: float, route: str = "envelope") -> Plan:
    """A plan that was not begun."""
    stats = {"nodes": 0, "iterations": 0, "first_solution": np.nan, "gate_factor": 1.0, "costs": []}
    stats |= {"check": None, "entered": 0, "seconds": perf_counter() - begun}
    path = Path(states, robot.names)
    return Plan(False, reason, path, path.length, np.inf, 0, False, route, stats=stats)
