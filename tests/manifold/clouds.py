"""Sample sets whose dimension and free directions are known: (count, D) arrays from a generator."""

import numpy as np

from skillfold.experiments.point_sets import draw_circle, draw_plane, draw_sphere

__all__ = [
    "bay",
    "crease",
    "cylinder",
    "draw_circle",
    "draw_plane",
    "draw_sphere",
    "normalised",
    "rotated",
    "sheet",
    "sphere_of",
    "tori",
    "torus",
]


def torus(count, rng):
    """In three dimensions, radii 1 and 0.4."""
    a, b = rng.uniform(0, 2 * np.pi, (2, count))
    ring = 1 + 0.4 * np.cos(b)
    return np.column_stack([ring * np.cos(a), ring * np.sin(a), 0.4 * np.sin(b)])


def tori(count, rng):
    """Circle × circle in four dimensions."""
    a, b = rng.uniform(0, 2 * np.pi, (2, count))
    return np.column_stack([np.cos(a), np.sin(a), np.cos(b), np.sin(b)])


def sphere_of(D):
    """The unit sphere of D dimensions."""

    def draw(count, rng):
        x = rng.normal(size=(count, D))
        return x / np.linalg.norm(x, axis=1, keepdims=True)

    return draw


def sheet(D, d):
    """A sheet that bends along every one of its d directions, turned at random."""

    def draw(count, rng):
        u = rng.uniform(-1, 1, (count, d))
        bends = rng.choice([-1.0, 1.0], (d, D - d)) * rng.uniform(0.5, 1.0, (d, D - d))
        return rotated(np.hstack([u, u**2 @ bends]), rng)

    return draw


def crease(count, rng, inner=1.0):
    """A sheet in four dimensions with an edge across its middle, smooth on either side."""
    u = inner * rng.uniform(-1, 1, (count, 2))
    return np.column_stack([u, 0.6 * np.maximum(u[:, 0], 0.0), 0.3 * np.sin(2 * u[:, 1])])


def cylinder(free):
    """Circle × as many lines as said, turned at random; also the (free, D) directions of the lines."""

    def draw(count, rng):
        a = rng.uniform(0, 2 * np.pi, count)
        lines = rng.uniform(-1.5, 1.5, (count, free))
        turn = np.linalg.qr(rng.normal(size=(2 + free, 2 + free)))[0]
        return np.column_stack([np.cos(a), np.sin(a), lines]) @ turn.T, turn[:, 2:].T

    return draw


def rotated(x, rng):
    D = x.shape[1]
    return x @ np.linalg.qr(rng.normal(size=(D, D)))[0].T


def normalised(x):
    """Centred, of unit rms radius: as `fit` looks at them."""
    x = x - x.mean(0)
    return x / np.sqrt((x**2).sum(1).mean())


def bay(count, seed=0):
    """Samples (count, 3) of a saddle z = 0.3 x y whose shore y = 0.6 (1 - x²) lets a bay in between two horns."""
    x, y = np.random.default_rng(seed).uniform(-1.0, 1.0, (2, 8 * count))
    ashore = np.flatnonzero(y > 0.6 * (1.0 - x**2))[:count]
    x, y = x[ashore], y[ashore]
    return np.stack([x, y, 0.3 * x * y], axis=1)
