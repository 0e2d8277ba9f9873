"""The tangent field H(x) of section III: several starts, alternating least squares, and the best one to the end."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.manifold.descent import descend
from skillfold.manifold.features import Features
from skillfold.manifold.training import Problem, alignment, alternate, field_at_edges, objective, smoothness_matrix

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

ITERATIONS = 200  # of the descent, at most
ALTERNATIONS = 3  # that each start gets before the best goes on


@dataclass(frozen=True)
class TangentField:
    """H(x) = Σ_k f_k(x) W_k.

    Attributes:
        features: the K radial basis functions.
        weights: (d, K, D).
        objective: value per edge at the end of training.
        converged: whether training met its stop rule.
        iterations: that the descent took.
    """

    features: Features
    weights: Array
    objective: float
    converged: bool
    iterations: int

    def __call__(self, x: Array) -> Array:
        """H at x (..., D): (..., D, d), not orthonormal."""
        return np.einsum("...k,akc->...ca", self.features(x), self.weights)

    def residual(self, midpoints: Array, steps: Array) -> Array:
        """Part of each step (E, D) that H at its midpoint (E, D) does not span; (E,)."""
        basis = np.linalg.qr(self(midpoints))[0]
        inside = np.einsum("eca,ec->ea", basis, steps)
        return np.linalg.norm(steps - np.einsum("eca,ea->ec", basis, inside), axis=1)


def regress(problem: Problem, frames: Array) -> Array:
    """Weights whose field is nearest to given frames (E, D, d)."""
    f = problem.values
    gram = f.T @ f + 1e-6 * len(f) / f.shape[1] * np.eye(f.shape[1])
    right = f.T @ frames.reshape(len(f), -1)
    return np.linalg.solve(gram, right).reshape(f.shape[1], *frames.shape[1:]).transpose(2, 0, 1)


def pose(features: Features, samples: Array, edges: Indices, ridge: float) -> tuple[Problem, float]:
    """What is to be minimised on the edges, and the scale that the steps were divided by."""
    first, second = samples[edges[:, 0]], samples[edges[:, 1]]
    steps = second - first
    scale = float(np.sqrt((steps**2).mean())) or 1.0
    values = features((first + second) / 2)
    return Problem(values, steps / scale, smoothness_matrix(values, edges, len(samples)), ridge), scale


def _value(problem: Problem, weights: Array) -> float:
    eps, misfit = alignment(field_at_edges(problem, weights), problem.steps, problem.ridge)
    return objective(problem, weights, eps, misfit)


def train(
    features: Features,
    samples: Array,
    edges: Indices,
    frames: Array,
    ridge: float,
    seed: int,
    iterations: int = ITERATIONS,
    restarts: int = 2,
) -> TangentField:
    """Train H on the edges (E, 2) of samples (N, D).

    Args:
        features: where and how wide the basis functions are.
        samples: (N, D), denoised.
        edges: (E, 2) pairs of neighbouring samples.
        frames: (N, D, d) aligned tangents at the samples, the first start.
        ridge: λ, for steps scaled to unit rms (its meaning depends on that scale).
        seed: of the random start.
        iterations: at most so many.
        restarts: 0 to 2 further starts: constant principal directions, steps of random edges.
    """
    problem, scale = pose(features, samples, edges, ridge)
    d = frames.shape[2]
    constant = np.linalg.svd(samples - samples.mean(0), full_matrices=False)[2][:d]
    # Drawn from the steps themselves, so that turning the data turns the start with them.
    drawn = np.random.default_rng(seed).integers(len(edges), size=(d, len(features.centres)))
    random = problem.steps[drawn]
    starts = [
        regress(problem, (frames[edges[:, 0]] + frames[edges[:, 1]]) / 2),
        np.broadcast_to(constant[:, None, :], random.shape),
        random,
    ][: 1 + restarts]
    trials = [alternate(problem, start, ALTERNATIONS) for start in starts]
    best = min(trials, key=lambda weights: _value(problem, weights)) if restarts else trials[0]
    weights, values, converged = descend(problem, best, iterations)
    return TangentField(features, weights * scale, values[-1], converged, len(values) - 1)
