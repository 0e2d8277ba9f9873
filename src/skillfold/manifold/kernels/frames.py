"""The surface's own tangents along a path, for where those of the field lie across it.

The field is learnt from far fewer numbers than the surface. Where it is steep it may turn away from it by a right
angle; then a displacement across the one is a displacement along the other, and no iteration on both gets anywhere.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import inlined, inner
from skillfold.manifold.kernels.scratch import Scratch
from skillfold.manifold.kernels.small import copy, orthonormalise
from skillfold.manifold.kernels.surface import REACH, Indices, Surface
from skillfold.manifold.kernels.tangents import remove_tangential

Array = np.ndarray[Any, np.dtype[np.float64]]


class Frames(NamedTuple):
    """What is kept of a path of n states, and memory that it is worked out in.

    Attributes:
        frames: (n, d, D) orthonormal rows, the blended tangents of the anchors; they turn with the states.
        turned: (d, D).
        components: (d, d) of a frame's rows along the tangents of an anchor.
        monomials, slopes: (P,) at a state and (d, P) along a frame's rows.
    """

    frames: Array
    turned: Array
    components: Array
    monomials: Array
    slopes: Array


@inner
def make_frames(surface: Surface, d: int, n: int) -> Frames:
    """Room for n states on a surface of dimension d."""
    D, P = surface.points.shape[0], surface.parents.size
    turned, components = np.empty((d, D)), np.empty((d, d))
    return Frames(np.zeros((n, d, D)), turned, components, np.empty(P), np.zeros((d, P)))


@inner
def follow_surface(surface: Surface, states: Array, fresh: bool, scratch: Scratch, f: Frames) -> None:
    """Tangents of the surface at states (n, D), and displacements across them, instead of what `evaluate` found.

    They span what the slopes of the blended polynomials make of a frame. That frame is the blend of the anchors'
    tangent planes, found by turning the frame of the iteration before toward it: so it does not jump where another
    anchor becomes the nearest. `fresh` is for the first time, when there is none yet.
    """
    s = scratch
    for i in range(len(states)):
        frame = f.frames[i]
        if fresh:
            copy_tangents(surface.charts[s.nearest[i, 0]], frame)
        turn(surface, s.nearest[i], s.weights[i], frame, f)
        s.normals[i] = 0.0
        s.bases[i] = 0.0
        for j in range(s.weights.shape[1]):
            add_slopes(surface, s.nearest[i, j], s.weights[i, j], states[i], frame, s.normals[i], s.bases[i], s, f)
        orthonormalise(s.bases[i])
    remove_tangential(s.bases[: len(states)], s.normals, s.along)


@inlined
def copy_tangents(chart: Array, out: Array) -> None:
    """Copy the tangents (d, D) of an anchor out of its chart."""
    d, D = out.shape
    for a in range(d):
        for c in range(D):
            out[a, c] = chart[1 + c, a]


@inlined
def copy_frame(source: Array, out: Array) -> None:
    """Copy rows (d, D)."""
    for a in range(len(source)):
        copy(source[a], out[a])


@inlined
def turn(surface: Surface, nearest: Indices, weights: Array, frame: Array, f: Frames) -> None:
    """Frame ← an orthonormal basis of Σ_j w_j Π_j frame, with Π_j onto the tangent plane of the anchor nearest[j]."""
    d, D = frame.shape
    f.turned[:] = 0.0
    for j in range(weights.size):
        chart, weight = surface.charts[nearest[j]], weights[j] * surface.radii[nearest[j]] ** 2
        for b in range(d):
            for a in range(d):
                s = 0.0
                for c in range(D):
                    s += chart[1 + c, a] * frame[b, c]
                for c in range(D):
                    f.turned[b, c] += weight * s * chart[1 + c, a]
    copy_frame(f.turned, frame)
    orthonormalise(frame)


@inlined
def add_slopes(
    surface: Surface,
    anchor: int,
    weight: float,
    state: Array,
    frame: Array,
    normal: Array,
    basis: Array,
    scratch: Scratch,
    f: Frames,
) -> None:
    """Add an anchor's share of the displacement (D,), and of what its slopes make of a frame (d, D)."""
    u, monomials, slopes = scratch.along, f.monomials, f.slopes
    parents, factors, chart, map_back = surface.parents, surface.factors, surface.charts[anchor], surface.maps[anchor]
    (d, D), reach = frame.shape, 0.0
    for a in range(d):
        u[a] = 0.0
        for c in range(D):
            u[a] += chart[1 + c, a] * (state[c] - surface.rows[anchor, c])
        reach += u[a] ** 2
        for b in range(d):
            f.components[a, b] = 0.0
            for c in range(D):
                f.components[a, b] += chart[1 + c, a] * frame[b, c]
    beyond = max(math.sqrt(reach) / REACH, 1.0)
    for a in range(d):
        u[a] /= beyond
    monomials[0] = 1.0
    for p in range(1, parents.size):
        monomials[p] = monomials[parents[p]] * u[factors[p]]
        for b in range(d):
            along = f.components[factors[p], b]
            slopes[b, p] = slopes[b, parents[p]] * u[factors[p]] + monomials[parents[p]] * along
    for p in range(1, parents.size):
        monomials[p] *= 1.0 + surface.degrees[p] * (beyond - 1.0)
    for c in range(D):
        s = 0.0
        for p in range(monomials.size):
            s += map_back[1 + p, c] * monomials[p]
        normal[c] += weight * (state[c] - surface.rows[anchor, c] - s)
        for b in range(d):
            s = 0.0
            for p in range(monomials.size):
                s += map_back[1 + p, c] * slopes[b, p]
            basis[b, c] += weight * s
