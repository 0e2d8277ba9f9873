"""The modelled surface and the tangent field at states: what every loop of this family is made of.

`evaluate` takes a batch, in stages that loop over it: to hand a model's many arrays to a function counts references
to each of them, which takes longer than the work at one state. Scratch memory is made once by whoever loops;
nothing is allocated here.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import inlined, inner
from skillfold.manifold.kernels.neighbours import nearest_anchors
from skillfold.manifold.kernels.tangents import remove_tangential, tangent_bases

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

BLENDED = 8  # anchors blended into one surface; the next one sets the width of the blend
REACH = 1.5  # beyond this many radii a local polynomial goes on along its tangent
AROUND = 16  # anchors that are known around a state: while it hardly moves, the nearest are among them
STARTS = 4  # anchors from which a far state is projected, besides the state itself


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


class Scratch(NamedTuple):
    """What `evaluate` finds at n states, and memory that it works in.

    Attributes:
        nearest, squares: (n, m + 1) nearest anchors of each state, sorted, and their squared distances; m blended.
        normals: (n, D) displacements from the surface.
        bases: (n, d, D) orthonormal rows, H's tangents.
        doubts: (n,) how far the blended anchors disagree.
        around, around_squares, origins, known: (n, K), (1, K), (n, D) and (n,), see `nearest_anchors`.
        distances: (M,), squared, from the last state whose anchors were looked for among all.
        starts, start_squares: (s,) anchors from which a far state is projected.
    """

    nearest: Indices
    squares: Array
    normals: Array
    bases: Array
    doubts: Array
    around: Indices
    around_squares: Array
    origins: Array
    known: Array
    distances: Array
    starts: Indices
    start_squares: Array
    weights: Array
    offset: Array
    along: Array
    values: Array
    monomials: Array
    features: Array


@inner
def make_scratch(surface: Surface, field: Field, n: int) -> Scratch:
    """Room for evaluations at n states."""
    D, M = surface.points.shape
    d = field.weights.shape[0]
    m = min(BLENDED, M - 1)
    K = min(AROUND, M)
    around = np.empty((n, K), np.int64)
    for j in range(K):
        around[:, j] = j
    return Scratch(
        np.empty((n, m + 1), np.int64),
        np.empty((n, m + 1)),
        np.zeros((n, D)),
        np.zeros((n, d, D)),
        np.zeros(n),
        around,
        np.empty((1, K)),
        np.zeros((n, D)),
        np.zeros(n),
        np.empty(M),
        np.zeros(min(STARTS, M), np.int64),
        np.empty(min(STARTS, M)),
        np.empty((n, m)),
        np.empty(D),
        np.empty(d),
        np.empty(surface.parents.size),
        np.zeros(surface.bends.shape[2]),
        np.empty(field.centres.shape[1]),
    )


@inner
def evaluate(surface: Surface, field: Field, states: Array, scratch: Scratch) -> None:
    """Displacements from the modelled surface to states (n, D), and H's tangents there, into scratch.

    The nearest anchors' surfaces are blended. Their normals differ a little: what of the blend lies along H's
    tangents is taken off, else an iteration on it would creep along the surface.
    """
    s = scratch
    n = len(states)  # scratch may have room for more
    find_nearest(surface, states, s)
    blend(s.squares[:n], s.weights)
    displace(
        surface.rows,
        surface.tangents,
        surface.bends,
        surface.parents,
        surface.factors,
        surface.degrees,
        states,
        s.nearest,
        s.weights,
        s.offset,
        s.along,
        s.values,
        s.monomials,
        s.normals,
        s.doubts,
    )
    tangent_bases(field.centres, field.precision, field.weights, states, s.features, s.bases)
    remove_tangential(s.bases[:n], s.normals, s.along)


@inlined
def find_nearest(surface: Surface, states: Array, scratch: Scratch) -> None:
    """The nearest anchors of states (n, D), sorted, into scratch.nearest and their squares into scratch.squares."""
    nearest_anchors(
        surface.points,
        surface.rows,
        surface.neighbours,
        surface.reaches,
        states,
        scratch.distances,
        scratch.nearest,
        scratch.squares,
        scratch.around,
        scratch.around_squares,
        scratch.origins,
        scratch.known,
    )


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
