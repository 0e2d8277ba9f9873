"""The Numba loops over distances: the smallest, its gradient, all within reach.

Bounding spheres and boxes first, MuJoCo's exact distance for the pairs that are left. `c` is a table (see `tables`)
of a robot among obstacles, the slots of `kinematics` first. Pure functions but for the `MjData` and the scratch
memory in it, which they overwrite: one table per thread. The tests hold plain twins.
"""

import math

import numpy as np

from skillfold.jit import inner, njit
from skillfold.robots import kinematics as kin
from skillfold.robots import shape_distances as shapes
from skillfold.robots.kinematics import add_motion, place
from skillfold.robots.shape_distances import CENTRES, RADII, TRIAL, box_gap, gap, measured, nearer
from skillfold.tables import Array, Indices, index_matrix, indices, matrix, vector

PAIRS = shapes.SLOTS  # (P, 2) shapes whose distance counts
BOUNDS = shapes.SLOTS + 1  # (P, K) longest way a point of one moves against the other while joint k moves by one
BODIES = shapes.SLOTS + 2  # (n_shapes,) that they belong to
MOCAP_POS, MOCAP_QUAT = shapes.SLOTS + 3, shapes.SLOTS + 4  # (M, 3), (M, 4) MuJoCo's, overwritten
STANDING_POS, STANDING_QUAT = (
    shapes.SLOTS + 5,
    shapes.SLOTS + 6,
)  # where they stand: the robot's file may have some too
LOWER, UPPER = shapes.SLOTS + 7, shapes.SLOTS + 8  # (dof,) limits that count as obstacles; infinite where they do not
# Points in clusters. MuJoCo's model has one proxy sphere of each radius, put where it is asked for.
CLUSTERS, REACHES = shapes.SLOTS + 9, shapes.SLOTS + 10  # (C, 3), (C,) bounding spheres, with the points' radius
STARTS = shapes.SLOTS + 11  # (C + 1,) first point of each
PROXIES = shapes.SLOTS + 12  # (C,) shape that stands in for their points
POINTS = shapes.SLOTS + 13  # (N, 3) in the world
FEELERS = shapes.SLOTS + 14  # (G,) shapes of the robot that they are compared with
FEELER_BOUNDS = shapes.SLOTS + 15  # (G, K) as BOUNDS
# Scratch: the nearest pair and its nearest points. As a pair, (-1, k) and (-2, k) are the lower and the upper limit
# of coordinate k.
WINNER, SEGMENT = shapes.SLOTS + 16, shapes.SLOTS + 17
GAPS = shapes.SLOTS + 18  # (P,) scratch: between bounding spheres
SLOTS = shapes.SLOTS + 19

FAR = 1e6  # metres: farther than any scene is wide
TOUCH = 1e-9  # metres: below this the segment between nearest points has no direction left


@inner
def stand(q: Array, c: Indices) -> None:
    """Bring robot and moving obstacles to their places."""
    position, turn = matrix(c, MOCAP_POS), matrix(c, MOCAP_QUAT)
    new_position, new_turn = matrix(c, STANDING_POS), matrix(c, STANDING_QUAT)
    for i in range(len(position)):
        for a in range(3):
            position[i, a] = new_position[i, a]
        for a in range(4):
            turn[i, a] = new_turn[i, a]
    place(q, c)


@inner
def finite(q: Array) -> bool:
    """Whether all numbers are: MuJoCo finds nothing near a robot that is nowhere."""
    total = 0.0
    for k in range(q.size):
        total += abs(q[k])
    return total < math.inf


@inner
def keep(a: int, b: int, c: Indices) -> None:
    """Remember a pair and the nearest points in TRIAL."""
    winner, segment, trial = indices(c, WINNER), vector(c, SEGMENT), vector(c, TRIAL)
    winner[0], winner[1] = a, b
    for i in range(6):
        segment[i] = trial[i]


@inner
def closest_spheres(c: Indices) -> int:
    """The pair whose bounding spheres are closest, -1 without pairs; GAPS between all of them."""
    pairs, centres, radii, gaps = index_matrix(c, PAIRS), matrix(c, CENTRES), vector(c, RADII), vector(c, GAPS)
    first, least = -1, math.inf
    for p in range(len(pairs)):
        a, b = pairs[p, 0], pairs[p, 1]
        gaps[p] = gap(centres, a, centres, b) - radii[a] - radii[b]
        if gaps[p] < least:
            first, least = p, gaps[p]
    return first


@inner
def nearest_pair(best: float, c: Indices) -> float:
    """Smallest distance over the pairs of shapes, at most `best`."""
    pairs, gaps = index_matrix(c, PAIRS), vector(c, GAPS)
    # What the closest spheres enclose is likely near, and spares the others an exact distance.
    first = closest_spheres(c)
    for turn in range(len(pairs) + 1):
        p = first if turn == 0 else turn - 1
        if p < 0 or (turn > 0 and p == first) or gaps[p] >= best:
            continue
        a, b = pairs[p, 0], pairs[p, 1]
        if box_gap(a, b, c) >= best:
            continue
        distance = measured(a, b, best, c)
        if distance < best:
            best = distance
            keep(a, b, c)
    return best


@inner
def nearest_point(g: int, best: float, c: Indices) -> float:
    """Smallest distance of one shape of the robot to all points, at most `best`."""
    centres, radii, points = matrix(c, CENTRES), vector(c, RADII), matrix(c, POINTS)
    clusters, reaches = matrix(c, CLUSTERS), vector(c, REACHES)
    starts, proxies, shape = indices(c, STARTS), indices(c, PROXIES), indices(c, FEELERS)[g]
    for cluster in range(len(clusters)):
        if gap(centres, shape, clusters, cluster) - radii[shape] - reaches[cluster] >= best:
            continue
        proxy = proxies[cluster]
        for i in range(starts[cluster], starts[cluster + 1]):
            if gap(centres, shape, points, i) - radii[shape] - radii[proxy] >= best:
                continue
            for a in range(3):
                centres[proxy, a] = points[i, a]
            distance = measured(shape, proxy, best, c)
            if distance < best:
                best = distance
                keep(shape, proxy, c)
    return best


@inner
def nearest_limit(q: Array, best: float, c: Indices) -> float:
    """Smallest way of a coordinate to a limit that counts, at most `best`."""
    lower, upper, winner = vector(c, LOWER), vector(c, UPPER), indices(c, WINNER)
    for k in range(q.size):
        if q[k] - lower[k] < best:
            best = q[k] - lower[k]
            winner[0], winner[1] = -1, k
        if upper[k] - q[k] < best:
            best = upper[k] - q[k]
            winner[0], winner[1] = -2, k
    return best


@inner
def slope(a: int, b: int, segment: Array, distance: float, c: Indices, out: Array) -> None:
    """Derivative (dof,) of the distance of two shapes with these nearest points (6,), by q."""
    out[:] = 0.0
    centres, bodies = matrix(c, CENTRES), indices(c, BODIES)
    x, y, z, length = segment[3] - segment[0], segment[4] - segment[1], segment[5] - segment[2], distance
    if abs(distance) < TOUCH:
        # Touching shapes share a point: take the way between their centres instead.
        x, y, z = centres[b, 0] - centres[a, 0], centres[b, 1] - centres[a, 1], centres[b, 2] - centres[a, 2]
        length = max(gap(centres, a, centres, b), 1e-300)
    moves, columns, ratios = index_matrix(c, kin.MOVES), indices(c, kin.COLUMNS), vector(c, kin.RATIOS)
    velocity = np.empty(3)
    for k in range(columns.size):
        left, right = moves[bodies[a], k], moves[bodies[b], k]
        if left == right:  # neither moves, or both as one
            continue
        velocity[:] = 0.0
        if right:
            add_motion(c, k, segment[3:], ratios[k] / length, velocity)
        else:
            add_motion(c, k, segment, -ratios[k] / length, velocity)
        out[columns[k]] += x * velocity[0] + y * velocity[1] + z * velocity[2]


@njit
def clearance(q: Array, gradient: Array, c: Indices) -> float:
    """Clearance at q (dof,); its gradient in `gradient`, left alone where that has no length.

    WINNER and SEGMENT tell between what and where. NaN where q is not finite: that is not clear of anything.
    """
    winner = indices(c, WINNER)
    if not finite(q):
        return math.nan
    stand(q, c)
    winner[0], winner[1] = -3, 0
    best = nearest_pair(FAR, c)
    for g in range(indices(c, FEELERS).size):
        best = nearest_point(g, best, c)
    best = nearest_limit(q, best, c)
    if gradient.size:
        if winner[0] >= 0:
            slope(winner[0], winner[1], vector(c, SEGMENT), best, c, gradient)
        else:
            gradient[:] = 0.0
            if winner[0] > -3:
                gradient[winner[1]] = 1.0 if winner[0] == -1 else -1.0
    return best if best < FAR else math.inf


@njit
def within(q: Array, reach: float, distances: Array, gradients: Array, c: Indices) -> int:
    """How many pairs are nearer than `reach`; their distances (at most as many as fit) and gradients (…, dof).

    -1 where q is not finite. One entry for each pair of shapes, and one for each shape of the robot with the nearest
    point of the clouds. Joint limits are left out.
    """
    if not finite(q):
        return -1
    stand(q, c)
    pairs = index_matrix(c, PAIRS)
    winner, segment, trial = indices(c, WINNER), vector(c, SEGMENT), vector(c, TRIAL)
    count = 0
    for p in range(len(pairs)):
        a, b = pairs[p, 0], pairs[p, 1]
        if not nearer(a, b, reach, c):
            continue
        distance = measured(a, b, reach, c)
        if distance < reach and count < distances.size:
            distances[count] = distance
            slope(a, b, trial, distance, c, gradients[count])
            count += 1
    for g in range(indices(c, FEELERS).size):
        distance = nearest_point(g, reach, c)
        if distance < reach and count < distances.size:
            distances[count] = distance
            slope(winner[0], winner[1], segment, distance, c, gradients[count])
            count += 1
    return count


@njit
def clearances(states: Array, c: Indices, out: Array, gradients: Array) -> None:
    """Clearance (n,) at joint positions (n, dof), and gradients (n, dof) unless `gradients` is (0, dof)."""
    for i in range(len(states)):
        out[i] = clearance(states[i], gradients[i] if len(gradients) else gradients.ravel(), c)
