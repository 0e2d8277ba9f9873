"""The modelled surface and the tangent field: what they consist of, and displacements from the surface."""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import inlined
from skillfold.lanes import LANES, load, spread, store

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

BLENDED = 8  # anchors blended into one surface, two times four; the next one sets the width of the blend
REACH = 1.5  # beyond this many radii a local polynomial goes on along its tangent


class Surface(NamedTuple):
    """The modelled surface: one local polynomial v(u) at each anchor, blended.

    Rows that loops take four numbers at a time (see `lanes`) are filled up with zeros: to e numbers, and to E.

    Attributes:
        points: (D, M) anchors, one row a coordinate, so that distance loops run over anchors.
        rows: (M, D) the same, one row an anchor.
        charts: (M, 1 + D, e) of each anchor, what takes a state to its coordinates u / radius there: those of the
            origin, then what each coordinate of the state adds.
        maps: (M, 1 + P, E) of each anchor, what takes those back: the anchor, then of each monomial of u / radius
            the coefficients that make u and v(u) together, as an offset from the anchor.
        neighbours: (M, L) each anchor's nearest anchors, itself first; L = 0 where asking all is as fast.
        reaches: (M,) distance of the last of them; infinite where all anchors are listed.
        radii: (M,) of the neighbourhoods the polynomials were fitted to.
        parents, factors, degrees: (P,) layout of the monomials.
    """

    points: Array
    rows: Array
    charts: Array
    maps: Array
    neighbours: Indices
    reaches: Array
    radii: Array
    parents: Indices
    factors: Indices
    degrees: Indices

    @property
    def tangents(self) -> Array:
        """(M, d, D) orthonormal rows that span the tangent space at each anchor, divided by its radius."""
        return np.swapaxes(self.charts[:, 1:, : self.factors.max() + 1], 1, 2)

    @property
    def bends(self) -> Array:
        """(M, D, P) coefficients of the monomials."""
        return np.swapaxes(self.maps[:, 1:, : len(self.points)], 1, 2)


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
    charts: Array,
    maps: Array,
    parents: Indices,
    factors: Indices,
    degrees: Indices,
    states: Array,
    nearest: Indices,
    weights: Array,
    place: Array,
    row: Array,
    coordinates: Array,
    monomials: Array,
    normals: Array,
    doubts: Array,
) -> None:
    """Blend of the displacements from each anchor's own surface, into normals (n, D), and its spread into doubts.

    Of each state, `coordinates` (d + 1, BLENDED) and `monomials` (P, BLENDED) are found for all anchors side by side;
    `place` (E,) and `row` are memory for one row each.
    """
    n, D = states.shape
    for i in range(n):
        for c in range(D):
            place[c] = states[i, c]
        beyond = 1.0
        for j in range(weights.shape[1]):
            beyond = max(beyond, locate(charts, nearest[i, j], place, row, coordinates, j))
        multiply(parents, factors, coordinates, monomials)
        if beyond > 1.0:
            go_on_straight(degrees, coordinates, monomials)
        doubts[i] = blend_maps(maps, place, i, nearest, weights, monomials, row, normals)


@inlined
def locate(charts: Array, anchor: int, place: Array, row: Array, coordinates: Array, j: int) -> float:
    """Coordinates of a place in an anchor's chart into column j, and below them how many reaches away it is.

    Or 1 within the reach; beyond it the coordinates are those of where the ray to the place leaves it.
    """
    _, rows, e = charts.shape
    first, square, beyond, d = anchor * rows * e, 0.0, 1.0, len(coordinates) - 1
    for b in range(0, e, LANES):
        u = load(charts, first + b)
        for c in range(1, rows):
            u = u + load(charts, first + c * e + b) * spread(place[c - 1])
        store(u, row, b)
    for a in range(d):
        coordinates[a, j] = row[a]
        square += row[a] ** 2
    if square > REACH**2:
        beyond = math.sqrt(square) / REACH
        for a in range(d):
            coordinates[a, j] /= beyond
    coordinates[d, j] = beyond
    return beyond


@inlined
def multiply(parents: Indices, factors: Indices, coordinates: Array, monomials: Array) -> None:
    """Monomials of the coordinates in each column."""
    for b in range(0, BLENDED, LANES):
        store(spread(1.0), monomials, b)
        for p in range(1, parents.size):
            product = load(monomials, parents[p] * BLENDED + b) * load(coordinates, factors[p] * BLENDED + b)
            store(product, monomials, p * BLENDED + b)


@inlined
def go_on_straight(degrees: Indices, coordinates: Array, monomials: Array) -> None:
    """Monomials beyond the reach go on along the tangents of their rays.

    By homogeneity one of degree g has slope g there: so nothing blows up far out.
    """
    beyond = coordinates[len(coordinates) - 1]
    for p in range(degrees.size):
        for j in range(BLENDED):
            monomials[p, j] *= 1.0 + degrees[p] * (beyond[j] - 1.0)


@inlined
def blend_maps(
    maps: Array,
    place: Array,
    i: int,
    nearest: Indices,
    weights: Array,
    monomials: Array,
    row: Array,
    normals: Array,
) -> float:
    """Weighted mean of a place's displacements from what each anchor's map makes of its monomials, into normals[i].

    Returns how far they spread about it.
    """
    _, rows, E = maps.shape
    mean_square, square = 0.0, 0.0
    for b in range(0, E, LANES):
        mean, squares = spread(0.0), spread(0.0)
        for j in range(weights.shape[1]):
            first = nearest[i, j] * rows * E + b
            away = load(place, b) - load(maps, first)
            for p in range(1, rows):
                away = away - load(maps, first + p * E) * spread(monomials[p - 1, j])
            weight = spread(weights[i, j])
            mean = mean + weight * away
            squares = squares + weight * away * away
        store(mean, row, 0)
        store(squares, row, LANES)
        for k in range(LANES):
            square += row[k] ** 2
            mean_square += row[LANES + k]
        for c in range(b, min(b + LANES, normals.shape[1])):
            normals[i, c] = row[c - b]
    return math.sqrt(max(mean_square - square, 0.0))
