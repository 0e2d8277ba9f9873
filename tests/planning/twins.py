"""Plain NumPy twins of the compiled loops over obstacle points and trees; none calls a kernel."""

import numpy as np


def clearance(points, radius, q):
    """Distance (...,) of q (..., D) from the nearest ball."""
    return np.linalg.norm(np.asarray(q)[..., None, :] - points, axis=-1).min(-1) - radius


def gradient(points, q):
    """The unit vector (D,) from the nearest point to q; nothing at the point itself."""
    away = q - points[np.linalg.norm(points - q, axis=1).argmin()]
    length = np.linalg.norm(away)
    return away / length if length > 1e-12 else np.zeros_like(away)


def within(points, radius, q, reach):
    """Distances (n,) of the balls nearer than `reach`, in their order, and gradients (n, D)."""
    lengths = np.linalg.norm(q - points, axis=1)
    near = lengths - radius < reach
    return lengths[near] - radius, np.array([gradient(point[None], q) for point in points[near]]).reshape(-1, len(q))


def share(points, radius, start, end, margin):
    """Share of the straight edge until it first comes within the margin of a ball: roots of quadratics."""
    way, offsets = end - start, start - points
    a, b, c = way @ way, 2 * offsets @ way, (offsets**2).sum(1) - (radius + margin) ** 2
    if (c <= 0).any():
        return 0.0
    met = (b**2 > 4 * a * c) & (b < 0)
    return ((-b[met] - np.sqrt(b[met] ** 2 - 4 * a * c[met])) / (2 * a)).min(initial=1.0)
