"""A planning query read, and given to who answers it."""

import numpy as np

from skillfold.clearance import Clearance
from skillfold.errors import InputError
from skillfold.manifold.avoiding import beyond, not_begun, plan_clear, touching
from skillfold.manifold.inputs import MANY, check_obstacles, choice, seed_of, whole
from skillfold.manifold.model import Model
from skillfold.manifold.planning import Query, plan_demonstrated, plan_geodesic
from skillfold.manifold.route import Route
from skillfold.motion import Array, Plan
from skillfold.planning.point_obstacles import PointObstacles
from skillfold.recordings import shortened
from skillfold.spaces import StateSpace

POINTS = {"geodesic": 50, "demonstrated": 101}  # states of a plan; chords would cut the wiggles of a route
NEARER = (0.25, 0.05)  # of the margin that a demonstrated route keeps where nothing else is found
LIMIT_SLACK = 1e-3  # by which given states may break their limits before that is said instead of all else
ROUTES = ("geodesic", "demonstrated")
ALONE = ("anchored", "leaf")
AROUND = ("geodesic", "springs", "hinge", "sampled")


def read_plan(
    states: Array,
    points: int | None,
    route: str,
    method: str | None,
    obstacles: Clearance | None,
    seed: int,
    near: Array | None,
) -> Query:
    """What `SkillManifold.plan` was asked, checked; `states` (2 + m, D) are so already."""
    if near is not None and (obstacles is None or len(states) > 2):
        raise InputError("near= is for a query with obstacles and without via points.")
    count = POINTS[choice("route", route, ROUTES)] if points is None else points
    count = whole("points", count, 1 + len(states), MANY)
    if obstacles is None:
        if method is not None and route == "demonstrated":
            raise InputError(f"method={shortened(method)} is for geodesics; ask for route='geodesic' with it.")
        return Query(states, count, "anchored" if method is None else choice("method", method, ALONE))
    check_obstacles(obstacles, states.shape[1])
    method = "" if method is None else choice("method", method, AROUND)
    return Query(states, count if points else 0, method, obstacles, seed_of(seed), near)


def answer(
    model: Model, route: Route | None, space: StateSpace, names: tuple[str, ...], query: Query, demonstrated: bool
) -> Plan:
    """The plan; the way the demonstrations take, where that is asked for, or the shortest on the manifold."""
    query = query._replace(obstacles=written_alike(query.obstacles, space, model.centre))
    if not demonstrated:
        return _on_manifold(model, route, space, names, query)
    if route is None:
        raise InputError("route='demonstrated' needs a skill learnt from two or more whole recordings.")
    why = beyond(space.lower, space.upper, query.states, LIMIT_SLACK)
    if not why and query.obstacles is not None:
        why = touching(query.obstacles, query.states)
    if why:
        return not_begun(query.states, names, why, np.zeros(len(query.states)), "demonstrated")
    plan = plan_demonstrated(model, space, names, route, query)
    if plan.success or query.obstacles is None:
        return plan
    # What cannot be pushed aside may still be gone around, as long as the manifold leaves a choice; or passed nearer.
    if model.dim > 1:
        around = _on_manifold(model, route, space, names, query)
        if around.success:
            return around
    nearer = (plan_demonstrated(model, space, names, route, query._replace(share=share)) for share in NEARER)
    return next((other for other in nearer if other.success), plan)


def written_alike(obstacles: Clearance | None, space: StateSpace, centre: Array) -> Clearance | None:
    """Points as the model writes states: −q is the orientation q, and a turn more no other angle."""
    if space.is_flat or not isinstance(obstacles, PointObstacles):
        return obstacles
    return PointObstacles(space.align(obstacles.points, centre), obstacles.reach)


def _on_manifold(model: Model, route: Route | None, space: StateSpace, names: tuple[str, ...], query: Query) -> Plan:
    if query.obstacles is None:
        return plan_geodesic(model, route, space, names, query, query.method == "leaf")
    return plan_clear(model, space, names, query, query.obstacles)
