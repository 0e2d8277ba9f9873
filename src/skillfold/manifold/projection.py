"""States onto the manifold and their distance from it (section IV-C).

The paper's iteration slides along the leaf of the field through its starting point, so the answer depends on
where it started. Anchored Newton goes to the modelled surface itself, from wherever it starts.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.manifold.kernels.judging import displacements, nearest_distances
from skillfold.manifold.kernels.leaf import field_bases, follow_leaf
from skillfold.manifold.kernels.projection import bring_onto, bring_onto_near
from skillfold.manifold.model import Model
from skillfold.spaces import StateSpace

Array = np.ndarray[Any, np.dtype[np.float64]]
FAR = 1.2  # times as far from the demonstrations as is usual: a path that leads farther is held within their edge
EXACT = 1e-6  # rms radii of the data: residual a path on the manifold may keep, besides what its ends have
NEAR = 1e-6  # rms radii of the data: a displacement this small is the distance
TURNS = 100  # between surface and limits, at most
SETTLED = 1e-9  # rms radii that the last of them moves a state
Flags = np.ndarray[Any, np.dtype[np.bool_]]


def project_anchored(model: Model, states: Array) -> tuple[Array, Flags]:
    """Closest points of the modelled surface to states (B, D), and whether it was met (B,)."""
    return bring_onto(model.table, model.trust, states)


def project_from(model: Model, states: Array, near: Array) -> tuple[Array, Flags]:
    """The same, found from `near` (B, D) alone: tracked states, so that the answer stays on their sheet."""
    return bring_onto_near(model.table, model.trust, states, near)


def project_leaf(model: Model, states: Array, near: Array, rate: float, steps: int) -> Array:
    """The paper's q' ← q' + α H'H''(q − q') from `near` (B, D): ends on the field's leaf through it."""
    inner = follow_leaf(model.table, model.encode(states), model.encode(near), rate, steps)
    return model.moved(near, inner) + (states - near) @ model.free @ model.free.T


def projected(model: Model, states: Array, near: Array | None, method: str, rate: float, steps: int) -> Array:
    """States (B, D) brought onto the manifold by a method: "leaf", the paper's from `near` (B, D), or anchored."""
    if method == "leaf":
        return project_leaf(model, states, _nearest_anchors(model, states) if near is None else near, rate, steps)
    return (project_anchored(model, states) if near is None else project_from(model, states, near))[0]


def within_limits(model: Model, states: Array, space: StateSpace) -> Array:
    """States of the surface (B, D), moved along it to where it keeps the limits of its coordinates.

    A surface learnt from states that stop at limits overshoots there. Turns are taken: the shortest way to within the
    limits, from there the shortest way onto the surface. Where the two do not meet, the turn that ends within limits
    and the nearest to the surface is the answer.
    """
    if not space.is_bounded:
        return states
    lower, upper = np.array(space.lower), np.array(space.upper)
    beyond = ((states < lower) | (states > upper)).any(1)
    if not beyond.any():
        return states
    best = now = np.clip(states[beyond], lower, upper)
    least = np.full(len(now), np.inf)
    for _ in range(TURNS):
        foot = project_anchored(model, now)[0]
        off = np.linalg.norm(foot - now, axis=1)
        best = np.where((off < least)[:, None], now, best)
        least = np.minimum(off, least)
        before, now = now, np.clip(foot, lower, upper)
        if np.abs(now - before).max() < SETTLED * model.scale:
            break
    kept = states.copy()
    kept[beyond] = best
    return kept


def _nearest_anchors(model: Model, states: Array) -> Array:
    nearest = [int(((model.anchors - row) ** 2).sum(1).argmin()) for row in model.encode(states)]
    return model.moved(states, model.anchors[nearest])


def tangents(model: Model, states: Array) -> Array:
    """Orthonormal tangents at states (B, D); (B, D, d), the free directions last."""
    rows = field_bases(model.table, model.encode(states))
    free = np.broadcast_to(model.free, (len(states), *model.free.shape))
    return np.concatenate([model.kept @ np.swapaxes(rows, 1, 2), free], axis=2)


def seem_off(model: Model, states: Array) -> Array:
    """How far states (B, D) seem to be from the modelled surface, by their displacements alone; (B,)."""
    return displacements(model.table, states, model.trust.ghost * model.scale)[0]


def judge(model: Model, states: Array, enough: float) -> tuple[Array, Array]:
    """Distances of states (B, D) from the modelled surface, and from the nearest anchor; both (B,).

    A state nearer than `enough` is not projected: there its displacement tells all that was asked.
    """
    off, nearest, _ = displacements(model.table, states, model.trust.ghost * model.scale)
    if off.max(initial=0.0) > enough:
        asked = off > enough
        away = states[asked]
        off[asked] = np.linalg.norm(project_anchored(model, away)[0] - away, axis=1)
    return off, nearest


def usual(model: Model) -> float:
    """How far off a state may be that counts as on the manifold, in state units."""
    return model.scale * max(model.tolerance, EXACT)


@dataclass(frozen=True)
class OnManifold:
    """A model as a constraint that a check can ask.

    Attributes:
        model: the manifold.
        enough: states nearer than this are not projected to learn how near; in state units.
    """

    model: Model
    enough: float = 0.0

    def judge(self, states: Array, /) -> tuple[Array, Array]:
        """Of states (B, D): distances from the modelled surface, and from the nearest anchor; both (B,).

        The latter is 1 at the 95 % quantile of held-out samples. Along free directions nothing counts until the
        range of the samples is left.
        """
        m = self.model
        off, near = judge(m, states, max(self.enough, NEAR * m.scale))
        return off, self._outside(states, near)

    def distance(self, states: Array) -> Array:
        """The first of what `judge` tells."""
        return self.judge(states)[0]

    def inside(self, states: Array) -> Array:
        """The second of what `judge` tells, with less work."""
        m = self.model
        return self._outside(states, nearest_distances(m.table, states))

    def _outside(self, states: Array, near: Array) -> Array:
        m = self.model
        if m.free.shape[1]:
            beyond = np.maximum(np.abs((states - m.centre) @ m.free) - m.free_extent, 0.0)
            near = np.sqrt(near**2 + (beyond**2).sum(1))
        return near / (m.scale * m.trust.spacing)
