"""Smooth manifolds of any dimension to measure times on."""

import numpy as np

from skillfold.motion import Array


def smooth_manifold(count: int, n_dims: int, dim: int, rng: np.random.Generator) -> Array:
    """(count, n_dims) samples A u + 0.3 sin(B u + c), u uniform in [−1, 1]^dim, columns of A orthonormal."""
    u = rng.uniform(-1.0, 1.0, (count, dim))
    A = np.linalg.qr(rng.standard_normal((n_dims, dim)))[0]
    B = rng.standard_normal((n_dims, dim))
    return u @ A.T + 0.3 * np.sin(u @ B.T + rng.uniform(0, 2 * np.pi, n_dims))


def noisy_sphere(count: int, noise: float, rng: np.random.Generator) -> Array:
    """(count, 3) samples of the unit sphere with isotropic Gaussian noise."""
    x = rng.standard_normal((count, 3))
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return x + noise * rng.standard_normal(x.shape)
