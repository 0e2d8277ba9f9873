"""Plain NumPy twins of the kernels of `skillfold.manifold.kernels`, written for clarity from their descriptions.

Each takes a kernel's arguments without its scratch memory and returns what the kernel writes. None calls a kernel.
"""

from itertools import combinations_with_replacement

import numpy as np

BLENDED = 8
REACH = 1.5
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


def powers(dim, degree):
    """Exponents (P, dim) of the monomials, by degree, then in lexicographic order of their factors."""
    factors = [c for g in range(degree + 1) for c in combinations_with_replacement(range(dim), g)]
    return np.array([[c.count(a) for a in range(dim)] for c in factors])


def polynomial(exponents, coefficients, u):
    """Values (n,) of Σ_j c_j u^{p_j}, c (n, P); beyond |u| = REACH along the tangent of the ray through u."""
    length = np.linalg.norm(u)
    edge = u * min(1.0, REACH / length) if length > 0 else u
    terms = np.prod(edge**exponents, axis=1)
    value = coefficients @ terms
    if length > REACH:
        # Euler: a monomial of degree g has derivative g × itself / |u| along the ray.
        slope = coefficients @ (terms * exponents.sum(1)) / REACH
        value = value + slope * (length - REACH)
    return value


def anchor_displacement(surface, i, x):
    """From anchor i's own surface to x along its normals: (D,)."""
    normals_count = surface.coefficients.shape[1]
    tangents, normals = np.split(surface.frames[i], [len(x) - normals_count])
    offset = x - surface.points[:, i]
    exponents = powers(len(tangents), surface.degrees[-1])
    height = polynomial(exponents, surface.coefficients[i], tangents @ offset / surface.radii[i])
    return (normals @ offset - height) @ normals


def nearest(points, x):
    """Indices and squared distances of the anchors that an evaluation at x looks at, the nearest first."""
    square = ((points - x[:, None]) ** 2).sum(0)
    order = np.argsort(square, kind="stable")[: min(BLENDED, points.shape[1] - 1) + 1]
    return order, square[order]


def displacement(surface, field, x):
    """Displacement from the blended surface to x, H's tangents there, nearest square, the anchors' disagreement."""
    order, square = nearest(surface.points, x)
    width = square[-1] - square[0]
    r = np.sqrt((square[:-1] - square[0]) / width) if width > 0 else np.zeros(len(order) - 1)
    weights = (1 - r) ** 4 * (4 * r + 1)
    weights = weights / weights.sum()
    parts = np.array([anchor_displacement(surface, i, x) for i in order[:-1]])
    mean = weights @ parts
    spread = weights @ (parts**2).sum(1) - (mean**2).sum()
    basis, _ = tangent_basis(field, x)
    return mean - basis.T @ (basis @ mean), basis, square[0], np.sqrt(max(spread, 0.0))


def descend(surface, field, trust, bounded, state, point, tolerance=1e-10, steps=30):
    """Anchored Newton toward `state` along the surface; the point reached and whether it is on the surface."""
    rate, before, previous = 1.0, np.inf, point
    for step in range(steps):
        normal, basis, square, doubt = displacement(surface, field, point)
        if bounded and step > 0 and (square > trust.spacing**2 or doubt > trust.doubt):
            rate, point = rate / 2, previous
            normal, basis, _, _ = displacement(surface, field, point)
        along = basis.T @ (basis @ (state - point))
        off, pull = np.linalg.norm(normal), np.linalg.norm(along)
        if off < tolerance and rate * pull < tolerance:
            return point, True
        if rate < 1e-3:
            break
        if pull > 0.7 * before:
            rate = max(0.6 * rate, 0.05)
        before, previous = pull, point
        forth = min(rate, trust.cap / max(pull, 1e-300))
        point = point + forth * along - min(1.0, trust.cap / max(off, 1e-300)) * normal
    return step_back(surface, field, point, tolerance)


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


def project_state(surface, field, trust, state):
    """The closest trusted point of the surface, and whether one was met."""
    order, _ = nearest(surface.points, state)
    normal, _, _, doubt = displacement(surface, field, state)
    if np.linalg.norm(normal) < 1e-10:
        return state, True
    if np.linalg.norm(normal) < 0.25 * surface.radii[order[0]] and doubt < 10.0 * trust.doubt:
        point, met = descend(surface, field, trust, False, state, state)
        if met:
            return point, True
    anchors = surface.points.T[starts(surface, trust, state)]
    foot, met = step_back(surface, field, anchors[0], 1e-10)
    found = [descend(surface, field, trust, True, state, anchor, 1e-4, 12) for anchor in anchors]
    rough = [point for point, good in found if good]
    if rough:
        best = min(rough, key=lambda point: np.linalg.norm(state - point))
        best, settled = descend(surface, field, trust, True, state, best)
        if settled and (not met or np.linalg.norm(state - best) < np.linalg.norm(state - foot)):
            return best, True
    return (foot, True) if met else (anchors[0], False)


def distance(surface, field, trust, state, enough):
    """Length of the displacement where that is small and sure enough, else of the way to the projection."""
    normal, _, _, doubt = displacement(surface, field, state)
    off = np.linalg.norm(normal)
    if off <= enough and doubt <= 10.0 * trust.doubt:
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
    left, right = [start], [goal]
    while np.linalg.norm(right[-1] - left[-1]) > 1.5 * step:
        if len(left) + len(right) == limit:
            return None
        here, there = (left, right) if len(left) == len(right) else (right, left)
        gap = there[-1] - here[-1]
        _, basis, _, _ = displacement(surface, field, here[-1])
        direction = basis.T @ (basis @ gap)
        if np.linalg.norm(direction) < 1e-6 * np.linalg.norm(gap):
            return None
        new = here[-1] + step * direction / np.linalg.norm(direction)
        for _ in range(2):
            new = new - displacement(surface, field, new)[0]
        here.append(new)
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


def relax_step(surface, field, path, cap):
    """One iteration of `relax` by one dense system; the new path, the longest step, the largest residual."""
    n, D = path.shape
    parts = [displacement(surface, field, q)[:2] for q in path[1:-1]]
    r = np.array([normal for normal, _ in parts])
    T = np.zeros(((n - 2) * D, (n - 2) * len(parts[0][1])))
    d = len(parts[0][1])
    for i, (_, basis) in enumerate(parts):
        T[i * D : (i + 1) * D, i * d : (i + 1) * d] = basis.T
    bend = np.kron(second_differences(n - 2), np.eye(D))
    inner = bend[:, D:-D]
    t = np.linalg.solve(T.T @ inner @ T, -T.T @ (bend @ path.ravel() - inner @ r.ravel()))
    delta = (T @ t - r.ravel()).reshape(n - 2, D)
    sizes = np.linalg.norm(delta, axis=1)
    new = path.copy()
    new[1:-1] += delta * np.minimum(1.0, cap / np.maximum(sizes, 1e-300))[:, None]
    return new, sizes.max(), np.linalg.norm(r, axis=1).max()


def relax(surface, field, path, tolerance, cap, limit):
    """`relax_step` until its step is below the tolerance."""
    moved = off = np.inf
    iteration = 0
    while moved >= tolerance and iteration < limit:
        path, moved, off = relax_step(surface, field, path, cap)
        iteration += 1
    return path, iteration, moved, off


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
    d, D = field.shape[1:]
    share = (misfit**2).sum() / (problem.steps**2).sum()
    thinned = range(0, len(eps), every)
    matrix = problem.ridge * np.kron(problem.smoothness, np.eye(D))
    for e in thinned:
        H = field[e].T
        Q = np.eye(D) - H @ np.linalg.inv(H.T @ H + problem.ridge * np.eye(d)) @ H.T + share * np.eye(D)
        weight = len(eps) / len(thinned) * eps[e] @ eps[e] / d
        matrix += weight * np.kron(np.outer(problem.values[e], problem.values[e]), Q)
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
