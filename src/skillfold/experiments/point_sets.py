"""Surfaces with known equations, as point clouds without order: sphere, circle and the "plane" of ECoMaNN.

The plane is the joint space of a planar arm of three unit links whose tip is held at height 1.5
(cos q₀ + cos(q₀+q₁) + cos(q₀+q₁+q₂) = 1.5): a closed surface. Each set tells the signed residual of its
equation and the distance to its closest point, and draws samples of its own or loads the published ones.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from skillfold.errors import InputError
from skillfold.motion import Array

HEIGHT = 1.5
HIGHEST_ANGLE = np.arccos(HEIGHT - 2.0)  # no link may lean further: the other two reach 2 at most


@dataclass(frozen=True)
class PointSet:
    """A surface in three dimensions.

    Attributes:
        name: of the set.
        dim: its intrinsic dimension.
        file: of its published samples, below `ecomann/`.
        residual: (N, 3) states to the (N,) value of the equation, in its own unit.
        distance: (N, 3) states to their (N,) true distances from the surface.
        draw: a count and a generator to samples (count, 3), about uniform by area.
    """

    name: str
    dim: int
    file: str
    residual: Callable[[Array], Array]
    distance: Callable[[Array], Array]
    draw: Callable[[int, np.random.Generator], Array]

    def samples(self, count: int, rng: np.random.Generator, data: Path | None) -> Array:
        """`count` samples: of the published set where a data folder is given, else drawn."""
        if data is None:
            return self.draw(count, rng)
        file = data / "ecomann" / self.file
        if not file.is_file():
            raise InputError(f"{file}: no such file; the data folder must hold ecomann/{self.file}.")
        points = np.load(file, allow_pickle=False).astype(float)
        return points[rng.permutation(len(points))[:count]]


def sphere_residual(x: Array) -> Array:
    """|x| − 1."""
    return np.linalg.norm(x, axis=-1) - 1.0


def circle_residual(x: Array) -> Array:
    """Distance from the unit circle of the plane z = 0: two equations, one number."""
    return np.hypot(np.hypot(x[..., 0], x[..., 1]) - 1.0, x[..., 2])


def plane_residual(q: Array) -> Array:
    """Height of the tip above 1.5."""
    return np.cos(np.cumsum(q, axis=-1)).sum(-1) - HEIGHT


def plane_gradient(q: Array) -> Array:
    """Derivative of `plane_residual`, (..., 3)."""
    return -np.flip(np.cumsum(np.flip(np.sin(np.cumsum(q, axis=-1)), -1), -1), -1)


def plane_distance(x: Array, starts: int = 6) -> Array:
    """Distance to the closest point of the surface, by Newton steps from the nearest of many points on it."""
    cloud, tree = _plane_cloud()
    nearest = np.asarray(tree.query(x, k=starts)[1]).reshape(len(x), starts)
    feet = cloud[nearest].reshape(-1, 3)
    targets = np.repeat(x, starts, axis=0)
    for _ in range(30):
        feet = _toward_foot(feet, targets)
    gaps = np.linalg.norm(feet - targets, axis=1)
    good = (np.abs(plane_residual(feet)) < 1e-9) & _on_component(feet)
    best = np.where(good, gaps, np.inf).reshape(-1, starts).min(axis=1)
    # A point of the cloud itself lies on the surface: never worse than it.
    return np.minimum(best, np.linalg.norm(cloud[nearest[:, 0]] - x, axis=1))


def _toward_foot(feet: Array, targets: Array) -> Array:
    """One Newton step on: minimise |foot − target|² subject to residual(foot) = 0.

    The tangential part uses the surface's curvature where that keeps the problem convex, else a plain step.
    """
    gradient, residual = plane_gradient(feet), plane_residual(feet)
    squared = np.sum(gradient**2, axis=1)
    multiplier = np.sum(gradient * (targets - feet), axis=1) / squared
    hessian = np.eye(3) + multiplier[:, None, None] * _plane_hessian(feet)
    convex = np.linalg.eigvalsh(hessian)[:, 0] > 0.05
    hessian[~convex] = np.eye(3)
    pull = targets - feet
    from_pull, from_gradient = np.moveaxis(np.linalg.solve(hessian, np.stack([pull, gradient], -1)), -1, 0)
    along = (np.sum(gradient * from_pull, axis=1) + residual) / np.sum(gradient * from_gradient, axis=1)
    step = from_pull - along[:, None] * from_gradient
    length = np.linalg.norm(step, axis=1, keepdims=True)
    return feet + step * np.minimum(1.0, 0.1 / np.maximum(length, 1e-300))


def _plane_hessian(q: Array) -> Array:
    behind = -np.flip(np.cumsum(np.flip(np.cos(np.cumsum(q, axis=-1)), -1), -1), -1)
    return behind[:, np.maximum.outer(np.arange(3), np.arange(3))]


def _on_component(q: Array) -> np.ndarray:
    """Whether the link angles are those of the closed surface around 0, not of a copy a turn away."""
    return (np.abs(np.cumsum(q, axis=1)) <= HIGHEST_ANGLE + 1e-6).all(axis=1)


@cache
def _plane_cloud() -> tuple[Array, KDTree]:
    cloud = draw_plane(40_000, np.random.default_rng(0))
    return cloud, KDTree(cloud)


def draw_sphere(count: int, rng: np.random.Generator) -> Array:
    """Uniform on the unit sphere."""
    x = rng.standard_normal((count, 3))
    return x / np.linalg.norm(x, axis=1, keepdims=True)


def draw_circle(count: int, rng: np.random.Generator) -> Array:
    """Uniform on the unit circle of the plane z = 0."""
    angle = rng.uniform(0, 2 * np.pi, count)
    return np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])


def draw_plane(count: int, rng: np.random.Generator) -> Array:
    """About uniform by area: uniform in a thin shell around the surface, then along the gradient onto it."""
    kept = np.empty((0, 3))
    while len(kept) < count:
        q = rng.uniform(-1, 1, (20 * count, 3)) * [HIGHEST_ANGLE, 2.7, 2.7]
        near = np.abs(plane_residual(q)) < 0.1 * np.linalg.norm(plane_gradient(q), axis=1)
        q = _onto_plane(q[near])
        kept = np.concatenate([kept, q[_on_component(q)]])
    return kept[:count]


def _onto_plane(q: Array) -> Array:
    for _ in range(10):
        gradient = plane_gradient(q)
        q = q - (plane_residual(q) / np.sum(gradient**2, axis=1))[:, None] * gradient
    return q[np.abs(plane_residual(q)) < 1e-12]


SPHERE = PointSet(
    "sphere",
    2,
    "synthetic_unit_sphere_wo_noise.npy",
    sphere_residual,
    lambda x: np.abs(sphere_residual(x)),
    draw_sphere,
)
CIRCLE = PointSet("circle", 1, "circle_loop.npy", circle_residual, circle_residual, draw_circle)
PLANE = PointSet("plane", 2, "3dof_v2_traj.npy", plane_residual, plane_distance, draw_plane)
SETS = (SPHERE, PLANE, CIRCLE)
