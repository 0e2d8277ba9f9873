"""The phases at which demonstrations are read: equal shares of their length, then where they are alike.

A tremble, a tool that turns on the spot or a wider bend lengthens one stretch of a demonstration and so shifts all
others: at equal shares of length it is ahead of the others here and behind them there. Each is therefore read a
little earlier or later where this brings it nearer to the mean of all, its ends corrected. What is across the way
is left: that is what demonstrations differ by.
"""

import numpy as np
from scipy.ndimage import gaussian_filter1d

from skillfold.manifold.route_location import PHASE_SPREAD
from skillfold.motion import Array

ROUNDS = 3
EVENED = 0.1  # of the way, over which shifts of phase are evened out
ENDS = 0.05  # of the way, over which shifts fade to none at the ends
ROUNDING = 1e-12  # squared speed below which nothing moves


def registered(curves: Array) -> Array:
    """Curves (n, n_phases, D), each read at increasing phases where it is most like the others; its ends stay.

    The shift of a phase is the one that brings a curve along its own tangent nearest to the mean, by least squares
    over neighbouring phases (as optical flow does), and the likeliest where shifts and what curves differ by are
    Gaussian: the less alike curves are, the less they say of phase, and next to nothing where they go several ways.
    Shifts are zero on average over the curves, so that phase remains the share of the length.
    """
    share = np.linspace(0.0, 1.0, curves.shape[1])
    fade = np.minimum(1.0, np.minimum(share, 1.0 - share) / ENDS)
    shift = np.zeros(curves.shape[:2])
    for _ in range(ROUNDS):
        shift += fade * _toward_mean(at_phases(curves, share + shift), share)
        shift -= shift.mean(axis=0)
        shift = np.maximum.accumulate(np.clip(share + shift, 0.0, 1.0), axis=1) - share
    return at_phases(curves, share + shift)


def _toward_mean(curves: Array, share: Array) -> Array:
    """By how much later each curve should be read (n, n_phases)."""
    gap = curves.mean(axis=0) - curves
    gap -= (1.0 - share[:, None]) * gap[:, :1] + share[:, None] * gap[:, -1:]
    along = np.gradient(curves, share, axis=1)
    width = EVENED * len(share)
    pull, speed = (gaussian_filter1d((a * along).sum(axis=2), width, axis=1, mode="nearest") for a in (gap, along))
    unlike = (gap**2).sum(axis=2).mean()
    return pull / (speed + unlike / PHASE_SPREAD**2 + ROUNDING)


def by_arc_length(states: Array, n_phases: int) -> Array:
    """(n_steps, D) to (n_phases, D), equally spaced in arc length.

    A state that repeats the one before is no step of the way, however long the pause. The length is measured over
    chords of a phase or so: over every step, the noise of a robot at rest would look like a long way.
    """
    states = states[np.append(True, (states[1:] != states[:-1]).any(axis=1))]
    n_steps = len(states)
    knots = np.unique(np.linspace(0, n_steps - 1, min(n_steps, n_phases)).astype(np.intp))
    chords = np.linalg.norm(np.diff(states[knots], axis=0), axis=1)
    moving = np.concatenate([[True], chords > 0.0])
    if not moving[1:].any():
        return np.repeat(states[:1], n_phases, axis=0)
    travelled = np.concatenate([[0.0], np.cumsum(chords)])
    wanted = np.linspace(0.0, travelled[-1], n_phases)
    step = np.interp(wanted, travelled[moving], knots[moving])
    return np.stack([np.interp(step, np.arange(n_steps), column) for column in states.T], axis=1)


def at_phases(curves: Array, phases: Array) -> Array:
    """Curves (n, n_phases, D) read at phases (n, points) in [0, 1], each at its own: (n, points, D)."""
    position = phases * (curves.shape[1] - 1)
    below = np.minimum(position.astype(np.intp), curves.shape[1] - 2)
    part = (position - below)[..., None]
    which = np.arange(len(curves))[:, None]
    return (1.0 - part) * curves[which, below] + part * curves[which, below + 1]
