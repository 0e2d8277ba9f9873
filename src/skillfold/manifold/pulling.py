"""Demonstrated routes brought nearer to the manifold, where they lie farther off it than samples do."""

from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from skillfold.manifold.model import Model
from skillfold.manifold.projection import OnManifold, project_anchored

Array = np.ndarray[Any, np.dtype[np.float64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

EVENED = 0.04  # of a path: width over which the pull onto the manifold is evened out
ALONE = 0.25  # states: an evening so narrow leaves each pulled by itself
CLOSER = 0.9  # of the distance allowed before, in each further turn: feet move with the states


def pulled_onto(model: Model, states: Array, given: Array, allowed: Array, enough: float) -> Array:
    """Pull states that are farther off the manifold than is allowed (n,) back toward that distance.

    The pull is evened out along the path and fades to nothing at the given states: neighbours whose feet lie on
    different parts of the surface must not tear the path. Where that leaves a state farther off than is enough, as
    where chords of a recording are off by turns, all are pulled on, in each turn evened out half as far and a little
    closer.
    """
    width = EVENED * len(states)
    while True:
        off = OnManifold(model, float(allowed.min())).distance(states) > allowed
        if not off.any():
            return states
        states = states + _pull(model, states, given, off, allowed[off], width)
        if width < ALONE or OnManifold(model, enough).distance(states).max() <= enough:
            return states
        width, allowed = width / 2.0, CLOSER * allowed


def _pull(model: Model, states: Array, given: Array, off: Flags, allowed: Array, width: float) -> Array:
    """From states (n, D) that are off (n,) toward their feet, up to the distance allowed there, evened out."""
    foot, _ = project_anchored(model, states[off])
    pull = np.zeros_like(states)
    away = np.maximum(np.linalg.norm(states[off] - foot, axis=1), 1e-300)
    pull[off] = np.maximum(1.0 - allowed / away, 0.0)[:, None] * (foot - states[off])
    fixed = np.flatnonzero((states[:, None] == given[None]).all(2).any(1))
    nearest = np.abs(np.arange(len(states))[:, None] - fixed).min(1)
    fade = np.minimum(1.0, nearest / (2.0 * width))[:, None]
    return fade * gaussian_filter1d(pull, width, axis=0, mode="nearest")
