"""Local polynomials fitted to the samples around centres by weighted least squares: one pass, many centres.

Monomials are ordered by degree, so the normal equations of a lower degree are the leading block of those of a
higher one, and so are their Cholesky factors: one serves every degree that shares a neighbourhood. Nearly all the
time goes into products of rows, made in tiles of four by four: each value that is loaded serves four times. Arrays
of rows are a tile longer than what they hold; what stands there does not matter.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import inlined, inner, njit
from skillfold.manifold.kernels.small import copy, orthonormalise
from skillfold.manifold.polynomials import Monomials

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

MARGIN = 1.05  # times the farthest neighbour's distance: the radius at which weights vanish
RIDGE = 1e-10  # of the sum of weights; keeps a fit to too few or aligned neighbours solvable
TILE = 4  # rows and columns of products made at once


class Room(NamedTuple):
    """Memory that one fit works in, for k neighbours, P monomials, D dimensions, D - d normals.

    Attributes:
        offsets: (D, k) of the neighbours from the centre.
        roots: (k,) of the weights.
        along: (d, k) offsets along the tangents, over the radius.
        rows: (P + D - d, k) monomials, then offsets along the normals; all times the roots.
        gram: (P + D - d, P) products of the rows, the lower half: normal equations and, below them, their right-hand
            sides; then the Cholesky factor and, below, the right-hand sides after forward substitution.
        solution: (D - d, P).
    """

    offsets: Array
    roots: Array
    along: Array
    rows: Array
    gram: Array
    solution: Array


@inlined
def make_room(k: int, P: int, D: int, dim: int) -> Room:
    """Room for one fit."""
    normals = D - dim
    rows = np.zeros((P + normals + TILE, k))
    gram = np.empty((P + normals + TILE, P + TILE))
    return Room(np.empty((D, k)), np.empty(k), np.empty((dim, k)), rows, gram, np.empty((normals, P)))


@inner
def gather(samples: Array, centre: Array, neighbours: Indices, room: Room) -> float:
    """Offsets and roots of Wendland weights (1 − r)⁴(4r + 1) of the neighbours into `room`; returns the radius.

    Columns of samples and centre beyond the room's D dimensions count for the distances r alone.
    """
    k, D = neighbours.size, room.offsets.shape[0]
    room.roots[:] = 0.0
    for c in range(centre.size):
        for i in range(k):
            offset = samples[neighbours[i], c] - centre[c]
            if c < D:
                room.offsets[c, i] = offset
            room.roots[i] += offset**2
    farthest = 0.0
    for i in range(k):
        farthest = max(farthest, room.roots[i])
    radius = max(MARGIN * math.sqrt(farthest), 1e-300)
    for i in range(k):
        r = math.sqrt(room.roots[i]) / radius
        room.roots[i] = (1.0 - r) ** 2 * math.sqrt(4.0 * r + 1.0)
    return radius


@njit
def scatters(samples: Array, centres: Array, neighbours: Indices) -> Array:
    """Weighted scatter (D, D) of the neighbours of each centre about their mean; (M, D, D)."""
    (M, k), D = neighbours.shape, samples.shape[1]
    room = make_room(k, D + 1, D, D)
    result = np.empty((M, D, D))
    for m in range(M):
        gather(samples, centres[m], neighbours[m], room)
        copy(room.roots, room.rows[0])
        for c in range(D):
            for i in range(k):
                room.rows[1 + c, i] = room.offsets[c, i] * room.roots[i]
        multiply(room.rows, D + 1, D + 1, room.gram)
        for c in range(D):
            mean = room.gram[1 + c, 0] / room.gram[0, 0]
            for e in range(c + 1):
                result[m, c, e] = result[m, e, c] = room.gram[1 + c, 1 + e] - mean * room.gram[1 + e, 0]
    return result


@inner
def tile(left: Array, a: int, right: Array, b: int, end: int, factor: float, out: Array) -> None:
    """Add factor × products of four rows of `left` from a and of `right` from b, up to column `end`, at out[a, b]."""
    s00, s01, s02, s03 = 0.0, 0.0, 0.0, 0.0
    s10, s11, s12, s13 = 0.0, 0.0, 0.0, 0.0
    s20, s21, s22, s23 = 0.0, 0.0, 0.0, 0.0
    s30, s31, s32, s33 = 0.0, 0.0, 0.0, 0.0
    for i in range(end):
        r0, r1, r2, r3 = right[b, i], right[b + 1, i], right[b + 2, i], right[b + 3, i]
        x = left[a, i]
        s00, s01, s02, s03 = s00 + x * r0, s01 + x * r1, s02 + x * r2, s03 + x * r3
        x = left[a + 1, i]
        s10, s11, s12, s13 = s10 + x * r0, s11 + x * r1, s12 + x * r2, s13 + x * r3
        x = left[a + 2, i]
        s20, s21, s22, s23 = s20 + x * r0, s21 + x * r1, s22 + x * r2, s23 + x * r3
        x = left[a + 3, i]
        s30, s31, s32, s33 = s30 + x * r0, s31 + x * r1, s32 + x * r2, s33 + x * r3
    add(out[a], b, factor, s00, s01, s02, s03)
    add(out[a + 1], b, factor, s10, s11, s12, s13)
    add(out[a + 2], b, factor, s20, s21, s22, s23)
    add(out[a + 3], b, factor, s30, s31, s32, s33)


@inner
def add(out: Array, b: int, factor: float, s0: float, s1: float, s2: float, s3: float) -> None:
    """Add factor × four values to `out` from b."""
    out[b] += factor * s0
    out[b + 1] += factor * s1
    out[b + 2] += factor * s2
    out[b + 3] += factor * s3


@inner
def multiply(rows: Array, columns: int, end: int, gram: Array) -> None:
    """Products of rows up to `end` with those up to `columns`, the lower half."""
    gram[:] = 0.0
    for j in range(0, columns, TILE):
        for h in range(j, end, TILE):
            tile(rows, h, rows, j, rows.shape[1], 1.0, gram)


@inner
def component(direction: Array, scale: float, offsets: Array, out: Array) -> None:
    """Components (k,) of offsets (D, k) along a direction, times the scale; three terms at once."""
    D = direction.size
    out[:] = 0.0
    for c in range(0, D - D % 3, 3):
        x, y, z = scale * direction[c], scale * direction[c + 1], scale * direction[c + 2]
        for i in range(out.size):
            out[i] += x * offsets[c, i] + y * offsets[c + 1, i] + z * offsets[c + 2, i]
    for c in range(D - D % 3, D):
        x = scale * direction[c]
        for i in range(out.size):
            out[i] += x * offsets[c, i]


@inner
def times(left: Array, right: Array, out: Array) -> None:
    """Out ← left × right, value by value."""
    for i in range(out.size):
        out[i] = left[i] * right[i]


@inner
def assemble(frame: Array, radius: float, dim: int, table: Monomials, terms: int, room: Room) -> None:
    """Normal equations of the first `terms` monomials of u / radius in the frame into room.gram."""
    normals = room.solution.shape[0]
    for a in range(dim):
        component(frame[a], 1.0 / radius, room.offsets, room.along[a])
    copy(room.roots, room.rows[0])
    for j in range(1, terms):
        times(room.rows[table.parents[j]], room.along[table.factors[j]], room.rows[j])
    for n in range(normals):
        component(frame[dim + n], 1.0, room.offsets, room.rows[terms + n])
        times(room.rows[terms + n], room.roots, room.rows[terms + n])
    multiply(room.rows, terms, terms + normals, room.gram)


@inner
def factorise(terms: int, normals: int, room: Room) -> None:
    """Cholesky factor of the normal equations plus the ridge, in place, four columns at a time.

    The right-hand sides are further rows: what a factor's row takes is forward substitution to them.
    """
    gram, end = room.gram, terms + normals
    ridge = RIDGE * gram[0, 0] + 1e-300
    for first in range(0, terms, TILE):
        for h in range(first, end if first else 0, TILE):
            tile(gram, h, gram, first, first, -1.0, gram)
        for j in range(first, first + TILE):
            for i in range(first, j):
                for h in range(j, first + TILE):
                    gram[h, j] -= gram[h, i] * gram[j, i]
            gram[j, j] = math.sqrt(max(gram[j, j], 0.0) + ridge)
            for h in range(j + 1, first + TILE):
                gram[h, j] /= gram[j, j]
        divide(gram, first, end)


@inner
def divide(gram: Array, first: int, end: int) -> None:
    """Rows below a tile of the factor, in its four columns, divided by the tile."""
    a, b, c, d = first, first + 1, first + 2, first + 3
    inverse = 1.0 / gram[a, a], 1.0 / gram[b, b], 1.0 / gram[c, c], 1.0 / gram[d, d]
    ba, ca, cb, da, db, dc = gram[b, a], gram[c, a], gram[c, b], gram[d, a], gram[d, b], gram[d, c]
    for h in range(first + TILE, end):
        x = gram[h, a] * inverse[0]
        y = (gram[h, b] - x * ba) * inverse[1]
        z = (gram[h, c] - x * ca - y * cb) * inverse[2]
        gram[h, d] = (gram[h, d] - x * da - y * db - z * dc) * inverse[3]
        gram[h, a], gram[h, b], gram[h, c] = x, y, z


@inner
def substitute(terms: int, fitted: int, room: Room) -> None:
    """Coefficients of the first `terms` monomials alone into room.solution, where `fitted` ones were factorised."""
    for n in range(room.solution.shape[0]):
        for j in range(terms):
            room.solution[n, j] = room.gram[fitted + n, j]
    for j in range(terms - 1, -1, -1):
        inverse = 1.0 / room.gram[j, j]
        for n in range(room.solution.shape[0]):
            room.solution[n, j] *= inverse
            value = room.solution[n, j]
            for i in range(j):
                room.solution[n, i] -= room.gram[j, i] * value


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

    Samples and centres may have further columns: see `gather`. Returns coefficients (len(terms), M, terms[-1],
    D - d), zero beyond a polynomial's own terms, and radii (M,).
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
