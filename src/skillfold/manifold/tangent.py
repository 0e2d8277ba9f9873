"""The tangent field H(x) and its training: section III, with the alternating least squares put right.

The paper's equations 6 and 9 drop the regulariser of equation 2, so its iteration need not decrease the
objective. Here both steps minimise the same function, edge by edge with the features at the edge's midpoint:

    Σ_e ‖H(m_e) ε_e − Δ_e‖² + λ Σ_e ‖ε_e‖² + λ Σ_{e, e' sharing a sample} ‖H(m_e) − H(m_e')‖²
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from skillfold.manifold.features import Features

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

ITERATIONS = 50
SETTLED = 5e-4  # relative decrease of the objective at which training stops
TRIAL_ITERATIONS = 4  # that each start gets before the best goes on
JITTER = 1e-12  # of the trace, on the diagonal of normal equations
FLOOR = 1e-6  # of the gauge's eigenvalues; a too large d makes it singular


@dataclass(frozen=True)
class TangentField:
    """H(x) = Σ_k f_k(x) W_k.

    Attributes:
        features: the K radial basis functions.
        weights: (d, K, D).
        objective: value per edge at the end of training.
        converged: whether training met its stop rule.
        iterations: that training took.
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


@dataclass(frozen=True)
class _Problem:
    """What stays fixed while H is trained: features at midpoints, unit-rms steps, smoothness matrix."""

    values: Array  # (E, K)
    steps: Array  # (E, D)
    smoothness: Array  # (K, K)
    ridge: float


def smoothness_matrix(values: Array, edges: Indices, n_samples: int) -> Array:
    """L with Σ_{e, e' sharing a sample} ‖H(m_e) − H(m_e')‖² = tr(W' L W) for each column of H; (K, K)."""
    degree = np.bincount(edges.ravel(), minlength=n_samples)
    weight = degree[edges].sum(1)
    sums = np.zeros((n_samples, values.shape[1]))
    np.add.at(sums, edges[:, 0], values)
    np.add.at(sums, edges[:, 1], values)
    raw = (values * weight[:, None]).T @ values - sums.T @ sums
    eigenvalues, vectors = np.linalg.eigh((raw + raw.T) / 2)
    # Rounding in the difference may leave eigenvalues a little below zero.
    return (vectors * np.maximum(eigenvalues, 0.0)) @ vectors.T


def alignment(H: Array, steps: Array, ridge: float) -> Array:
    """ε_e = (H'H + λI)⁻¹ H'Δ_e, the corrected equation 6; H (E, D, d), steps (E, D), result (E, d)."""
    turned = np.swapaxes(H, 1, 2)
    gram = turned @ H + ridge * np.eye(H.shape[2])
    return np.asarray(np.linalg.solve(gram, turned @ steps[..., None])[..., 0], dtype=np.float64)


def _solve_weights(problem: _Problem, eps: Array) -> Array:
    """Corrected equation 9: one matrix for all D outputs; weights (d, K, D)."""
    E, K = problem.values.shape
    d = eps.shape[1]
    rows = (eps[:, :, None] * problem.values[:, None, :]).reshape(E, d * K)
    gram = rows.T @ rows + problem.ridge * np.kron(np.eye(d), problem.smoothness)
    gram[np.diag_indices_from(gram)] += JITTER * np.trace(gram)
    return cho_solve(cho_factor(gram), rows.T @ problem.steps).reshape(d, K, -1)


def _field(problem: _Problem, weights: Array) -> Array:
    """H at the midpoints, (E, D, d), by one matrix product."""
    d, K, D = weights.shape
    flat = np.ascontiguousarray(weights.transpose(1, 2, 0)).reshape(K, D * d)
    return (problem.values @ flat).reshape(-1, D, d)


def _roughness(problem: _Problem, weights: Array) -> Array:
    """Smoothness penalty as a (d, d) form, so that H A costs tr(A' B A)."""
    return np.einsum("akc,kl,blc->ab", weights, problem.smoothness, weights, optimize=True)


def objective(problem: _Problem, weights: Array, eps: Array) -> float:
    """The function that training decreases, per edge."""
    misfit = (_field(problem, weights) @ eps[..., None])[..., 0] - problem.steps
    penalty = (eps**2).sum() + np.trace(_roughness(problem, weights))
    return float(((misfit**2).sum() + problem.ridge * penalty) / len(eps))


def _power(matrix: Array, exponent: float) -> Array:
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
    floored = np.maximum(values, FLOOR * max(values[-1], 1e-300))
    return (vectors * floored**exponent) @ vectors.T


def _balance(problem: _Problem, weights: Array, eps: Array) -> tuple[Array, Array]:
    """The gauge H A, A⁻¹ε in which both penalties weigh the same: AA' = the mean of Σεε' and B⁻¹."""
    energy, rough = eps.T @ eps, _roughness(problem, weights)
    rough = rough + FLOOR * np.trace(energy) * np.eye(len(rough))
    root = _power(rough, 0.5)
    gauge = _power(rough, -0.5) @ _power(root @ energy @ root, 0.25)
    turned = np.asarray(np.linalg.solve(gauge, eps.T).T, dtype=np.float64)
    return np.einsum("akc,ab->bkc", weights, gauge), turned


def _train(problem: _Problem, weights: Array, iterations: int) -> tuple[Array, float, bool, int]:
    value, converged, done = np.inf, False, 0
    while done < iterations and not converged:
        done += 1
        eps = alignment(_field(problem, weights), problem.steps, problem.ridge)
        weights, eps = _balance(problem, weights, eps)
        weights = _solve_weights(problem, eps)
        before, value = value, objective(problem, weights, eps)
        converged = before - value <= SETTLED * value
    return weights, value, converged, done


def _regress(problem: _Problem, frames: Array) -> Array:
    """Weights whose field is nearest to given frames (E, D, d)."""
    f = problem.values
    gram = f.T @ f + 1e-6 * len(f) / f.shape[1] * np.eye(f.shape[1])
    return np.einsum("kl,el,eca->akc", np.linalg.inv(gram), f, frames, optimize=True)


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
    first, second = samples[edges[:, 0]], samples[edges[:, 1]]
    steps = second - first
    scale = float(np.sqrt((steps**2).mean())) or 1.0
    values = features((first + second) / 2)
    problem = _Problem(values, steps / scale, smoothness_matrix(values, edges, len(samples)), ridge)
    d = frames.shape[2]
    constant = np.linalg.svd(samples - samples.mean(0), full_matrices=True)[2][:d].T
    # Drawn from the steps themselves, so that turning the data turns the start with them.
    random = problem.steps[np.random.default_rng(seed).integers(len(steps), size=(d, len(features.centres)))]
    starts = [
        _regress(problem, (frames[edges[:, 0]] + frames[edges[:, 1]]) / 2),
        np.broadcast_to(constant.T[:, None, :], random.shape),
        random,
    ][: 1 + restarts]
    trials = [_train(problem, start, TRIAL_ITERATIONS) for start in starts]
    best = min(trials, key=lambda trial: trial[1])
    weights, value, converged, done = best if best[2] else _train(problem, best[0], iterations - TRIAL_ITERATIONS)
    return TangentField(features, weights * scale, value, converged, done)
