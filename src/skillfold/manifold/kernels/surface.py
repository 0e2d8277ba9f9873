"""The modelled surface and the tangent field: what they consist of, and displacements from the surface."""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import inlined

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

BLENDED = 8  # anchors blended into one surface; the next one sets the width of the blend
REACH = 1.5  # beyond this many radii a local polynomial goes on along its tangent


class Surface(NamedTuple):
    """The modelled surface: one local polynomial v(u) at each anchor, blended.

    Attributes:
        points: (D, M) anchors, one row a coordinate, so that distance loops run over anchors.
        rows: (M, D) the same, one row an anchor.
        tangents: (M, d, D) orthonormal rows that span the tangent space at the anchor, divided by its radius.
        bends: (M, D, P) coefficients that take the monomials of u / radius to u and v(u) together, as an offset from
            the anchor; filled up with zeros to a length that loops over them like.
        neighbours: (M, L) each anchor's nearest anchors, itself first; L = 0 where asking all is as fast.
        reaches: (M,) distance of the last of them; infinite where all anchors are listed.
        radii: (M,) of the neighbourhoods the polynomials were fitted to.
        parents, factors, degrees: (P,) layout of the monomials.
    """

    points: Array
    rows: Array
    tangents: Array
    bends: Array
    neighbours: Indices
    reaches: Array
    radii: Array
    parents: Indices
    factors: Indices
    degrees: Indices


class Field(NamedTuple):
    """The tangent field H(x) = Σ_k f_k(x) W_k with normalised radial basis features (section III-C).

    Attributes:
        centres: (D, K).
        precision: 1 / (2 σ²).
        weights: (d, D, K).
    """

    centres: Array
    precision: float
    weights: Array


class Trust(NamedTuple):
    """How far the surface is believed, in inner coordinates.

    Attributes:
        spacing: usual distance of a sample from the nearest anchor; farther out nothing was demonstrated.
        doubt: disagreement between anchors that is usual at the anchors themselves.
        cap: longest single step of a projection.
        sure: (M,) anchors at which the doubt is no larger.
        ghost: disagreement from which on anchors speak of different sheets: a small displacement then means nothing.
    """

    spacing: float
    doubt: float
    cap: float
    sure: Flags
    ghost: float


@inlined
def blend(squares: Array, weights: Array) -> None:
    """Weights (n, m) of the nearest anchors: Wendland's in d² - d²_min, local far from the data too; sum 1."""
    m = weights.shape[1]
    for i in range(len(squares)):
        width = squares[i, m] - squares[i, 0]
        total = 0.0
        for j in range(m):
            r = math.sqrt((squares[i, j] - squares[i, 0]) / width) if width > 0.0 else 0.0
            weights[i, j] = (1.0 - r) ** 4 * (4.0 * r + 1.0)
            total += weights[i, j]
        for j in range(m):
            weights[i, j] /= total


@inlined
def displace(
    rows: Array,
    tangents: Array,
    bends: Array,
    parents: Indices,
    factors: Indices,
    degrees: Indices,
    states: Array,
    nearest: Indices,
    weights: Array,
    offset: Array,
    along: Array,
    values: Array,
    monomials: Array,
    normals: Array,
    doubts: Array,
) -> None:
    """Blend of the displacements from each anchor's own surface, into normals (n, D), and its spread into doubts."""
    n, D = states.shape
    d, P = along.size, values.size
    for i in range(n):
        for c in range(D):
            normals[i, c] = 0.0
        mean_square, square = 0.0, 0.0
        for j in range(weights.shape[1]):
            anchor, weight = nearest[i, j], weights[i, j]
            for c in range(D):
                offset[c] = states[i, c] - rows[anchor, c]
            reach = 0.0
            for a in range(d):
                s = 0.0
                for c in range(D):
                    s += tangents[anchor, a, c] * offset[c]
                along[a] = s
                reach += s * s
            beyond = 1.0
            if reach > REACH**2:
                beyond = math.sqrt(reach) / REACH
                for a in range(d):
                    along[a] /= beyond
            monomials[0] = 1.0
            for p in range(1, P):
                # An index that may be negative would be looked at each time.
                monomials[p] = monomials[np.uint64(parents[p])] * along[np.uint64(factors[p])]
            if beyond > 1.0:
                # By homogeneity a monomial of degree g goes on along the ray with slope g: no blow-up far out.
                for p in range(1, P):
                    monomials[p] *= 1.0 + degrees[p] * (beyond - 1.0)
            # Three rows at a time, so that the monomials are loaded once for them.
            c = 0
            while c + 2 < D:
                s0, s1, s2 = 0.0, 0.0, 0.0
                for p in range(monomials.size):
                    value = monomials[p]
                    s0 += bends[anchor, c, p] * value
                    s1 += bends[anchor, c + 1, p] * value
                    s2 += bends[anchor, c + 2, p] * value
                offset[c] -= s0
                offset[c + 1] -= s1
                offset[c + 2] -= s2
                c += 3
            while c < D:
                s = 0.0
                for p in range(monomials.size):
                    s += bends[anchor, c, p] * monomials[p]
                offset[c] -= s
                c += 1
            for c in range(D):
                mean_square += weight * offset[c] ** 2
                normals[i, c] += weight * offset[c]
        for c in range(D):
            square += normals[i, c] ** 2
        doubts[i] = math.sqrt(max(mean_square - square, 0.0))
