"""Geodesics of curves that recordings spread about: neighbours are states of one phase, and offsets fade.

Recordings of one motion spread farther across than their samples lie apart, and strokes come near each other.
A local surface through the nearest samples then mixes strokes, and a path grown straight toward the goal takes
short cuts. But recordings tell which samples follow each other: on a manifold of dimension 1 the state at share s
of a path has the recordings' states at s as neighbours. With weights w_r, more for recordings nearer to the path,

    m(s) = Σ w_r c_r(s) is the surface there, m'(s) the tangent H, the same across the recordings' spread.

For a path q = m + e, section IV-A's err_M is Σ ‖P⊥ Δe‖²: it lets the offsets of the two ends pass into each other
evenly, where an anchored path drops them at once. What recordings do lies between: minimising ∫ ‖e'‖² + ‖e‖² / ρ²,
e fades over the distance ρ over which their own offsets do, long where they differ from beginning to end, next to
nothing for the noise of a sensor. Steps of equal length leave no pull along the curve (err_length).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.manifold.kernels.geodesic import resample
from skillfold.manifold.model import Model
from skillfold.manifold.route import Route
from skillfold.manifold.route_location import squared_spread

Array = np.ndarray[Any, np.dtype[np.float64]]

TOLERANCE = 1e-7  # of the last step, in rms radii of the recordings
LIMIT = 100  # iterations
SHARES = 2.0 ** np.arange(-6, 4)  # of the way, over which offsets may fade; the last is as good as evenly


@dataclass(frozen=True)
class LedPath:
    """A path and how it was found.

    Attributes:
        states: (points, D), the ends as asked but for rounding.
        spread: rms distance of the recordings from the surface beside the path, where it is largest.
        iterations: of the weights.
        converged: whether the last step was below the tolerance.
    """

    states: Array
    spread: float
    iterations: int
    converged: bool


def is_led(model: Model, route: Route | None) -> bool:
    """Whether recordings of a curve lie farther from each other than their samples follow each other."""
    return route is not None and model.dim == 1 and model.tolerance > model.step


def led_path(route: Route, start: Array, goal: Array, points: int) -> LedPath:
    """From start to goal (D,), the first path beside the recording whose ends there are the most alike."""
    if np.array_equal(start, goal):
        return LedPath(np.repeat(start[None], points, axis=0), 0.0, 0, True)
    asked = (np.stack([start, goal]) - route.centre) / route.scale
    curves = route.stretches(asked)
    variance = float(squared_spread(curves).mean())
    like = int(((curves[:, [0, -1]] - asked) ** 2).sum((1, 2)).argmin())
    path = _with_ends(curves[like], asked, SHARES[-1])
    surface, weights = _surface(curves, path, variance)
    share = return_share(curves - surface, weights)
    moved, iteration = np.inf, 0
    while iteration < LIMIT and moved >= TOLERANCE:
        iteration += 1
        before, path = path, _with_ends(surface, asked, share)
        moved = float(np.linalg.norm(path - before, axis=1).max())
        surface, weights = _surface(curves, path, variance)
    spread = np.sqrt(np.tensordot(weights, ((curves - surface) ** 2).sum(2), axes=1).max())
    states = np.empty((points, len(start)))
    resample(path * route.scale + route.centre, states)
    return LedPath(states, float(spread * route.scale), iteration, moved < TOLERANCE)


def return_share(offsets: Array, weights: Array) -> float:
    """ρ as a share of the way: with it, faded ends come nearest to the recordings' offsets (n, n_phases, D)."""
    ends = offsets[:, [0, -1]]
    gram = np.einsum("n,nad,nbd->ab", weights, ends, ends)
    along = np.einsum("n,nsd,nad->as", weights, offsets, ends)
    fades = [faded(offsets.shape[1], share) for share in SHARES]
    errors = [np.einsum("as,ab,bs->", fade, gram, fade) - 2.0 * (fade * along).sum() for fade in fades]
    return float(SHARES[int(np.argmin(errors))])


def faded(count: int, share: float) -> Array:
    """How much of the offsets of start and goal is left along the way, (2, count): solves e'' = e / ρ²."""
    way = np.linspace(0.0, 1.0, count)
    # sinh(s / ρ) / sinh(1 / ρ), written so that a small ρ does not overflow.
    last = np.exp((way - 1.0) / share) * np.expm1(-2.0 * way / share) / np.expm1(-2.0 / share)
    return np.stack([last[::-1], last])


def _surface(curves: Array, path: Array, variance: float) -> tuple[Array, Array]:
    """Surface m (n_phases, D) and weights (n,): Gaussians in rms distances, as wide as neighbours lie apart."""
    squared = ((curves - path) ** 2).sum(2).mean(1)
    weights = np.exp(-0.5 * (squared - squared.min()) / variance)
    weights /= weights.sum()
    return np.einsum("n,nsd->sd", weights, curves), weights


def _with_ends(surface: Array, ends: Array, share: float) -> Array:
    """The path m + e through given ends (2, D) along a surface m (n_phases, D)."""
    first, last = faded(len(surface), share)[..., None]
    return surface + first * (ends[0] - surface[0]) + last * (ends[1] - surface[-1])
