"""Local polynomials fitted to the samples around centres by weighted least squares: one pass, many centres.

Monomials are ordered by degree, so the normal equations of a lower degree are the leading block of those of a
higher one, and so are their Cholesky factors: one factorisation serves every degree that shares a neighbourhood.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.manifold.kernels.small import orthonormalise
from skillfold.manifold.polynomials import Monomials

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

MARGIN = 1.05  # times the farthest neighbour's distance: the radius at which weights vanish
RIDGE = 1e-10  # of the sum of weights; keeps a fit to too few or aligned neighbours solvable


class Room(NamedTuple):
    """Memory that one fit works in, for k neighbours, P monomials, D dimensions, D - d normals.

    Attributes:
        offsets: (D, k) of the neighbours from the centre.
        weights: (k,).
        along: (d, k) offsets along the tangents, over the radius.
        rows: (P + D - d, k) monomials, then offsets along the normals.
        weighted: (k,) one monomial times the weights.
        gram: (P + D - d, P) products of the rows, the lower half: normal equations and, below them, their right-hand
            sides; then the Cholesky factor and, below, the right-hand sides after forward substitution.
        solution: (D - d, P).
    """

    offsets: Array
    weights: Array
    along: Array
    rows: Array
    weighted: Array
    gram: Array
    solution: Array


@inlined
def make_room(k: int, P: int, D: int, dim: int) -> Room:
    """Room for one fit."""
    normals = D - dim
    return Room(
        np.empty((D, k)),
        np.empty(k),
        np.empty((dim, k)),
        np.empty((P + normals, k)),
        np.empty(k),
        np.empty((P + normals, P)),
        np.empty((normals, P)),
    )


@inner
def gather(samples: Array, centre: Array, neighbours: Indices, room: Room) -> float:
    """Offsets and Wendland weights (1 − r)⁴(4r + 1) of the neighbours into `room`; returns the radius.

    Columns of samples and centre beyond the room's D dimensions count for the distances r alone.
    """
    k, D = neighbours.size, room.offsets.shape[0]
    room.weights[:] = 0.0
    for c in range(D):
        for i in range(k):
            room.offsets[c, i] = samples[neighbours[i], c] - centre[c]
            room.weights[i] += room.offsets[c, i] ** 2
    for c in range(D, centre.size):
        for i in range(k):
            room.weights[i] += (samples[neighbours[i], c] - centre[c]) ** 2
    farthest = 0.0
    for i in range(k):
        farthest = max(farthest, room.weights[i])
    radius = max(MARGIN * math.sqrt(farthest), 1e-300)
    for i in range(k):
        r = math.sqrt(room.weights[i]) / radius
        room.weights[i] = (1.0 - r) ** 4 * (4.0 * r + 1.0)
    return radius


@njit
def scatters(samples: Array, centres: Array, neighbours: Indices) -> Array:
    """Weighted scatter (D, D) of the neighbours of each centre about their mean; (M, D, D)."""
    (M, k), D = neighbours.shape, samples.shape[1]
    room = make_room(k, 0, D, 0)
    mean, result = np.empty(D), np.empty((M, D, D))
    for m in range(M):
        gather(samples, centres[m], neighbours[m], room)
        total = room.weights.sum()
        for c in range(D):
            for i in range(k):
                room.rows[c, i] = room.offsets[c, i] * room.weights[i]
            mean[c] = room.rows[c].sum() / total
        for c in range(D):
            for e in range(c + 1):
                s = 0.0
                for i in range(k):
                    s += room.rows[c, i] * room.offsets[e, i]
                result[m, c, e] = result[m, e, c] = s - total * mean[c] * mean[e]
    return result


@inner
def component(direction: Array, scale: float, offsets: Array, out: Array) -> None:
    """Components (k,) of offsets (D, k) along a direction, times the scale."""
    out[:] = 0.0
    for c in range(direction.size):
        for i in range(out.size):
            out[i] += scale * direction[c] * offsets[c, i]


@inner
def assemble(frame: Array, radius: float, dim: int, table: Monomials, terms: int, room: Room) -> None:
    """Normal equations of the first `terms` monomials of u / radius in the frame into room.gram."""
    D, k = room.offsets.shape
    for a in range(dim):
        component(frame[a], 1.0 / radius, room.offsets, room.along[a])
    room.rows[0] = 1.0
    for j in range(1, terms):
        for i in range(k):
            room.rows[j, i] = room.rows[table.parents[j], i] * room.along[table.factors[j], i]
    for n in range(D - dim):
        component(frame[dim + n], 1.0, room.offsets, room.rows[terms + n])
    for j in range(terms):
        for i in range(k):
            room.weighted[i] = room.rows[j, i] * room.weights[i]
        products(room.rows, room.weighted, j, terms + D - dim, room.gram[:, j])


@inner
def products(rows: Array, weighted: Array, first: int, end: int, out: Array) -> None:
    """Products of rows first to end with one weighted row; four at a time, so that its values are loaded once."""
    h = first
    while h + 3 < end:
        s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
        for i in range(weighted.size):
            w = weighted[i]
            s0 += w * rows[h, i]
            s1 += w * rows[h + 1, i]
            s2 += w * rows[h + 2, i]
            s3 += w * rows[h + 3, i]
        out[h], out[h + 1], out[h + 2], out[h + 3] = s0, s1, s2, s3
        h += 4
    while h < end:
        s = 0.0
        for i in range(weighted.size):
            s += weighted[i] * rows[h, i]
        out[h] = s
        h += 1


@inner
def factorise(terms: int, normals: int, room: Room) -> None:
    """Cholesky factor of the normal equations plus the ridge, in place.

    The right-hand sides are further rows: what a factor's row takes is forward substitution to them.
    """
    ridge = RIDGE * room.gram[0, 0] + 1e-300
    for h in range(terms + normals):
        for j in range(min(h + 1, terms)):
            s = room.gram[h, j]
            for i in range(j):
                s -= room.gram[h, i] * room.gram[j, i]
            room.gram[h, j] = s / room.gram[j, j] if j < h else math.sqrt(max(s, 0.0) + ridge)


@inner
def substitute(terms: int, fitted: int, room: Room) -> None:
    """Coefficients of the first `terms` monomials alone into room.solution, where `fitted` ones were factorised."""
    for n in range(room.solution.shape[0]):
        for j in range(terms):
            room.solution[n, j] = room.gram[fitted + n, j]
        for j in range(terms - 1, -1, -1):
            room.solution[n, j] /= room.gram[j, j]
            for i in range(j):
                room.solution[n, i] -= room.gram[j, i] * room.solution[n, j]


@inlined
def turn(frame: Array, radius: float, dim: int, room: Room) -> None:
    """Turn the frame's rows so that its tangents have the slope that room.solution has at the centre."""
    for a in range(dim):
        for n in range(room.solution.shape[0]):
            slope = room.solution[n, 1 + a] / radius
            for c in range(frame.shape[1]):
                frame[a, c] += slope * frame[dim + n, c]
    orthonormalise(frame)


@inlined
def fit_one(
    samples: Array,
    centre: Array,
    neighbours: Indices,
    frame: Array,
    dim: int,
    table: Monomials,
    turning: int,
    terms: int,
    turns: int,
    room: Room,
) -> float:
    """Factorised normal equations of `terms` monomials at one centre into `room`; returns the radius.

    The frame is turned in place, `turns` times. The first `turning` monomials tell the slope that it is turned to:
    the same whatever is fitted after, so that all degrees share it.
    """
    radius = gather(samples, centre, neighbours, room)
    normals = frame.shape[0] - dim
    for _ in range(turns):
        assemble(frame, radius, dim, table, turning, room)
        factorise(turning, normals, room)
        substitute(turning, turning, room)
        turn(frame, radius, dim, room)
    assemble(frame, radius, dim, table, terms, room)
    factorise(terms, normals, room)
    return radius


@njit
def fit_patches(
    samples: Array,
    centres: Array,
    neighbours: Indices,
    frames: Array,
    dim: int,
    table: Monomials,
    turning: int,
    terms: Indices,
    turns: int,
) -> tuple:
    """Polynomials at centres (M, D), one for each number of leading monomials in `terms`, which ascend; turns frames.

    Samples and centres may have further columns: see `gather`.
    Returns coefficients (len(terms), M, terms[-1], D - d), zero beyond a polynomial's own terms, and radii (M,).
    """
    (M, k), D, P = neighbours.shape, frames.shape[1], terms[terms.size - 1]
    room = make_room(k, max(turning, P), D, dim)
    coefficients, radii = np.zeros((terms.size, M, P, D - dim)), np.empty(M)
    for m in range(M):
        radii[m] = fit_one(samples, centres[m], neighbours[m], frames[m], dim, table, turning, P, turns, room)
        for t in range(terms.size):
            substitute(terms[t], P, room)
            for j in range(terms[t]):
                for n in range(D - dim):
                    coefficients[t, m, j, n] = room.solution[n, j]
    return coefficients, radii
