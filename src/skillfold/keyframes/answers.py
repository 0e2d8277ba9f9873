"""Plans made of what became of their pairs."""

from time import perf_counter
from typing import Any

import numpy as np

from skillfold.keyframes.legs import KEPT
from skillfold.keyframes.pairs import Outcome
from skillfold.motion import Path, Plan
from skillfold.robots.robot import Robot

Array = np.ndarray[Any, np.dtype[np.float64]]


def told(
    robot: Robot, start: Array, outcomes: list[Outcome], begun: float, pair: int, route: str = "envelope"
) -> Plan:
    """The plan that outcomes of pairs make, the first of them `pair`; its path ends where they do."""
    last = outcomes[-1]
    states = np.vstack([start[None], *(outcome.states[1:] for outcome in outcomes)])
    path = Path(states, robot.names)
    checks = [outcome.check for outcome in outcomes if outcome.check is not None]
    residual = max((check.residual for check in checks), default=np.inf)
    pairs = _pairs(outcomes, pair)
    stats = {
        "nodes": sum(outcome.nodes for outcome in outcomes),
        "iterations": sum(outcome.iterations for outcome in outcomes),
        "first_solution": np.nan if last.found is None else last.found.first,
        "gate_factor": max(outcome.factor for outcome in outcomes),
        "costs": _costs(outcomes),
        "pair": pair,
        "pairs": pairs,
        "entered": pairs[-1]["entered"],
        "check": checks[-1] if checks else None,
        "tree": None if last.found is None else last.found.tree,
        "seconds": perf_counter() - begun,
    }
    reason = _story(outcomes, pair, route)
    success = not last.reason
    iterations = stats["iterations"]
    return Plan(success, reason, path, path.length, residual, iterations, success, route, stats=stats)


def not_begun(robot: Robot, states: Array, reason: str, begun: float, route: str, success: bool = False) -> Plan:
    """A plan that there was nothing to search for."""
    stats: dict[str, Any] = {"nodes": 0, "iterations": 0, "first_solution": np.nan, "gate_factor": 1.0, "costs": []}
    stats |= {"pair": 0, "pairs": [], "entered": 0, "check": None, "seconds": perf_counter() - begun}
    path = Path(states, robot.names)
    residual = 0.0 if success else np.inf
    return Plan(success, reason, path, path.length, residual, 0, success, route, stats=stats)


def _costs(outcomes: list[Outcome]) -> list[tuple[float, float]]:
    """(seconds, cost) of each better way; with those of the pairs before, as they ended."""
    before = sum(outcome.found.cost for outcome in outcomes[:-1] if outcome.found is not None)
    last = outcomes[-1].found
    return [] if last is None else [(seconds, before + cost) for seconds, cost in last.costs]


def _pairs(outcomes: list[Outcome], pair: int) -> list[dict[str, Any]]:
    """Of each pair: its number, the states it starts and is entered at, its gates and nodes."""
    rows, at = [], 0
    for i, outcome in enumerate(outcomes):
        entered = at + outcome.entered
        rows.append(
            {"pair": pair + i, "from": at, "entered": entered, "gate_factor": outcome.factor, "nodes": outcome.nodes}
        )
        at += max(len(outcome.states) - 1, 0)
    return rows


def _story(outcomes: list[Outcome], pair: int, route: str) -> str:
    last = outcomes[-1]
    if last.reason:
        return last.reason if len(outcomes) == 1 else f"Pair {pair + len(outcomes) - 1}: {last.reason}"
    wide = {pair + i: outcome.factor for i, outcome in enumerate(outcomes) if outcome.factor > 1.0}
    gates = ", ".join(f"{factor:g} times for pair {i}" for i, factor in wide.items())
    within = f"Path inside the {'envelope' if route == 'envelope' else 'constraint'}"
    if wide:
        within = f"Path inside gates widened in squared distance, {gates}: in narrower ones none was found"
    near = any(outcome.kept < KEPT for outcome in outcomes)
    nearer = f"; nearer to obstacles than {KEPT:.0%} of the margin, as no way farther off was found"
    return f"{within}{nearer if near else ''}."
