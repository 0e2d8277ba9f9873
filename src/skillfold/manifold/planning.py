"""Plans: the ends brought onto the manifold, a path between them, the check, and the story in words."""

from collections.abc import Callable, Iterator, Sequence
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from skillfold.check import Check, check_path
from skillfold.clearance import Clearance
from skillfold.manifold.aside import aside_of
from skillfold.manifold.geodesic import Geodesic, geodesic, leaf_geodesic, regrown, roundabout, within_edge
from skillfold.manifold.leading import is_led, led_path
from skillfold.manifold.model import Model
from skillfold.manifold.projection import FAR, OnManifold, project_anchored, seem_off, usual, within_limits
from skillfold.manifold.pulling import pulled_onto
from skillfold.manifold.route import Route, RouteAnswer
from skillfold.motion import Path, Plan
from skillfold.spaces import StateSpace

Array = np.ndarray[Any, np.dtype[np.float64]]

DOUBTED = 2.0  # spreads that a demonstrated route may lie farther off than samples do
WITHIN = 0.5  # of the distance that 95 % of samples keep from the surface: their standard deviation
TURNS = 4  # between obstacles and manifold, at most
SHOWN = 101  # states of a demonstrated route where the query names no number
FAR_END = "an end lies far from the demonstrations"
HELD = "held within the edge of the demonstrations, which it would leave"


class Query(NamedTuple):
    """What is asked.

    Attributes:
        states: ends and via points (m, D) in order.
        points: states of the path; 0 among obstacles, for as many as the check looks at.
        method: "anchored" or "leaf"; among obstacles how to go around them, empty for the default.
        obstacles: what to keep clear of.
        seed: of what is sampled.
        near: an earlier path (n, D) that is likely near the answer; None where there is none.
        share: of the obstacles' margin, which a demonstrated route keeps.
    """

    states: Array
    points: int
    method: str = "anchored"
    obstacles: Clearance | None = None
    seed: int = 0
    near: Array | None = None
    share: float = 1.0


def plan_geodesic(
    model: Model, route: Route | None, space: StateSpace, names: tuple[str, ...], query: Query, leaf: bool
) -> Plan:
    """The shortest path on the manifold through the query's states, which are projected first where they are off."""
    if route is not None and is_led(model, route) and not leaf:
        return _plan_led(model, route, space, names, query)
    asked, moved, supported = onto(model, space, query.states)
    counts = shares(asked, query.points)
    solve = leaf_geodesic if leaf else geodesic
    parts = [solve(model, asked[i : i + 2], count) for i, count in enumerate(counts)]
    check, states = _checked(model, space, asked, parts)
    for instead in _instead(model, asked, parts, check, leaf):
        if any(other is not part for other, part in zip(instead, parts, strict=True)):
            checked, path = _checked(model, space, asked, instead)
            if checked.ok:
                check, states, parts = checked, path, instead
                break
    return told(states, names, check, _story_geodesic(moved, supported, parts), parts, moved, "geodesic")


def _instead(model: Model, asked: Array, parts: list[Geodesic], check: Check, leaf: bool) -> Iterator[list[Geodesic]]:
    """Other paths for one that leads far out or fails its check, each made only when those before do not serve."""
    legs = [(asked[i : i + 2], part) for i, part in enumerate(parts)]
    if check.outside > FAR and not leaf:
        yield [within_edge(model, part) for part in parts]
    if not check.ok and not leaf:
        yield [_regrown(model, ends, part) for ends, part in legs]
    if not check.ok:
        yield [_over_anchors(model, ends, part) for ends, part in legs]


def _regrown(model: Model, ends: Array, part: Geodesic) -> Geodesic:
    """The path first found over the anchors, instead of one that was grown; held within the edge as that one is."""
    return within_edge(model, regrown(model, ends, len(part.states))) if part.first == "grown" else part


def _over_anchors(model: Model, ends: Array, part: Geodesic) -> Geodesic:
    """The way over the anchors, instead of a path for which the field's tangents were of no use."""
    return roundabout(model, ends, len(part.states)) if part.own else part


def _checked(model: Model, space: StateSpace, asked: Array, parts: list[Geodesic]) -> tuple[Check, Array]:
    """Verdict on the path through the asked states, and its states (n, D)."""
    paths, counts = [part.states for part in parts], [len(part.states) for part in parts]
    near = usual(model)
    tolerance = near * (1.0 + 1e-9)  # ends that were left where they are keep this too
    return _verdict(
        lambda states: check_path(states, OnManifold(model, tolerance), tolerance, space, near),
        space,
        joined(space, paths, asked, counts),
        lambda: joined(space, [within_limits(model, path, space) for path in paths], asked, counts),
    )


def _verdict(
    judge: Callable[[Array], Check], space: StateSpace, states: Array, inside: Callable[[], Array]
) -> tuple[Check, Array]:
    """Of a path, or where it fails of what it is inside the limits of its coordinates, if that passes; and which."""
    check = judge(states)
    if not check.ok and space.is_bounded:
        brought = inside()
        again = judge(brought)
        if again.ok:
            return again, brought
    return check, states


def _plan_led(model: Model, route: Route, space: StateSpace, names: tuple[str, ...], query: Query) -> Plan:
    """The same where recordings spread: ends on the manifold keep their offset, and the path returns as they do."""
    asked, moved, supported = onto(model, space, query.states)
    counts = shares(asked, query.points)
    legs = [led_path(route, a, b, count) for a, b, count in zip(asked[:-1], asked[1:], counts, strict=True)]
    tolerance = usual(model) + DOUBTED * max(leg.spread for leg in legs)
    check, states = _verdict(
        lambda states: check_path(states, OnManifold(model, tolerance), tolerance, space, usual(model)),
        space,
        joined(space, [leg.states for leg in legs], asked, counts),
        lambda: joined(space, [_clipped(space, leg.states, asked) for leg in legs], asked, counts),
    )
    parts = [Geodesic(leg.states, leg.iterations, leg.converged, "recordings") for leg in legs]
    return told(states, names, check, _story_geodesic(moved, supported, parts), parts, moved, "geodesic")


def plan_demonstrated(model: Model, space: StateSpace, names: tuple[str, ...], route: Route, query: Query) -> Plan:
    """The way the demonstrations take between the query's ends and through its via points, pushed off obstacles.

    Where they do not pass the via points in that order, it goes to each by itself, backwards if need be.
    """
    count = query.points or SHOWN
    whole = route.between(query.states[0], query.states[-1], count, query.states[1:-1])
    plan = _along(model, space, names, whole, query, "Follows the demonstrations")
    if plan.success or len(query.states) == 2:
        return plan
    legs = route.leg_by_leg(query.states, shares(query.states, count))
    again = _along(model, space, names, legs, query, "Follows the demonstrations from each given state to the next")
    return again if again.success else plan


def _along(
    model: Model, space: StateSpace, names: tuple[str, ...], answer: RouteAnswer, query: Query, story: str
) -> Plan:
    """A plan of a route through the query's states: held near the manifold, pushed off obstacles, checked."""
    # Demonstrations lie no farther off the surface than samples do; what they spread besides is along it.
    spread = np.minimum(answer.spread, WITHIN * usual(model))
    ends = float(OnManifold(model).distance(query.states).max())
    tolerance = max(usual(model) + 3.0 * float(spread.max()), 1.5 * ends)
    allowed = usual(model) + DOUBTED * spread
    held = pulled_onto(model, answer.states, query.states, allowed, tolerance)
    if query.obstacles is not None:
        aside = _aside(model, held, query, allowed, tolerance)
        story += f", up to {np.linalg.norm(aside - held, axis=1).max():.3g} aside" if aside is not held else ""
        story += f", with {query.share:.0%} of the margin" if query.share < 1.0 else ""
        held = aside
    constraint, obstacles = OnManifold(model, tolerance), query.obstacles
    check, states = _verdict(
        lambda states: check_path(states, constraint, tolerance, space, usual(model), obstacles),
        space,
        space.normalize(held),
        lambda: space.normalize(_clipped(space, held, query.states)),
    )
    if answer.reversed:
        story += ", travelled backwards"
    if answer.start_phase > 0.0 or answer.goal_phase < 1.0:
        story += f" from {answer.start_phase:.0%} to {answer.goal_phase:.0%} of their length"
    if ends > usual(model):
        story += f"; given states lie up to {ends:.2g} off the manifold"
    if answer.supported > 3.0:
        story += f"; the ends lie {answer.supported:.1f} times as far from them as is usual"
    stats = {"spread": answer.spread, "start_phase": answer.start_phase, "goal_phase": answer.goal_phase}
    plan = told(states, names, check, story + ".", [], np.zeros(len(query.states)), "demonstrated")
    plan.stats.update(stats, supported=answer.supported, reversed=answer.reversed)
    return plan


def _aside(model: Model, path: Array, query: Query, allowed: Array, tolerance: float) -> Array:
    """The path (n, D) pushed off obstacles, and pulled back in turns where that pushes it off the manifold too."""
    obstacles, constraint = query.obstacles, OnManifold(model, tolerance)
    if obstacles is None:
        return path
    aside, least = aside_of(path, query.states, obstacles, query.share), np.inf
    for _ in range(TURNS if model.dim > 1 else 0):  # on a curve, what pulls back leads into the obstacle again
        off = float(constraint.distance(aside).max())
        if not tolerance < off < least:
            break
        least = off
        path = pulled_onto(model, aside, query.states, allowed, tolerance)
        aside = aside_of(path, query.states, obstacles, query.share)
    return aside


def _clipped(space: StateSpace, states: Array, given: Array) -> Array:
    """States (n, D) within the limits of their coordinates, but for those that were given."""
    kept = (states[:, None] == given).all(2).any(1)
    return np.where(kept[:, None], states, np.clip(states, space.lower, space.upper))


def onto(model: Model, space: StateSpace, states: Array) -> tuple[Array, Array, bool]:
    """States projected where they are farther off than samples are; how far each moved; all near the data?"""
    near, seem = usual(model), seem_off(model, states)
    if seem.max() <= near:
        return states, np.zeros(len(states)), True
    off, onto = seem > near, states.copy()
    feet, supported = project_anchored(model, states[off])
    far = np.linalg.norm(feet - states[off], axis=1) > near
    off[off] = far
    onto[off] = space.normalize(within_limits(model, feet[far], space))
    return onto, np.linalg.norm(onto - states, axis=1), bool(supported[far].all())


def shares(states: Array, points: int) -> list[int]:
    """States of each leg, both ends counted, in proportion to the distance between its ends."""
    if len(states) == 2:
        return [points]
    gaps = np.linalg.norm(np.diff(states, axis=0), axis=1)
    steps = points - 1 - len(gaps)
    share = np.cumsum(gaps) / max(float(gaps.sum()), 1e-300)
    bounds = np.concatenate([[0], np.round(share * steps).astype(int)])
    bounds[-1] = steps
    return [int(n) + 2 for n in np.diff(bounds)]


def joined(space: StateSpace, legs: list[Array], asked: Array, counts: list[int]) -> Array:
    """Legs in a row, through the asked states to the bit."""
    states = np.vstack([legs[0], *(leg[1:] for leg in legs[1:])]) if len(legs) > 1 else legs[0]
    states = states if space.is_flat else space.normalize(states)
    if len(legs) == 1:
        states[:: len(states) - 1] = asked  # both ends
        return states
    for i, state in zip(accumulate((n - 1 for n in counts), initial=0), asked, strict=True):
        states[i] = state
    return states


def _story_geodesic(moved: Array, supported: bool, legs: list[Geodesic]) -> str:
    ways = moved.tolist()
    parts = [f"{_end(i, len(ways))} moved {way:.3g} onto the manifold" for i, way in enumerate(ways) if way]
    if not supported:
        parts.append(FAR_END)
    firsts = {leg.first for leg in legs}
    if "graph" in firsts:
        parts.append("first path found over the anchors")
    if "recordings" in firsts:
        parts.append("led by the recordings, which spread")
    if True in [leg.own for leg in legs]:
        parts.append("solved with the surface's own tangents, as the field's lie across it")
    if True in [leg.held for leg in legs]:
        parts.append(HELD)
    if False in [leg.converged for leg in legs]:
        parts.append("not relaxed to the shortest, as that did not converge or left the manifold")
    return "Shortest path on the manifold" + "".join(f"; {part}" for part in parts) + "."


def _end(i: int, count: int) -> str:
    return "start" if i == 0 else "goal" if i == count - 1 else f"via {i - 1}"


def told(
    states: Array,
    names: tuple[str, ...],
    check: Check,
    story: str,
    legs: Sequence[Any],
    moved: Array,
    route: str,
) -> Plan:
    """The plan, of legs that know their `iterations` and whether they `converged`."""
    return Plan(
        success=check.ok,
        reason=story if check.ok else f"{check.reason} ({story})",
        path=Path(states, names),
        length=check.length,
        residual=check.residual,
        iterations=sum(leg.iterations for leg in legs),
        converged=all(leg.converged for leg in legs),
        route=route,
        start_moved=float(moved[0]),
        goal_moved=float(moved[-1]),
        stats={"check": check},
    )
