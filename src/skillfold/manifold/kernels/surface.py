"""The modelled surface and the tangent field at one state: what every loop of this family is made of.

Scratch memory is made once by whoever loops; nothing is allocated here.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import njit
from skillfold.manifold.kernels.small import orthonormalise, remove_along

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

BLENDED = 8  # anchors blended into one surface; the next one sets the width of the blend
REACH = 1.5  # beyond this many radii a local polynomial goes on along its tangent
STARTS = 4  # anchors from which a far state is projected, besides the state itself


class Surface(NamedTuple):
    """The modelled surface: one local polynomial v(u) at each anchor, blended.

    Attributes:
        points: (D, M) anchors, one row a coordinate, so that distance loops run over anchors.
        frames: (M, D, D) orthonormal rows; the first d span the tangent space at the anchor.
        coefficients: (M, D - d, P) of the polynomial in u / radius.
        radii: (M,) of the neighbourhoods the polynomials were fitted to.
        parents, factors, degrees: (P,) layout of the monomials.
    """

    points: Array
    frames: Array
    coefficients: Array
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
    """

    spacing: float
    doubt: float
    cap: float
    sure: Flags


class Scratch(NamedTuple):
    """Memory that one evaluation of the surface works in.

    After `displacement`, `basis` holds H's tangents there, `doubt[0]` how far the blended anchors disagree.
    """

    distances: Array
    nearest: Indices
    starts: Indices
    start_squares: Array
    squares: Array
    offset: Array
    along: Array
    values: Array
    basis: Array
    features: Array
    doubt: Array


@njit
def make_scratch(surface: Surface, field: Field) -> Scratch:
    """Room for one evaluation of `surface` and `field`."""
    D, M = surface.points.shape
    d = field.weights.shape[0]
    m = min(BLENDED, M - 1) + 1
    return Scratch(
        np.empty(M),
        np.zeros(m, np.int64),
        np.zeros(min(STARTS, M), np.int64),
        np.empty(min(STARTS, M)),
        np.empty(m),
        np.empty(D),
        np.empty(d),
        np.empty(surface.parents.size),
        np.empty((d, D)),
        np.empty(field.centres.shape[1]),
        np.zeros(1),
    )


@njit
def tangent_basis(field: Field, x: Array, features: Array, basis: Array) -> bool:
    """Orthonormal rows (d, D) of H at x into `basis`; False where H lost rank and an axis was put in."""
    D, K = field.centres.shape
    d = field.weights.shape[0]
    features[:] = 0.0
    for c in range(D):
        for k in range(K):
            features[k] += (x[c] - field.centres[c, k]) ** 2
    low = features[0]
    for k in range(1, K):
        low = min(low, features[k])
    total = 0.0
    for k in range(K):
        features[k] = math.exp(-(features[k] - low) * field.precision)
        total += features[k]
    for a in range(d):
        for c in range(D):
            s = 0.0
            for k in range(K):
                s += features[k] * field.weights[a, c, k]
            basis[a, c] = s / total
    return orthonormalise(basis)


@njit
def find_nearest(points: Array, x: Array, scratch: Scratch) -> None:
    """The nearest anchors of x, sorted, into scratch.nearest and their squared distances into scratch.squares."""
    D, M = points.shape
    distances = scratch.distances
    distances[:] = 0.0
    for c in range(D):
        for i in range(M):
            distances[i] += (x[c] - points[c, i]) ** 2
    smallest(distances, scratch.nearest, scratch.squares)


@njit
def smallest(values: Array, indices: Indices, found: Array) -> None:
    """The smallest values, sorted, into `found`, and where they stand into `indices`."""
    m = indices.size
    found[:] = np.inf
    worst = np.inf
    for i in range(values.size):
        if values[i] < worst:
            j = m - 1
            while j > 0 and found[j - 1] > values[i]:
                found[j] = found[j - 1]
                indices[j] = indices[j - 1]
                j -= 1
            found[j] = values[i]
            indices[j] = i
            worst = found[m - 1]


@njit
def add_displacement(surface: Surface, i: int, x: Array, weight: float, scratch: Scratch, total: Array) -> float:
    """Add weight × the displacement from anchor i's surface to x, along that anchor's normals, to `total`."""
    D = x.size
    P = surface.parents.size
    d = D - surface.coefficients.shape[1]
    offset, along, values = scratch.offset, scratch.along, scratch.values
    for c in range(D):
        offset[c] = x[c] - surface.points[c, i]
    square = 0.0
    for a in range(d):
        s = 0.0
        for c in range(D):
            s += surface.frames[i, a, c] * offset[c]
        along[a] = s / surface.radii[i]
        square += along[a] ** 2
    beyond = max(1.0, math.sqrt(square) / REACH)
    values[0] = 1.0
    for j in range(1, P):
        values[j] = values[surface.parents[j]] * along[surface.factors[j]] / beyond
    if beyond > 1.0:
        # By homogeneity a monomial of degree g goes on along the ray with slope g: no blow-up far out.
        for j in range(1, P):
            values[j] *= 1.0 + surface.degrees[j] * (beyond - 1.0)
    length = 0.0
    for n in range(D - d):
        s = 0.0
        for c in range(D):
            s += surface.frames[i, d + n, c] * offset[c]
        for j in range(P):
            s -= values[j] * surface.coefficients[i, n, j]
        length += s**2
        s *= weight
        for c in range(D):
            total[c] += s * surface.frames[i, d + n, c]
    return length


@njit
def displacement(surface: Surface, field: Field, x: Array, scratch: Scratch, normal: Array) -> float:
    """Displacement `normal` from the modelled surface to x; H's tangents at x stay in scratch.basis.

    The nearest anchors' surfaces are blended with Wendland weights in d² - d²_min, which stay local far from the
    data. The anchors' normals differ a little: what of the blend lies along H's tangents is taken off, else an
    iteration on it would creep along the surface. Returns the squared distance to the nearest anchor.
    """
    find_nearest(surface.points, x, scratch)
    squares = scratch.squares
    m = squares.size - 1
    width = squares[m] - squares[0]
    normal[:] = 0.0
    total, mean_square = 0.0, 0.0
    for j in range(m):
        r = math.sqrt((squares[j] - squares[0]) / width) if width > 0.0 else 0.0
        weight = (1.0 - r) ** 4 * (4.0 * r + 1.0)
        if weight > 0.0:
            total += weight
            mean_square += weight * add_displacement(surface, scratch.nearest[j], x, weight, scratch, normal)
    square = 0.0
    for c in range(x.size):
        normal[c] /= total
        square += normal[c] ** 2
    scratch.doubt[0] = math.sqrt(max(mean_square / total - square, 0.0))
    tangent_basis(field, x, scratch.features, scratch.basis)
    remove_along(scratch.basis, normal, scratch.along)
    return squares[0]
