"""Plain NumPy twins of the kernels of `skillfold.manifold.kernels`, written for clarity from their descriptions.

Each takes a kernel's arguments without its scratch memory and returns what the kernel writes. None calls a kernel.
"""

from functools import cache
from itertools import combinations_with_replacement

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import nnls

BLENDED = 8
REACH = 1.5
ACROSS, WHOLLY, LENT = 0.6, 0.9, 0.5
STARTS = 4


def orthonormalise(basis):
    """Rows of Q with the signs of Gram-Schmidt; a dependent row is replaced by the first axis that is free."""
    rows, full_rank = [], True
    for row in basis:
        candidates = [row, *np.eye(basis.shape[1])]
        for attempt, candidate in enumerate(candidates):
            rest = candidate.copy()
            for _ in range(2):
                rest = rest - sum((np.dot(q, rest) * q for q in rows), np.zeros_like(rest))
            if np.linalg.norm(rest) > 1e-10 * np.linalg.norm(candidate):
                rows.append(rest / np.linalg.norm(rest))
                full_rank = full_rank and attempt == 0
                break
    return np.array(rows), full_rank


def tangent_basis(field, x):
    """Orthonormal rows of H(x), and whether H has full rank."""
    square = ((x[:, None] - field.centres) ** 2).sum(0)
    weights = np.exp(-(square - square.min()) * field.precision)
    return orthonormalise(np.einsum("k,ack->ac", weights / weights.sum(), field.weights))


def stand_in(surface, anchors, weights, basis):
    """Orthonormal rows, or where they lie across the surface of the first anchor what all anchors' tangents add."""
    own = surface.tangents[anchors[0]] * surface.radii[anchors[0]]
    across = len(basis) - ((basis @ own.T) ** 2).sum()
    if across <= ACROSS:
        return basis
    return lend(surface, anchors, weights, LENT * min((across - ACROSS) / (WHOLLY - ACROSS), 1.0), basis)


def lend(surface, anchors, weights, share, basis):
    """The first anchor's tangents, as much as the rows and a share of all anchors' tangents hold of them."""
    tangents = surface.tangents[anchors] * surface.radii[anchors, None, None]
    blended = sum(w * t.T @ t for w, t in zip(weights, tangents, strict=True))
    return orthonormalise(tangents[0] @ (basis.T @ basis + share * blended))[0]


@cache
def powers(dim, degree):
    """Exponents (P, dim) of the monomials, by degree, then in lexicographic order of their factors."""
    factors = [c for g in range(degree + 1) for c in combinations_with_replacement(range(dim), g)]
    return np.array([[c.count(a) for a in range(dim)] for c in factors])


def monomials(exponents, u):
    """Values (P,) of the monomials at u; beyond |u| = REACH along the tangent of the ray through u."""
    length = np.linalg.norm(u)
    edge = u * min(1.0, REACH / length) if length > 0 else u
    terms = np.prod(edge**exponents, axis=1)
    if length > REACH:
        # Euler: a monomial of degree g has derivative g × itself / |u| along the ray.
        terms = terms * (1.0 + exponents.sum(1) * (length - REACH) / REACH)
    return terms


def anchor_displacement(surface, i, x):
    """From anchor i's own surface to x along its normals: (D,)."""
    offset = x - surface.points[:, i]
    exponents = powers(surface.tangents.shape[1], surface.degrees[-1])
    return offset - surface.bends[i] @ monomials(exponents, surface.tangents[i] @ offset)


def nearest(points, x):
    """Indices and squared distances of the anchors that an evaluation at x looks at, the nearest first."""
    square = ((points - x[:, None]) ** 2).sum(0)
    order = np.argsort(square, kind="stable")[: min(BLENDED, points.shape[1] - 1) + 1]
    return order, square[order]


def blend_weights(square):
    """Weights of all anchors but the last, which sets the width."""
    width = square[-1] - square[0]
    r = np.sqrt((square[:-1] - square[0]) / width) if width > 0 else np.zeros(len(square) - 1)
    weights = (1 - r) ** 4 * (4 * r + 1)
    return weights / weights.sum()


def displacement(surface, field, x):
    """Displacement from the blended surface to x, H's tangents there, nearest square, the anchors' disagreement."""
    order, square = nearest(surface.points, x)
    weights = blend_weights(square)
    parts = np.array([anchor_displacement(surface, i, x) for i in order[:-1]])
    mean = weights @ parts
    spread = weights @ (parts**2).sum(1) - (mean**2).sum()
    basis = stand_in(surface, order[:-1], weights, tangent_basis(field, x)[0])
    return mean - basis.T @ (basis @ mean), basis, square[0], np.sqrt(max(spread, 0.0))


def descend(surface, field, farthest, most_doubt, cap, state, point, tolerance=1e-10, steps=40):
    """Anchored Newton toward `state` along the surface; the point reached and whether it is on the surface."""
    rate, before, pull, last = 1.0, np.inf, 1.0, None
    for _ in range(steps):
        normal, basis, square, doubt = displacement(surface, field, point)
        sure, more = False, 0.0
        if last is not None and (square > farthest**2 or doubt > most_doubt):
            shorter = shortened(rate, cap / pull)
            if shorter == rate:
                return step_back(surface, field, last[0], tolerance)
            rate = shorter
        else:
            along = basis.T @ (basis @ (state - point))
            off, pull = np.linalg.norm(normal), np.linalg.norm(along)
            if off < tolerance and rate * pull < tolerance:
                return point, True
            ratio = (off + pull) / before
            if ratio > 0.7:
                rate = max(0.6 * rate, 0.05)
            elif ratio < 0.5:
                rate = min(1.25 * rate, 1.0)
            step = along - normal
            if last is not None and ratio < 0.5:
                sure = ratio * (off + pull) < 0.5 * tolerance
                if rate == 1.0 and off + pull < cap:
                    turn = step - last[1]
                    more = (step @ turn) / (turn @ turn) * (turn + point - last[0])
            last, before, pull = (point, step, along, normal), off + pull, max(pull, 1e-300)
        start, _, along, normal = last
        back = min(1.0, cap / max(np.linalg.norm(normal), 1e-300))
        point = start + min(rate, cap / pull) * along - back * normal - more
        if sure:
            return point, True
    return step_back(surface, field, point, tolerance)


def shortened(rate, most):
    """The first rate, each three tenths of the one before but a twentieth at least, with a shorter step; or none."""
    rates = [rate]
    while rates[-1] > 0.05:
        rates.append(max(0.3 * rates[-1], 0.05))
    return next((r for r in rates if min(r, most) < min(rate, most)), rate)


def step_back(surface, field, point, tolerance):
    """Straight onto the surface; the foot and whether it is on the surface."""
    for _ in range(20):
        normal = displacement(surface, field, point)[0]
        if np.linalg.norm(normal) < tolerance:
            return point, True
        point = point - normal
    return point, False


def starts(surface, trust, state):
    """The nearest sure anchors, none more than two spacings beyond the nearest of all; else simply the nearest."""
    square = ((surface.points - state[:, None]) ** 2).sum(0)
    order = np.argsort(square, kind="stable")
    wanted = min(STARTS, len(order))
    far = np.sqrt(square[order[0]]) + 2.0 * trust.spacing
    sure = [i for i in order if trust.sure[i] and square[i] <= far**2]
    return sure[:wanted] if len(sure) >= wanted else order[:wanted]


def nearest_in_hull(points):
    """Point of the convex hull of points (k, d) nearest to the origin: the free length of the shares drops out."""
    shares = nnls(np.vstack([points.T, np.ones(len(points))]), np.eye(points.shape[1] + 1)[-1])[0]
    return shares @ points / shares.sum()


def anchors_around(surface, point, dim):
    """Places of the anchors that span the hull around a point."""
    return np.argsort(((surface.points.T - point) ** 2).sum(1), kind="stable")[: 12 + 4 * dim]


def pull(offsets, allowed, stiffness):
    """Minus the slope of stiffness / 2 max(s - allowed, 0)² on the distance s of the origin from a hull (k, d)."""
    inward = nearest_in_hull(offsets)
    return stiffness * max(1.0 - allowed / max(np.linalg.norm(inward), 1e-300), 0.0) * inward


def pull_and_slope(offsets, allowed, stiffness, difference=1e-6):
    """The same, and how it changes with the origin, its sign turned: (d,) and (d, d)."""
    moves = difference * np.eye(offsets.shape[1])
    slopes = [pull(offsets - e, allowed, stiffness) - pull(offsets + e, allowed, stiffness) for e in moves]
    return pull(offsets, allowed, stiffness), -np.array(slopes) / (2.0 * difference)


def way_in(surface, field, point, seen_from=None):
    """From a point to the hull of the anchors around, along the tangents there or at another state; (d,)."""
    _, basis, _, _ = displacement(surface, field, point if seen_from is None else seen_from)
    return nearest_in_hull((surface.points.T[anchors_around(surface, point, len(basis))] - point) @ basis.T)


def draw_in(surface, field, spacing, point):
    """A point of the surface brought along it into the hull of the anchors around, and whether it is still on it."""
    begun = point
    for _ in range(8):
        normal, basis, _, _ = displacement(surface, field, point)
        inward = way_in(surface, field, point)
        if np.linalg.norm(inward) <= 0.02 * spacing:
            break
        point = point + inward @ basis - normal
    return (point, True) if point is begun else step_back(surface, field, point, 1e-10)


def project_state(surface, field, trust, state):
    """The closest trusted point of the surface, and whether one was met."""
    order, _ = nearest(surface.points, state)
    normal, _, _, doubt = displacement(surface, field, state)
    if np.linalg.norm(normal) < 1e-10:
        return state, True
    off = np.linalg.norm(normal)
    within = np.inf if doubt < 10.0 * trust.doubt else trust.ghost if doubt < trust.ghost else 0.0
    if off < min(0.25 * surface.radii[order[0]], within):
        foot = state - min(1.0, trust.cap / off) * normal
        point, met = descend(surface, field, np.inf, np.inf, trust.cap, state, foot)
        if met and np.linalg.norm(state - point) < within:
            return point, True
    anchors = surface.points.T[starts(surface, trust, state)]
    foot, met = step_back(surface, field, anchors[0], 1e-10)
    within = surface, field, trust.spacing, trust.doubt, trust.cap, state
    found = [descend(*within, anchor, 1e-4, 16) for anchor in anchors]
    rough = [point for point, good in found if good]
    if rough:
        best = min(rough, key=lambda point: np.linalg.norm(state - point))
        best, settled = descend(*within, best)
        if settled:
            best, settled = draw_in(surface, field, trust.spacing, best)
        if settled and (not met or np.linalg.norm(state - best) < np.linalg.norm(state - foot)):
            return best, True
    return (foot, True) if met else (anchors[0], False)


def distance(surface, field, trust, state, enough):
    """Length of the displacement, and of a great doubt, where that is small enough; else to the projection."""
    normal, _, _, doubt = displacement(surface, field, state)
    off = np.linalg.norm(normal) if doubt <= trust.ghost else np.sqrt((normal**2).sum() + doubt**2)
    if off <= enough:
        return off
    return np.linalg.norm(project_state(surface, field, trust, state)[0] - state)


def follow_leaf(field, state, near, rate, steps):
    """q' ← q' + α H'H'ᵀ(q − q')."""
    point = near
    for _ in range(steps):
        basis, _ = tangent_basis(field, point)
        along = basis.T @ (basis @ (state - point))
        if np.linalg.norm(along) < 1e-10:
            break
        point = point + rate * along
    return point


def grow_path(surface, field, start, goal, step, limit):
    """States grown from both ends in turn; None where they do not meet."""
    left, right, bases = [start], [goal], [None, None]
    while np.linalg.norm(right[-1] - left[-1]) > 1.5 * step:
        if len(left) + len(right) == limit:
            return None
        here, there = (left, right) if len(left) == len(right) else (right, left)
        gap, side = there[-1] - here[-1], int(here is right)
        if bases[side] is None:
            bases[side] = displacement(surface, field, here[-1])[1]
        direction = bases[side].T @ (bases[side] @ gap)
        if np.linalg.norm(direction) < 1e-6 * np.linalg.norm(gap):
            return None
        new = here[-1] + step * direction / np.linalg.norm(direction)
        normal, bases[side], _, _ = displacement(surface, field, new)
        here.append(new - normal)
    return np.array(left + right[::-1])


def resample(path, count):
    """The polyline at equal arc lengths."""
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    wanted = np.linspace(0.0, travelled[-1], count)
    moving = np.concatenate([[True], np.diff(travelled) > 0])
    return np.stack([np.interp(wanted, travelled[moving], column) for column in path[moving].T], axis=1)


def second_differences(n):
    """(n, n + 2) matrix of q_{i−1} − 2 q_i + q_{i+1} at inner states."""
    return np.eye(n, n + 2) - 2 * np.eye(n, n + 2, 1) + np.eye(n, n + 2, 2)


def newton_steps(path, normals, bases, stiffness=None, force=None):
    """Steps (n, D) onto the surface and to a path without pull along it, by one dense system.

    A further force along the tangents, force (n, d) less stiffness (n, d, d) times the step along them, is added.
    """
    n, D = path.shape
    d = bases.shape[1]
    T = np.zeros(((n - 2) * D, (n - 2) * d))
    for i, basis in enumerate(bases[1:-1]):
        T[i * D : (i + 1) * D, i * d : (i + 1) * d] = basis.T
    bend = np.kron(second_differences(n - 2), np.eye(D))
    inner, r = bend[:, D:-D], normals[1:-1].ravel()
    matrix, right = T.T @ inner @ T, -T.T @ (bend @ path.ravel() - inner @ r)
    if stiffness is not None:
        matrix = matrix - block_diag(*stiffness[1:-1])
        right = right - force[1:-1].ravel()
    t = np.linalg.solve(matrix, right)
    steps = np.zeros((n, D))
    steps[1:-1] = (T @ t - r).reshape(n - 2, D)
    return steps


def mix(moves, changes, steps):
    """Anderson's acceleration, by least squares."""
    flat = changes.reshape(len(changes), -1)
    gamma = np.linalg.lstsq(flat.T, steps.ravel(), rcond=None)[0]
    return steps - np.tensordot(gamma, moves + changes, axes=1)


def follow_surface(surface, x, frame):
    """Displacement across the surface's own tangents at x, these tangents, and the frame turned toward them."""
    order, square = nearest(surface.points, x)
    weights = blend_weights(square)
    tangents, radii = surface.tangents[order[:-1]], surface.radii[order[:-1]]
    frame = orthonormalise(frame @ np.einsum("j,jac,jae->ce", weights * radii**2, tangents, tangents))[0]
    exponents = powers(len(frame), surface.degrees[-1])
    slopes, h = np.zeros((len(x), len(x))), 1e-5
    for i, weight, A in zip(order, weights, tangents, strict=False):
        u = A @ (x - surface.points[:, i])
        u = u * min(1.0, REACH / max(np.linalg.norm(u), 1e-300))
        ahead = np.array([np.prod((u + h * e) ** exponents, axis=1) for e in np.eye(len(u))])
        behind = np.array([np.prod((u - h * e) ** exponents, axis=1) for e in np.eye(len(u))])
        slopes += weight * surface.bends[i] @ ((ahead - behind) / (2.0 * h)).T @ A
    basis = orthonormalise(frame @ slopes.T)[0]
    normal = sum(w * anchor_displacement(surface, i, x) for i, w in zip(order, weights, strict=False))
    return normal - basis.T @ (basis @ normal), basis, frame


def relax(surface, field, path, tolerance, cap, limit, share, own=False, rate=1.0):
    """Accelerated steps until the next one would be below the tolerance."""
    frames = [surface.tangents[nearest(surface.points, q)[0][0]] for q in path]
    moves, changes, steps, before = [], [], None, None
    size = next_size = np.inf
    earlier, iteration = 0.0, 0
    while next_size >= tolerance and iteration < limit:
        found = [displacement(surface, field, q)[:2] for q in path]
        if own:
            found = [follow_surface(surface, q, frame) for q, frame in zip(path, frames, strict=True)]
            frames = [frame for _, _, frame in found]
        normals, bases = np.array([f[0] for f in found]), np.array([f[1] for f in found])
        plain = newton_steps(path, normals, bases)
        last, size = size, np.linalg.norm(plain, axis=1).max()
        if iteration > 0:
            earlier, share = share, min(size / last, 1.0)
            moves, changes = [*moves, steps][-5:], [*changes, plain - before][-5:]
            if size >= 2.0 * last:
                moves, changes = [], []
        next_size = size * (share if iteration < 2 else max(share, earlier))
        steps = mix(np.array(moves), np.array(changes), plain) if moves else plain
        lengths = np.linalg.norm(steps, axis=1)
        steps = steps * np.minimum(rate, cap / np.maximum(lengths, 1e-300))[:, None]
        before, path, iteration = plain, path + steps, iteration + 1
    return path, iteration, next_size, share


def refine(coarse, count):
    """The curve through the states of `coarse` that is cubic through the four states around each stretch."""
    at = np.linspace(0, len(coarse) - 1, count)
    first = np.clip(at.astype(int) - 1, 0, len(coarse) - 4)
    states = []
    for t, j in zip(at, first, strict=True):
        nodes = np.arange(j, j + 4)
        weights = [np.prod([(t - m) / (k - m) for m in nodes if m != k]) for k in nodes]
        states.append(weights @ coarse[j : j + 4])
    return np.array(states)


def relax_on_field(field, path, tolerance, limit):
    """Both printed conditions with frozen projectors as one dense system, until the step is below the tolerance."""
    n, D = path.shape
    eye = np.eye(D)

    def across(x):
        basis, _ = tangent_basis(field, x)
        return eye - basis.T @ basis

    moved, iteration = np.inf, 0
    while moved >= tolerance and iteration < limit:
        matrix = np.zeros((n * D, n * D))
        matrix[:D, :D] = matrix[-D:, -D:] = eye
        for i in range(1, n - 1):
            N = across(path[i])
            before = N @ across((path[i - 1] + path[i]) / 2) + eye - N
            after = N @ across((path[i] + path[i + 1]) / 2) + eye - N
            matrix[i * D : (i + 1) * D, (i - 1) * D : (i + 2) * D] = np.hstack([-before, before + after, -after])
        right = np.zeros(n * D)
        right[:D], right[-D:] = path[0], path[-1]
        new = np.linalg.solve(matrix, right).reshape(n, D)
        moved = np.linalg.norm(new - path, axis=1).max()
        path, iteration = new, iteration + 1
    return path, iteration, moved


def mean_curvature(problem, field, eps, misfit, every):
    """Curvature of the training objective averaged over the directions of ε, for one column of H; (K D, K D)."""
    d, D, E = field.shape
    share = (misfit**2).sum() / (problem.steps**2).sum()
    thinned = range(0, E, every)
    matrix = problem.ridge * np.kron(problem.smoothness, np.eye(D))
    for e in thinned:
        H = field[:, :, e].T
        Q = np.eye(D) - H @ np.linalg.inv(H.T @ H + problem.ridge * np.eye(d)) @ H.T + share * np.eye(D)
        weight = E / len(thinned) * eps[:, e] @ eps[:, e] / d
        matrix += weight * np.kron(np.outer(problem.values[:, e], problem.values[:, e]), Q)
    return matrix


def wendland(r):
    """Wendland's C² weight for 0 <= r <= 1."""
    return (1 - r) ** 4 * (4 * r + 1)


def local_fit(offsets, dim, exponents, turning, ridge=1e-10, turns=2):
    """Weighted least squares polynomial through offsets (k, D) in the frame of its own slope, by `lstsq`.

    Returns the frame (D, D), the radius and the coefficients (P, D - d) of the monomials with the exponents given;
    the first `turning` of them tell the slope.
    """
    distances = np.linalg.norm(offsets, axis=1)
    radius = 1.05 * distances.max()
    weights = wendland(distances / radius)
    mean = weights @ offsets / weights.sum()
    frame = np.linalg.eigh((offsets - mean).T @ np.diag(weights) @ (offsets - mean))[1][:, ::-1].T

    def fit(terms):
        local = offsets @ frame.T
        rows = np.prod((local[:, None, :dim] / radius) ** exponents[:terms], axis=2) * np.sqrt(weights)[:, None]
        damped = np.vstack([rows, np.sqrt(ridge * weights.sum()) * np.eye(terms)])
        right = np.vstack([local[:, dim:] * np.sqrt(weights)[:, None], np.zeros((terms, offsets.shape[1] - dim))])
        return np.linalg.lstsq(damped, right, rcond=None)[0]

    for _ in range(turns):
        slope = fit(turning)[1 : 1 + dim] / radius
        frame = orthonormalise(np.vstack([frame[:dim] + slope @ frame[dim:], frame[dim:]]))[0]
    return frame, radius, fit(len(exponents))
