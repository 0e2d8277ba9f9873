"""What whole demonstrations say about the way between given states: learnt correction, then kriging.

All demonstrations are read at the same phases (`route_phases`). Some of these are *conditions*: the start, the
goal, and any via points, where the wanted route's state is given and each demonstration's own state is known.
This goes beyond paper 000, which plans shortest paths on the manifold.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.motion import Array

IntArray = np.ndarray[Any, np.dtype[np.intp]]

# Below this, relative to the demonstrations' size, differences are rounding.
ROUNDING = 1e-12
# At most how many demonstrations are left out to find out which model serves.
MOST_LEFT_OUT = 20
# Numbers in what is worked on together while they are left out one by one.
AT_ONCE = 500_000
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
# Between the ends of whole motions: where people set out says less of their way than where they pass.
USUAL_WHOLE = RouteModel(nugget=4.0)
ENDS_LEARNT = RouteModel(kriged=False)
CORRECTED_MEAN = RouteModel(learnt=False, kriged=False)


def _narrow(reach: float, nugget: float) -> RouteModel:
    return RouteModel(radial=1.0, linear=0.0, reach=reach, nugget=nugget)


# Where the ends determine the shape, to little noise.
DETERMINED = RouteModel(nugget=0.03, ridge=0.1)
# Narrow kernels serve skills with several ways, between which the ends decide. Their nugget is the variance
# within a way over that between the ways: any small number.
NARROW = (_narrow(0.4, 0.1), _narrow(0.4, 0.01), _narrow(1.0, 0.6))
# Where demonstrations go one way, each can be read where it is most like the others.
ALIKE = (USUAL, ENDS_LEARNT, CORRECTED_MEAN)
MODELS = (USUAL, DETERMINED, *NARROW, ENDS_LEARNT, CORRECTED_MEAN)
# How much closer than the usual model each must be (mean log distance): clearly, but for the same without kriging.
CLEARLY = np.array([0.0, 0.3, 0.3, 0.3, 0.3, 0.05, 0.3])


def hats(n_phases: int, nodes: IntArray) -> Array:
    """Piecewise linear functions of phase, 1 at their own node and 0 at the others: (n_phases, n_nodes)."""
    grid = np.arange(n_phases, dtype=np.float64)
    return np.stack([np.interp(grid, nodes, row) for row in np.eye(len(nodes))], axis=1)


def corrections(deviations: Array, nodes: IntArray, prior: Array, strength: float) -> Array:
    """How much of a deviation at each condition is felt at each phase, learnt by ridge regression.

    One scalar for each phase and condition, shared by all coordinates (so that rotations change nothing);
    the ridge pulls toward a linear correction, as strongly as `strength` usual demonstrations would.

    Args:
        deviations: (..., n, n_phases, D), demonstrations minus their mean.
        nodes: (m,) increasing phase indices of the conditions.
        prior: (n_phases, m), the linear correction.
        strength: of the ridge, in demonstrations.

    Returns:
        (..., n_phases, m); the identity at the nodes.
    """
    n, n_phases, n_dims = deviations.shape[-3:]
    rows = np.swapaxes(deviations, -3, -2).reshape(*deviations.shape[:-3], n_phases, n * n_dims)
    at_nodes = rows[..., nodes, :]
    gram = at_nodes @ np.swapaxes(at_nodes, -1, -2)
    cross = rows @ np.swapaxes(at_nodes, -1, -2)
    ridge = (strength / n * np.diagonal(gram, axis1=-2, axis2=-1) + ROUNDING)[..., None] * np.eye(len(nodes))
    missing = np.swapaxes(cross - prior @ gram, -1, -2)
    return prior + np.swapaxes(np.linalg.solve(gram + ridge, missing), -1, -2)


def kernel(model: RouteModel, z: Array, others: Array) -> Array:
    """Similarity of conditions, (..., m, n) for (..., m, C) and (..., n, C)."""
    squared = ((z[..., :, None, :] - others[..., None, :, :]) ** 2).sum(axis=-1)
    radial = np.exp(-0.5 * squared / model.reach**2)
    return model.radial * radial + model.linear * (z @ np.swapaxes(others, -1, -2)) / model.reach**2


def weigh(model: RouteModel, own: Array, wanted: Array) -> tuple[Array, Array, Array]:
    """Weights of the demonstrations for the wanted conditions: universal kriging with an unknown constant.

    Args:
        model: brings the kernel; without one, all weigh the same.
        own: (..., n, C), conditions of the demonstrations, as deviations from their mean.
        wanted: (..., C), the same of the route.

    Returns:
        Weights (..., n), which sum to 1; the variance (...) of what they predict, in units of the process; and Q
        (..., n, n), by which leave-one-out residuals are Q r / diag(Q), of variance 1 / diag(Q).
    """
    n, leading = own.shape[-2], own.shape[:-2]
    if not model.kriged:
        alike = np.broadcast_to(np.eye(n) - 1.0 / n, (*leading, n, n))
        return np.full((*leading, n), 1.0 / n), np.full(leading, 1.0 + 1.0 / n), alike
    scale = np.sqrt((own**2).sum(axis=(-2, -1)) / n)[..., None, None]
    # Conditions that are all the same tell nothing: at a distance of zero, all weigh the same.
    per_scale = np.where(scale < ROUNDING, 0.0, 1.0 / np.maximum(scale, ROUNDING))
    z = np.concatenate([own, wanted[..., None, :]], axis=-2) * per_scale
    alike = kernel(model, z, z)
    inverse = np.linalg.inv(alike[..., :n, :n] + model.nugget * np.eye(n))
    k = alike[..., n, :n]
    row = inverse.sum(axis=-2)
    total = row.sum(axis=-1)
    missing = (1.0 - (row * k).sum(axis=-1)) / total
    explained = (inverse @ k[..., None])[..., 0]
    itself = alike[..., n, n] + model.nugget
    variance = np.maximum(itself - (explained * k).sum(axis=-1) + missing**2 * total, 0.0)
    weights = explained + row * missing[..., None]
    return weights, variance, inverse - row[..., :, None] * row[..., None, :] / total[..., None, None]


def believed(wanted: Array, own: Array) -> Array:
    """Wanted deviations (..., m, D), shortened to where the demonstrations' own (..., n, m, D) say something.

    A robot that always starts at home, to a hair, says nothing about how it would start elsewhere: its noise
    must not be extrapolated.
    """
    limit = BELIEVED * np.sqrt((own**2).sum(axis=-1).mean(axis=-2)) + ROUNDING
    size = np.maximum(np.sqrt((wanted**2).sum(axis=-1)), limit)
    return wanted * (limit / size)[..., None]


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
    corrected = _correct(model, curves, nodes, asked)
    weights, variance, q = weigh(model, corrected.own, corrected.wanted)
    errors = np.tensordot(q, corrected.residuals, axes=1) * np.sqrt(variance / q.diagonal())[:, None, None]
    errors[:, nodes] = 0.0
    return _through(corrected, weights, nodes, asked), errors


@dataclass(frozen=True)
class _Corrected:
    """What the correction toward the conditions makes of demonstrations.

    Attributes:
        mean: (..., n_phases, D), corrected.
        residuals: (..., n, n_phases, D), what it leaves of each demonstration.
        own, wanted: (..., n, C) and (..., C), conditions of the demonstrations and of the route.
        linear: (n_phases, m), the correction linear in phase.
    """

    mean: Array
    residuals: Array
    own: Array
    wanted: Array
    linear: Array


def _correct(model: RouteModel, curves: Array, nodes: IntArray, asked: Array) -> _Corrected:
    """Of demonstrations (..., n, n_phases, D) toward asked states (..., m, D)."""
    mean = curves.mean(axis=-3)
    deviations = curves - mean[..., None, :, :]
    linear = hats(curves.shape[-2], nodes)
    alpha = corrections(deviations, nodes, linear, model.ridge) if model.learnt else linear
    own = deviations[..., nodes, :]
    wanted = believed(asked - mean[..., nodes, :], own)
    residuals = deviations - alpha[..., None, :, :] @ own
    flat = (own.reshape(*own.shape[:-2], -1), wanted.reshape(*wanted.shape[:-2], -1))
    return _Corrected(mean + alpha @ wanted, residuals, *flat, linear)


def _through(corrected: _Corrected, weights: Array, nodes: IntArray, asked: Array) -> Array:
    """The route (..., n_phases, D) through the asked states, by weights (..., n) of what the correction leaves."""
    each = corrected.residuals.reshape(*weights.shape, -1)
    route = corrected.mean + (weights[..., None, :] @ each).reshape(corrected.mean.shape)
    return route + corrected.linear @ (asked - route[..., nodes, :])


def left_out_errors(models: Sequence[RouteModel], curves: Array) -> Array:
    """Mean log distance of each model's routes to the demonstrations, each planned from the others: (n_models,)."""
    nodes = np.array([0, curves.shape[1] - 1])
    which = np.unique(np.linspace(0, len(curves) - 1, MOST_LEFT_OUT).astype(np.intp))
    at_once = max(1, AT_ONCE // curves.size)
    parts = [which[i : i + at_once] for i in range(0, len(which), at_once)]
    logs = [np.log(_left_out_distances(models, curves, part, nodes) + ROUNDING) for part in parts]
    return np.concatenate(logs, axis=1).mean(axis=1)


def _left_out_distances(models: Sequence[RouteModel], curves: Array, left_out: IntArray, nodes: IntArray) -> Array:
    """Mean distances (len(models), m) of routes to the demonstrations that are left out (m,), one at a time."""
    rows = np.arange(len(curves))
    others = curves[np.stack([rows[rows != i] for i in left_out])]
    truths = curves[left_out]
    asked = truths[:, nodes]
    # Models that correct alike differ in weights only.
    kinds = {(model.learnt, model.ridge): model for model in models}
    corrected = {kind: _correct(model, others, nodes, asked) for kind, model in kinds.items()}
    distances = []
    for model in models:
        alike = corrected[model.learnt, model.ridge]
        route = _through(alike, weigh(model, alike.own, alike.wanted)[0], nodes, asked)
        distances.append(np.sqrt(((route - truths) ** 2).sum(axis=-1)).mean(axis=-1))
    return np.array(distances)


def stretches(curves: Array) -> list[Array]:
    """The whole and three halves: what is asked later, and more evidence than the whole alone."""
    half = curves.shape[1] // 2
    return [curves, curves[:, : half + 1], curves[:, half // 2 : -(half // 2)], curves[:, half:]]


def choose(curves: Array) -> RouteModel:
    """The usual model, or the one that leaving out a demonstration clearly prefers.

    Args:
        curves: (n, n_phases, D), scaled to unit rms radius.
    """
    if len(curves) < 3:
        return ENDS_LEARNT
    parts = stretches(curves)
    errors = np.mean([left_out_errors(MODELS, part) for part in parts], axis=0)
    clear = errors <= errors[0] - CLEARLY
    return MODELS[int(np.where(clear, errors, np.inf).argmin())]


def for_whole(model: RouteModel) -> RouteModel:
    """The same model where nothing is known but the ends of a whole motion."""
    return USUAL_WHOLE if model == USUAL else model
