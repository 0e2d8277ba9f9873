"""Plans around obstacles (section IV-B): the shortest path where it is clear, else one that bends or is sampled."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.check import check_path
from skillfold.clearance import Clearance
from skillfold.manifold.geodesic import geodesic, within_edge
from skillfold.manifold.model import Model
from skillfold.manifold.planning import FAR_END, HELD, Query, joined, onto, shares, told
from skillfold.manifold.projection import OnManifold, usual
from skillfold.manifold.sampled import renewed, sampled_path, smoothed, states_for
from skillfold.manifold.springs import sprung
from skillfold.manifold.terrain import Terrain
from skillfold.motion import Path, Plan
from skillfold.spaces import StateSpace

Array = np.ndarray[Any, np.dtype[np.float64]]

KEPT = 0.25  # of the margin that edges must keep; where an end has less, half of what it has
FIRST = 30  # states of the shortest path that is tried first


@dataclass(frozen=True)
class Leg:
    """A path between two states, in whole coordinates, and how it was found.

    Attributes:
        path: (n, D).
        method: that found it.
        iterations: of its solver.
        converged: whether its own stop rule was met.
        seconds: until a first clear path was there.
        blocked: what stands in the way of the shortest path, in words; empty where nothing does.
        held: whether that is held within the edge of the demonstrations, which it would leave.
    """

    path: Array
    method: str
    iterations: int
    converged: bool
    seconds: float
    blocked: str = ""
    held: bool = False


def plan_clear(
    model: Model,
    space: StateSpace,
    names: tuple[str, ...],
    query: Query,
    obstacles: Clearance,
) -> Plan:
    """A path on the manifold through the query's states, clear of obstacles.

    Args:
        model, space, names: of the skill.
        query: ends and via points, projected first where they are off; the number of states, 0 for as many as the
            check looks at; the method: "geodesic", "springs", "hinge", "sampled"; empty bends an earlier path where
            there is one, tries the shortest path, then samples.
        obstacles: what to keep clear of.
    """
    begun = perf_counter()
    asked, moved, supported = onto(model, space, query.states)
    why = touching(obstacles, asked)
    if why:
        return not_begun(asked, names, why, moved, "geodesic")
    spacing = obstacles.resolution / model.scale
    legs = []
    for a, b in pairwise(asked):
        ends = np.stack([a, b])
        margin = min(KEPT * obstacles.margin, 0.5 * float(np.min(obstacles.clearance(ends))))
        terrain = Terrain.between(model, space, obstacles, ends, margin)
        legs.append((terrain, _leg(terrain, ends, spacing, query)))
    counts = shares(asked, query.points) if query.points else [len(leg.path) for _, leg in legs]
    paths = [_read(terrain, leg.path, n) for (terrain, leg), n in zip(legs, counts, strict=True)]
    states = joined(space, paths, asked, counts)
    tolerance = usual(model) * (1.0 + 1e-9)
    check = check_path(states, OnManifold(model, tolerance), tolerance, space, usual(model), obstacles)
    found = [leg for _, leg in legs]
    plan = told(states, names, check, _story(found, moved, supported, check.ok), found, moved, "geodesic")
    plan.stats.update(
        methods=tuple(leg.method for leg in found),
        seconds_to_first=sum(leg.seconds for leg in found),
        seconds=perf_counter() - begun,
    )
    return plan


def _leg(terrain: Terrain, ends: Array, spacing: float, query: Query) -> Leg:
    """The shortest path where it is clear or asked for, else what the method finds."""
    begun = perf_counter()
    model, method = terrain.model, query.method
    if query.near is not None and not method:
        onward = _onward(terrain.coordinates(query.near), terrain.coordinates(ends))
        path, steps = renewed(terrain, onward, spacing)
        if len(path):
            return Leg(path, "renewed", steps, True, perf_counter() - begun)
    found = geodesic(model, ends, FIRST)
    if terrain.leads_out(terrain.coordinates(found.states)):
        found = within_edge(model, found)
    shortest = terrain.coordinates(found.states)
    at = terrain.first_blocked(shortest)
    if method == "geodesic" or (at < 0 and found.converged):
        dense, settled = terrain.settled(shortest, states_for(shortest, spacing), smooth=True)
        if method == "geodesic" or (settled and terrain.is_clear(dense)):
            seconds = perf_counter() - begun
            return Leg(dense, "geodesic", found.iterations, found.converged, seconds, held=found.held)
    seconds = perf_counter() - begun
    blocked = terrain.blocking(shortest, at) if at >= 0 else ""
    if method in _BENT:
        path, steps, converged = _BENT[method](terrain, shortest, spacing)
        path = path if len(path) else shortest
        return Leg(path, method, found.iterations + steps, converged, perf_counter() - begun, blocked)
    sample = sampled_path(terrain, terrain.coordinates(ends), spacing, query.seed)
    path = sample.path if len(sample.path) else shortest
    kind = ("sampled" if sample.smooth else "rough") if len(sample.path) else "none"
    return Leg(path, kind, found.iterations + sample.iterations, kind == "sampled", seconds + sample.seconds, blocked)


def _onward(near: Array, ends: Array) -> Array:
    """An earlier path (n, D) from where it is nearest to the start on, between new ends (2, D)."""
    first = int(((near - ends[0]) ** 2).sum(1).argmin())
    last = int(((near - ends[1]) ** 2).sum(1).argmin())
    return np.vstack([ends[:1], near[first + 1 : max(last, first + 1)], ends[1:]])


def _hinged(terrain: Terrain, shortest: Array, spacing: float) -> tuple[Array, int, bool]:
    path, steps = smoothed(terrain, shortest, spacing)
    return path, steps, bool(len(path))


def _sprung(terrain: Terrain, shortest: Array, spacing: float) -> tuple[Array, int, bool]:
    path, steps, converged = sprung(terrain, shortest)
    dense, _ = terrain.settled(path, states_for(path, spacing), smooth=False)
    return dense, steps, converged


_BENT: dict[str, Callable[[Terrain, Array, float], tuple[Array, int, bool]]] = {"hinge": _hinged, "springs": _sprung}


def _read(terrain: Terrain, path: Array, count: int) -> Array:
    return terrain.states(path if count == len(path) else terrain.settled(path, count, smooth=False)[0])


def touching(obstacles: Clearance, asked: Array) -> str:
    """Why a path through these states cannot be clear; empty where it may be."""
    for name, state, clearance in zip(_called(asked), asked, np.atleast_1d(obstacles.clearance(asked)), strict=True):
        if not clearance > 0.0:
            return f"The {name} is not clear: {obstacles.nearest(state)}, {clearance:.3g}."
    return beyond(*obstacles.bounds, asked)


def beyond(lower: Any, upper: Any, asked: Array, slack: float = 0.0) -> str:
    """Which of these states breaks its limits by more than the slack, and by how much; empty where none does."""
    for name, state in zip(_called(asked), asked, strict=True):
        over = np.maximum(state - np.asarray(upper), np.asarray(lower) - state)
        if over.max() > slack:
            return f"The {name} breaks the limits of coordinate {int(over.argmax())} by {over.max():.3g}."
    return ""


def _called(asked: Array) -> list[str]:
    return ["start", *(f"via {i}" for i in range(len(asked) - 2)), "goal"]


def not_begun(asked: Array, names: tuple[str, ...], reason: str, moved: Array, route: str) -> Plan:
    """A plan without success, whose path is the states that were asked for."""
    path = Path(asked, names)
    ends = (float(moved[0]), float(moved[-1]))
    return Plan(False, reason, path, path.length, np.inf, 0, False, route, *ends)


def _story(legs: list[Leg], moved: Array, supported: bool, ok: bool) -> str:
    named = zip(_called(moved), moved, strict=True)
    parts = [f"{name} moved {m:.3g} onto the manifold" for name, m in named if m > 0]
    if not supported:
        parts.append(FAR_END)
    blocked = sorted({leg.blocked for leg in legs if leg.blocked})
    if blocked:
        parts.append("the shortest path is blocked by " + ", ".join(blocked))
    if any(leg.held for leg in legs):
        parts.append(HELD)
    for method, words in _TOLD.items():
        if any(leg.method == method for leg in legs):
            parts.append("no smoother one was found" if ok and method == "none" else words)
    around = blocked or any(leg.method == "renewed" for leg in legs)
    head = "Path on the manifold around obstacles" if around else "Shortest path on the manifold"
    return head + "".join(f"; {part}" for part in parts) + "."


_TOLD = {
    "renewed": "the earlier path, bent",
    "springs": "bent by springs",
    "hinge": "bent by penalties on clearance",
    "sampled": "found by sampling and made smooth",
    "rough": "found by sampling, but it could not be made smooth",
    "none": "sampling found no way around: more samples than these may, or there is none",
}
