"""What whole demonstrations say about the way between given states: learnt correction, then kriging.

All demonstrations are read at the same phases. Some of these phases are *conditions*: the start, the goal,
and any via points, where the wanted route's state is given and each demonstration's own state is known.
This goes beyond paper 000, which plans shortest paths on the manifold.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.motion import Array

IntArray = np.ndarray[Any, np.dtype[np.intp]]

# Below this, relative to the demonstrations' size, differences are rounding.
ROUNDING = 1e-12
# How much clearer than the usual model another one must be (mean log distance), and at most how many
# demonstrations are left out to find out.
CLEARLY = 0.3
MOST_LEFT_OUT = 20
# Up to how many rms deviations from the demonstrated conditions what was learnt is believed.
BELIEVED = 3.0


@dataclass(frozen=True)
class RouteModel:
    """How a route depends on its conditions.

    Attributes:
        learnt: whether the correction toward the conditions is learnt or linear in phase.
        kriged: whether demonstrations with similar conditions count for more.
        radial, linear: weights of the Gaussian and of the linear part of the kernel.
        reach: length scale of the kernel, in rms distances of the demonstrations' conditions.
        nugget: variance of what the conditions do not explain, relative to the kernel.
        ridge: strength with which the learnt correction is held to the linear one, in demonstrations.
    """

    learnt: bool = True
    kriged: bool = True
    radial: float = 0.25
    linear: float = 1.0
    reach: float = 1.5
    nugget: float = 2.0
    ridge: float = 20.0


USUAL = RouteModel()
ENDS_LEARNT = RouteModel(kriged=False)
CORRECTED_MEAN = RouteModel(learnt=False, kriged=False)


def _narrow(reach: float, nugget: float) -> RouteModel:
    return RouteModel(radial=1.0, linear=0.0, reach=reach, nugget=nugget)


# Where the ends determine the shape, to little noise.
DETERMINED = RouteModel(nugget=0.03, ridge=0.1)
# Narrow kernels serve skills with several ways, between which the ends decide. Their nugget is the variance
# within a way over that between the ways: any small number.
NARROW = (_narrow(0.4, 0.1), _narrow(0.4, 0.01), _narrow(1.0, 0.6))
MODELS = (USUAL, DETERMINED, *NARROW, ENDS_LEARNT, CORRECTED_MEAN)


def hats(n_phases: int, nodes: IntArray) -> Array:
    """Piecewise linear functions of phase, 1 at their own node and 0 at the others: (n_phases, n_nodes)."""
    grid = np.arange(n_phases, dtype=np.float64)
    return np.stack([np.interp(grid, nodes, row) for row in np.eye(len(nodes))], axis=1)


def corrections(deviations: Array, nodes: IntArray, prior: Array, strength: float) -> Array:
    """How much of a deviation at each condition is felt at each phase, learnt by ridge regression.

    One scalar for each phase and condition, shared by all coordinates (so that rotations change nothing);
    the ridge pulls toward a linear correction, as strongly as `strength` usual demonstrations would.

    Args:
        deviations: (n, n_phases, D), demonstrations minus their mean.
        nodes: (m,) increasing phase indices of the conditions.
        prior: (n_phases, m), the linear correction.
        strength: of the ridge, in demonstrations.

    Returns:
        (n_phases, m); the identity at the nodes.
    """
    at_nodes = deviations[:, nodes]
    gram = np.tensordot(at_nodes, at_nodes, axes=([0, 2], [0, 2]))
    cross = np.tensordot(deviations, at_nodes, axes=([0, 2], [0, 2]))
    ridge = np.diag(strength / len(deviations) * np.diag(gram) + ROUNDING)
    return prior + np.linalg.solve(gram + ridge, (cross - prior @ gram).T).T


def kernel(model: RouteModel, z: Array, others: Array) -> Array:
    """Similarity of conditions, (m, n) for (m, C) and (n, C)."""
    squared = ((z[:, None] - others[None]) ** 2).sum(axis=2)
    radial = np.exp(-0.5 * squared / model.reach**2)
    return model.radial * radial + model.linear * (z @ others.T) / model.reach**2


def weigh(model: RouteModel, own: Array, wanted: Array) -> tuple[Array, float, Array]:
    """Weights of the demonstrations for the wanted conditions: universal kriging with an unknown constant.

    Args:
        model: brings the kernel; without one, all weigh the same.
        own: (n, C), conditions of the demonstrations, as deviations from their mean.
        wanted: (C,), the same of the route.

    Returns:
        Weights (n,), which sum to 1; the variance of what they predict, in units of the process; and Q
        (n, n), by which leave-one-out residuals are Q r / diag(Q), of variance 1 / diag(Q).
    """
    n = len(own)
    scale = np.sqrt((own**2).sum() / n)
    if not model.kriged or scale < ROUNDING:
        return np.full(n, 1.0 / n), 1.0 + 1.0 / n, np.eye(n) - 1.0 / n
    z, at = own / scale, wanted / scale
    inverse = np.linalg.inv(kernel(model, z, z) + model.nugget * np.eye(n))
    k = kernel(model, z, at[None])[:, 0]
    row = inverse.sum(axis=0)
    missing = (1.0 - row @ k) / row.sum()
    itself = float(kernel(model, at[None], at[None])[0, 0]) + model.nugget
    variance = itself - k @ inverse @ k + missing**2 * row.sum()
    return inverse @ k + row * missing, max(float(variance), 0.0), inverse - np.outer(row, row) / row.sum()


def believed(wanted: Array, own: Array) -> Array:
    """Wanted deviations (m, D), shortened to where the demonstrations' own (n, m, D) say something.

    A robot that always starts at home, to a hair, says nothing about how it would start elsewhere: its noise
    must not be extrapolated.
    """
    limit = BELIEVED * np.sqrt((own**2).sum(axis=2).mean(axis=0))
    size = np.maximum(np.linalg.norm(wanted, axis=1), limit + ROUNDING)
    return wanted * ((limit + ROUNDING) / size)[:, None]


def predict(model: RouteModel, curves: Array, nodes: IntArray, asked: Array) -> tuple[Array, Array]:
    """The route through the asked states, and how far off it may be.

    With M the mean, u the deviations of the conditions from it, and r what the correction leaves of each
    demonstration, the route is M + Σ α u + Σ w r; what is asked beyond that is corrected linearly.

    Args:
        model: how the route depends on its conditions.
        curves: (n, n_phases, D), the demonstrations.
        nodes: (m,) increasing phase indices of the conditions, the first and the last phase among them.
        asked: (m, D), the states wanted there.

    Returns:
        States (n_phases, D), and samples (n, n_phases, D) of their error: what leaving out each demonstration
        leaves, scaled to how well these conditions are known.
    """
    route, residuals, variance, q = _interpolate(model, curves, nodes, asked)
    errors = np.tensordot(q, residuals, axes=1) * np.sqrt(variance / q.diagonal())[:, None, None]
    errors[:, nodes] = 0.0
    return route, errors


def _interpolate(
    model: RouteModel, curves: Array, nodes: IntArray, asked: Array
) -> tuple[Array, Array, float, Array]:
    """The route (n_phases, D), the residuals (n, n_phases, D), and variance and Q of their weights."""
    mean = curves.mean(axis=0)
    deviations = curves - mean
    linear = hats(curves.shape[1], nodes)
    alpha = corrections(deviations, nodes, linear, model.ridge) if model.learnt else linear
    own = deviations[:, nodes]
    wanted = believed(asked - mean[nodes], own)
    residuals = deviations - alpha @ own
    weights, variance, q = weigh(model, own.reshape(len(own), -1), wanted.ravel())
    route = mean + alpha @ wanted + np.tensordot(weights, residuals, axes=1)
    return route + linear @ (asked - route[nodes]), residuals, variance, q


def left_out_error(model: RouteModel, curves: Array) -> float:
    """Mean log distance of the routes to the demonstrations, each planned from the others."""
    nodes = np.array([0, curves.shape[1] - 1])
    distances = []
    for i in np.unique(np.linspace(0, len(curves) - 1, MOST_LEFT_OUT).astype(np.intp)):
        route, *_ = _interpolate(model, np.delete(curves, i, axis=0), nodes, curves[i, nodes])
        distances.append(np.linalg.norm(route - curves[i], axis=1).mean())
    return float(np.log(np.array(distances) + ROUNDING).mean())


def stretches(curves: Array) -> list[Array]:
    """The whole and three halves: what is asked later, and more evidence than the whole alone."""
    half = curves.shape[1] // 2
    return [curves, curves[:, : half + 1], curves[:, half // 2 : -(half // 2)], curves[:, half:]]


def choose(curves: Array) -> RouteModel:
    """The usual model, or the one that leaving out a demonstration clearly prefers.

    Args:
        curves: (n, n_phases, D), scaled to unit rms radius.
    """
    if len(curves) < 4:
        return ENDS_LEARNT
    if len(curves) < 5:
        return USUAL
    parts = stretches(curves)
    errors = np.mean([[left_out_error(model, part) for model in MODELS] for part in parts], axis=0)
    best = int(errors.argmin())
    return MODELS[best] if errors[best] <= errors[0] - CLEARLY else USUAL
