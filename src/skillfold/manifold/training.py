"""The function that training of the tangent field decreases, and alternating least squares on it.

The paper's equations 6 and 9 drop the regulariser of equation 2, so its iteration need not decrease the
objective. Here both steps minimise the same function, edge by edge with the features at the edge's midpoint:

    Σ_e ‖H(m_e) ε_e − Δ_e‖² + λ Σ_e ‖ε_e‖² + λ Σ_{e, e' sharing a sample} ‖H(m_e) − H(m_e')‖²
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import get_lapack_funcs
from scipy.sparse import csr_matrix

from skillfold.manifold.kernels.alignment import align_steps

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

JITTER = 1e-12  # of the trace, on the diagonal of normal equations
FLOOR = 1e-6  # of the gauge's eigenvalues; a too large d makes it singular

# What is laid around LAPACK elsewhere takes longer than it takes for small systems.
_potrf, _potrs = get_lapack_funcs(("potrf", "potrs"), dtype=np.float64)


@dataclass(frozen=True)
class Problem:
    """What stays fixed while H is trained; arrays end in the edges, so that loops over these are loops over memory.

    Attributes:
        values: (K, E) features at the midpoints of the edges, and at the samples of steps along tangents.
        steps: (D, E) along the edges, of unit rms, and some short ones along local tangents.
        smoothness: (K, K), see `smoothness_matrix`.
        ridge: λ.
    """

    values: Array
    steps: Array
    smoothness: Array
    ridge: float


def smoothness_matrix(values: Array, edges: Indices, n_samples: int) -> Array:
    """L with Σ_{e, e' sharing a sample} ‖H(m_e) − H(m_e')‖² = tr(W' L W) for each column of H; (K, K).

    Args:
        values: (E, K) features at the edges.
        edges: (E, 2).
        n_samples: N.
    """
    degree = np.bincount(edges.ravel(), minlength=n_samples)
    weight = degree[edges].sum(1)
    incidence = csr_matrix(
        (np.ones(edges.size), edges.ravel(), 2 * np.arange(len(edges) + 1)), (len(edges), n_samples)
    )
    sums = incidence.T @ values
    raw = (values * weight[:, None]).T @ values - sums.T @ sums
    eigenvalues, vectors = np.linalg.eigh((raw + raw.T) / 2)
    # Rounding in the difference may leave eigenvalues a little below zero.
    return (vectors * np.maximum(eigenvalues, 0.0)) @ vectors.T


def field_at_edges(values: Array, weights: Array) -> Array:
    """H where the features have values (K, E), by one matrix product: (d, D, E), a column of H is a row here."""
    d, K, D = weights.shape
    return (np.swapaxes(weights, 1, 2).reshape(d * D, K) @ values).reshape(d, D, -1)


def alignment(field: Array, steps: Array, ridge: float) -> tuple[Array, Array]:
    """ε_e = (H'H + λI)⁻¹ H'Δ_e, the corrected equation 6, and what it leaves, Hε − Δ; (d, E) and (D, E)."""
    eps, misfit = np.empty((len(field), steps.shape[1])), np.empty(steps.shape)
    align_steps(field, steps, ridge, eps, misfit)
    return eps, misfit


def solve_weights(problem: Problem, eps: Array) -> Array:
    """Corrected equation 9: one matrix for all D outputs; weights (d, K, D)."""
    (d, E), K = eps.shape, len(problem.values)
    rows = (eps[:, None] * problem.values).reshape(d * K, E)
    gram = rows @ rows.T
    for a in range(d):
        gram[a * K : (a + 1) * K, a * K : (a + 1) * K] += problem.ridge * problem.smoothness
    return solved(factorised(gram), rows @ problem.steps.T).reshape(d, K, -1)


def factorised(matrix: Array) -> Array:
    """Cholesky factor of a symmetric matrix plus the jitter, in its own memory."""
    matrix.flat[:: len(matrix) + 1] += JITTER * np.trace(matrix)
    factor, info = _potrf(matrix.T, clean=False, overwrite_a=True)
    if info:
        raise np.linalg.LinAlgError("Normal equations of the tangent field are not positive definite.")
    return factor


def solved(factor: Array, right: Array) -> Array:
    """Solution of a factorised system for right-hand sides (n, m); (n, m)."""
    return _potrs(factor, right)[0]


def roughness(problem: Problem, weights: Array) -> Array:
    """Smoothness penalty as a (d, d) form, so that H A costs tr(A' B A)."""
    flat = weights.reshape(len(weights), -1)
    return flat @ (problem.smoothness @ weights).reshape(flat.shape).T


def objective(problem: Problem, weights: Array, eps: Array, misfit: Array) -> float:
    """The function that training decreases, per edge; with the misfit Hε − Δ."""
    penalty = np.vdot(eps, eps) + np.vdot(weights, problem.smoothness @ weights)
    return float((np.vdot(misfit, misfit) + problem.ridge * penalty) / eps.shape[1])


def balance(problem: Problem, weights: Array, eps: Array) -> tuple[Array, Array]:
    """The gauge H A, A⁻¹ε in which both penalties weigh the same: AA' = the geometric mean of Σεε' and B⁻¹.

    With B = RR' and R'Σεε'R = USU' it is AA' = R'⁻¹ U S^½ U' R⁻¹. How A is turned on its right makes no difference.
    """
    energy, rough = eps @ eps.T, roughness(problem, weights)
    rough.flat[:: len(rough) + 1] += FLOOR * (np.trace(energy) + np.trace(rough)) + 1e-300
    root = np.linalg.cholesky(rough)
    values, vectors = np.linalg.eigh(root.T @ energy @ root)
    fourth = np.maximum(values, FLOOR * max(values[-1], 1e-300)) ** 0.25
    gauge = np.linalg.solve(root.T, vectors * fourth)
    turned = (gauge.T @ weights.reshape(len(weights), -1)).reshape(weights.shape)
    return turned, (root @ (vectors / fourth)).T @ eps


def alternate(problem: Problem, weights: Array, iterations: int) -> Array:
    """Weights after some iterations of alternating least squares: alignment, gauge, weights."""
    for _ in range(iterations):
        eps = alignment(field_at_edges(problem.values, weights), problem.steps, problem.ridge)[0]
        weights = solve_weights(problem, balance(problem, weights, eps)[1])
    return weights
