"""New states on the manifold, spread evenly over what was demonstrated."""

from typing import Any

import numpy as np
from scipy.spatial import KDTree

from skillfold.manifold.model import Model
from skillfold.manifold.projection import OnManifold, project_anchored

Array = np.ndarray[Any, np.dtype[np.float64]]

ROUNDS = 20  # of drawing before the last draws are taken as they are


def sample_surface(model: Model, n: int, seed: int) -> Array:
    """`n` states (n, D).

    An anchor is drawn with weight (distance to its neighbours)^d, the share of the surface that it stands for; a
    step within that distance along its tangents is projected back. Free directions are drawn as the anchors are.
    """
    rng = np.random.default_rng(seed)
    anchors = model.anchors
    inner_dim = model.dim - model.free.shape[1]
    near = KDTree(anchors).query(anchors, min(inner_dim + 2, len(anchors)))[0][:, -1]
    weights = np.minimum(near, 3.0 * np.median(near)) ** inner_dim
    states = np.empty((0, model.n_dims))
    for _ in range(ROUNDS):
        i = rng.choice(len(anchors), n, p=weights / weights.sum())
        steps = rng.normal(size=(n, inner_dim)) * (near[i] / np.sqrt(inner_dim))[:, None]
        moved = anchors[i] + np.einsum("na,nac->nc", steps * model.surface.radii[i, None], model.surface.tangents[i])
        drawn = model.centre + model.scale * moved @ model.kept.T
        if model.free.shape[1]:
            drawn += rng.uniform(-1.0, 1.0, (n, model.free.shape[1])) * model.free_extent @ model.free.T
        drawn, supported = project_anchored(model, drawn)
        good = supported & (OnManifold(model).inside(drawn) <= 1.0)
        states = np.vstack([states, drawn[good]])
        if len(states) >= n:
            return states[:n]
    rest = rng.choice(len(anchors), n)
    return np.vstack([states, model.centre + model.scale * anchors[rest] @ model.kept.T])[:n]
