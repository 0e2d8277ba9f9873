"""Local polynomials fitted to the samples around centres by weighted least squares: one pass, many centres.

Monomials are ordered by degree, so the normal equations of a lower degree are the leading block of those of a
higher one, and so are their Cholesky factors: one factorisation serves every degree that shares a neighbourhood.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from skillfold.jit import njit
from skillfold.manifold.kernels.small import orthonormalise
from skillfold.manifold.polynomials import Monomials

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

MARGIN = 1.05  # times the farthest neighbour's distance: the radius at which weights vanish
FITTED_TURNS = 2  # of a frame to its own surface's slope, where its tangents are used after
JUDGED_TURNS = 1  # the same, where only heights above it are asked for
RIDGE = 1e-10  # of the sum of weights; keeps a fit to too few or aligned neighbours solvable


class Room(NamedTuple):
    """Memory that one fit works in, for k neighbours, P monomials, D dimensions, D - d normals.

    Attributes:
        offsets: (D, k) of the neighbours from the centre.
        weights: (k,).
        local: (D, k) offsets in the frame.
        values: (P, k) monomials.
        weighted: (k,) one monomial times the weights.
        gram: (P, P) normal equations, then their Cholesky factor; the lower half.
        right: (D - d, P) right-hand sides, then what forward substitution makes of them.
        solution: (D - d, P).
    """

    offsets: Array
    weights: Array
    local: Array
    values: Array
    weighted: Array
    gram: Array
    right: Array
    solution: Array


@njit
def make_room(k: int, P: int, D: int, normals: int) -> Room:
    """Room for one fit."""
    return Room(
        np.empty((D, k)),
        np.empty(k),
        np.empty((D, k)),
        np.empty((P, k)),
        np.empty(k),
        np.empty((P, P)),
        np.empty((normals, P)),
        np.empty((normals, P)),
    )


@njit
def gather(samples: Array, centre: Array, neighbours: Indices, room: Room) -> float:
    """Offsets and Wendland weights (1 − r)⁴(4r + 1) of the neighbours into `room`; returns the radius."""
    k, D = neighbours.size, centre.size
    room.weights[:] = 0.0
    for c in range(D):
        for i in range(k):
            room.offsets[c, i] = samples[neighbours[i], c] - centre[c]
            room.weights[i] += room.offsets[c, i] ** 2
    radius = max(MARGIN * math.sqrt(room.weights.max()), 1e-300)
    for i in range(k):
        r = math.sqrt(room.weights[i]) / radius
        room.weights[i] = (1.0 - r) ** 4 * (4.0 * r + 1.0)
    return radius


@njit
def scatters(samples: Array, centres: Array, neighbours: Indices) -> Array:
    """Weighted scatter (D, D) of the neighbours of each centre about their mean; (M, D, D)."""
    (M, k), D = neighbours.shape, samples.shape[1]
    room = make_room(k, 1, D, 1)
    mean, result = np.empty(D), np.empty((M, D, D))
    for m in range(M):
        gather(samples, centres[m], neighbours[m], room)
        total = room.weights.sum()
        for c in range(D):
            for i in range(k):
                room.local[c, i] = room.offsets[c, i] * room.weights[i]
            mean[c] = room.local[c].sum() / total
        for c in range(D):
            for e in range(c + 1):
                s = 0.0
                for i in range(k):
                    s += room.local[c, i] * room.offsets[e, i]
                result[m, c, e] = result[m, e, c] = s - total * mean[c] * mean[e]
    return result


@njit
def assemble(frame: Array, radius: float, dim: int, table: Monomials, terms: int, room: Room) -> None:
    """Normal equations of the first `terms` monomials of u / radius in the frame into room.gram and room.right."""
    D, k = room.offsets.shape
    for c in range(D):
        room.local[c] = 0.0
        for e in range(D):
            for i in range(k):
                room.local[c, i] += frame[c, e] * room.offsets[e, i]
    for c in range(dim):
        for i in range(k):
            room.local[c, i] /= radius
    room.values[0] = 1.0
    for j in range(terms):
        for i in range(k):
            if j > 0:
                room.values[j, i] = room.values[table.parents[j], i] * room.local[table.factors[j], i]
            room.weighted[i] = room.values[j, i] * room.weights[i]
        for h in range(j + 1):
            s = 0.0
            for i in range(k):
                s += room.weighted[i] * room.values[h, i]
            room.gram[j, h] = s
        for n in range(D - dim):
            s = 0.0
            for i in range(k):
                s += room.weighted[i] * room.local[dim + n, i]
            room.right[n, j] = s


@njit
def factorise(terms: int, room: Room) -> None:
    """Cholesky factor of the leading block of room.gram plus the ridge, in place; right ← L⁻¹ right."""
    ridge = RIDGE * room.gram[0, 0] + 1e-300
    for j in range(terms):
        for h in range(j + 1):
            s = room.gram[j, h]
            for i in range(h):
                s -= room.gram[j, i] * room.gram[h, i]
            room.gram[j, h] = s / room.gram[h, h] if h < j else math.sqrt(max(s, 0.0) + ridge)
        for n in range(room.right.shape[0]):
            s = room.right[n, j]
            for i in range(j):
                s -= room.gram[j, i] * room.right[n, i]
            room.right[n, j] = s / room.gram[j, j]


@njit
def substitute(terms: int, room: Room) -> None:
    """Coefficients of the first `terms` monomials alone into room.solution, from what `factorise` left."""
    for n in range(room.right.shape[0]):
        for j in range(terms):
            room.solution[n, j] = room.right[n, j]
        for j in range(terms - 1, -1, -1):
            room.solution[n, j] /= room.gram[j, j]
            for i in range(j):
                room.solution[n, i] -= room.gram[j, i] * room.solution[n, j]


@njit
def turn(frame: Array, radius: float, dim: int, room: Room) -> None:
    """Turn the frame's rows so that its tangents have the slope that room.solution has at the centre."""
    for a in range(dim):
        for n in range(room.solution.shape[0]):
            slope = room.solution[n, 1 + a] / radius
            for c in range(frame.shape[1]):
                frame[a, c] += slope * frame[dim + n, c]
    orthonormalise(frame)


@njit
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
    for _ in range(turns):
        assemble(frame, radius, dim, table, turning, room)
        factorise(turning, room)
        substitute(turning, room)
        turn(frame, radius, dim, room)
    assemble(frame, radius, dim, table, terms, room)
    factorise(terms, room)
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
    terms: int,
) -> tuple:
    """Polynomials of `terms` monomials at centres (M, D); frames (M, D, D) are turned.

    Returns coefficients (M, terms, D - d) and radii (M,).
    """
    (M, k), D = neighbours.shape, samples.shape[1]
    room = make_room(k, max(turning, terms), D, D - dim)
    coefficients, radii = np.empty((M, terms, D - dim)), np.empty(M)
    for m in range(M):
        radii[m] = fit_one(
            samples, centres[m], neighbours[m], frames[m], dim, table, turning, terms, FITTED_TURNS, room
        )
        substitute(terms, room)
        coefficients[m] = room.solution[:, :terms].T
    return coefficients, radii


@njit
def predict_patches(
    samples: Array,
    chosen: Indices,
    neighbours: Indices,
    frames: Array,
    dim: int,
    table: Monomials,
    turning: int,
    terms: Indices,
) -> Array:
    """Distances of samples `chosen` (M,) from the polynomials at the first of their neighbours; (len(terms), M).

    One row for each number of leading monomials in `terms`; the frames (M, D, D) are turned.
    """
    (M, k), D, P = neighbours.shape, samples.shape[1], terms.max()
    room = make_room(k, max(turning, P), D, D - dim)
    local, values, errors = np.empty(D), np.empty(P), np.empty((terms.size, M))
    for m in range(M):
        centre = samples[neighbours[m, 0]]
        radius = fit_one(samples, centre, neighbours[m], frames[m], dim, table, turning, P, JUDGED_TURNS, room)
        for c in range(D):
            local[c] = 0.0
            for e in range(D):
                local[c] += frames[m, c, e] * (samples[chosen[m], e] - centre[e])
        values[0] = 1.0
        for j in range(1, P):
            values[j] = values[table.parents[j]] * local[table.factors[j]] / radius
        for t in range(terms.size):
            substitute(terms[t], room)
            square = 0.0
            for n in range(D - dim):
                s = local[dim + n]
                for j in range(terms[t]):
                    s -= values[j] * room.solution[n, j]
                square += s**2
            errors[t, m] = math.sqrt(square)
    return errors
