"""The tangent field H(x) of section III: a start from local tangents, alternating least squares, and a descent.

The start decides which minimum is found. From constant principal directions or random steps the descent ends up to
500 times higher on closed surfaces, and nowhere more than 15 % lower. Edges of dense recordings may all lie along
these, and say nothing of the directions across: some short steps along the local tangents are shown besides.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.manifold.descent import descend
from skillfold.manifold.features import Features
from skillfold.manifold.training import Problem, alternate, smoothness_matrix

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

ITERATIONS = 200  # of the descent, at most
ALTERNATIONS = 3  # before the descent
EVERY, SHORT = 10, 0.4  # so many edges for one step along a local tangent, which is as long as this share of theirs


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
    K, E = f.shape
    gram = f @ f.T + 1e-6 * E / K * np.eye(K)
    right = f @ frames.reshape(E, -1)
    return np.linalg.solve(gram, right).reshape(K, *frames.shape[1:]).transpose(2, 0, 1)


def pose(
    features: Features, samples: Array, edges: Indices, frames: Array, ridge: float
) -> tuple[Problem, float, Array]:
    """What is to be minimised on the edges, the scale that steps were divided by, and the tangents at all of them."""
    first, second = samples[edges[:, 0]], samples[edges[:, 1]]
    steps = second - first
    scale = float(np.sqrt((steps**2).mean())) or 1.0
    values = features((first + second) / 2)
    smoothness = smoothness_matrix(values, edges, len(samples))
    some = edges[::EVERY, 0]
    turns = np.arange(len(some)) % frames.shape[2]  # of all tangents in turn
    told = SHORT * scale * np.sqrt(samples.shape[1]) * frames[some, :, turns]
    values = np.ascontiguousarray(np.vstack([values, features(samples[some])]).T)
    shown = np.ascontiguousarray(np.vstack([steps, told]).T / scale)
    tangents = np.concatenate([(frames[edges[:, 0]] + frames[edges[:, 1]]) / 2, frames[some]])
    return Problem(values, shown, smoothness, ridge), scale, tangents


def begin(
    features: Features, samples: Array, edges: Indices, frames: Array, ridge: float
) -> tuple[Problem, float, Array]:
    """What is to be minimised, the scale of its steps, and weights to start the descent from.

    Frames (N, D, d) are aligned tangents at the samples.
    """
    problem, scale, tangents = pose(features, samples, edges, frames, ridge)
    return problem, scale, alternate(problem, regress(problem, tangents), ALTERNATIONS)


def train(
    features: Features, samples: Array, edges: Indices, frames: Array, ridge: float, iterations: int = ITERATIONS
) -> TangentField:
    """Train H on the edges (E, 2) of samples (N, D).

    Args:
        features: where and how wide the basis functions are.
        samples: (N, D), denoised.
        edges: (E, 2) pairs of neighbouring samples.
        frames: (N, D, d) aligned tangents at the samples, the start.
        ridge: λ, for steps scaled to unit rms (its meaning depends on that scale).
        iterations: at most so many.
    """
    problem, scale, start = begin(features, samples, edges, frames, ridge)
    weights, values, converged = descend(problem, start, iterations)
    return TangentField(features, weights * scale, values[-1], converged, len(values) - 1)
