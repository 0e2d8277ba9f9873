"""Plain NumPy twins of the kernels that go around obstacles, in whole coordinates; none calls a kernel.

What stands in the way is balls. States are (D,), the last f coordinates free.
"""

from typing import Any, NamedTuple

import numpy as np

from manifold import twins
from planning import twins as points

STEPS, ON = 12, 1e-7
FLAT = 0.2
LOCAL = 2.5
STIFF, STIFF_LIMIT, BLUNT, SIGHT, INSET = 10.0, 100.0, 0.1, 3.0, 0.005
STRIDE, FREED = 0.5, 0.3
RATE, EVENING = 0.3, 0.25


class Balls(NamedTuple):
    """Balls of one radius about points (m, D), in the space of states."""

    points: np.ndarray
    radius: float

    def clearance(self, states):
        return points.clearance(self.points, self.radius, states)

    def within(self, state, reach):
        return points.within(self.points, self.radius, state, reach)

    def share(self, start, end, margin):
        return points.share(self.points, self.radius, start, end, margin)


class Land(NamedTuple):
    """A surface and what is in the way."""

    surface: Any
    field: Any
    support: Any
    chart: Any
    balls: Balls


# Walking


def to_state(chart, z):
    return chart.centre + chart.scale * z @ chart.axes


def to_slope(chart, gradient):
    return chart.scale * chart.axes @ gradient


def in_limits(chart, state):
    return bool(((chart.lower <= state) & (state <= chart.upper)).all())


def whole_basis(basis, D):
    """Rows that span the tangents of whole coordinates: those of the surface, then the free axes."""
    d, kept = basis.shape
    rows = np.zeros((d + D - kept, D))
    rows[:d, :kept], rows[d:, kept:] = basis, np.eye(D - kept)
    return rows


def settle(land, z):
    """Straight onto the surface: z, the tangents where it was looked at last, whether it is there and believed."""
    kept, z = land.surface.points.shape[0], z.copy()
    for _ in range(STEPS):
        normal, basis, square, doubt = twins.displacement(land.surface, land.field, z[:kept])
        z[:kept] -= normal
        if np.linalg.norm(normal) < ON:
            return z, basis, bool(square < land.support.farthest and doubt < land.support.doubt)
    return z, basis, False


def edge_is_clear(land, a, b, margin):
    start, end = to_state(land.chart, a), to_state(land.chart, b)
    return in_limits(land.chart, end) and land.balls.share(start, end, margin) >= 1.0


def walk(land, start, target, step, margin, room):
    """States of a walk from start straight toward the target, and whether that is then within a step."""
    here, found = start, []
    _, basis, good = settle(land, start)
    if not good:
        return found, False
    while np.linalg.norm(target - here) > step:
        if len(found) == room:
            return found, False
        rows, left = whole_basis(basis, len(start)), np.linalg.norm(target - here)
        along = rows.T @ rows @ (target - here)
        if np.linalg.norm(along) < FLAT * left:
            return found, False
        there, basis, good = settle(land, here + step * along / np.linalg.norm(along))
        gained = left - np.linalg.norm(target - there) >= FLAT * step
        if not (good and gained and edge_is_clear(land, here, there, margin)):
            return found, False
        found.append(there)
        here = there
    return found, True


# Trees


def nearest(states, target):
    return int(np.linalg.norm(np.array(states) - target, axis=1).argmin())


class Tree:
    def __init__(self, root, room):
        self.states, self.parents, self.room, self.stuck = [root], [-1], room, set()

    def extend(self, land, target, step, margin):
        """Grow toward the target; the last new node or None."""
        near = nearest(self.states, target)
        added, _ = walk(land, self.states[near], target, step, margin, self.room - len(self.states))
        for state in added:
            self.parents.append(near if state is added[0] else len(self.states) - 1)
            self.states.append(state)
        return len(self.states) - 1 if added else None

    def branch(self, node):
        """States from the node to the root."""
        way = []
        while node >= 0:
            way.append(self.states[node])
            node = self.parents[node]
        return way


def look_aside(node, one, other, far):
    return node + far * (one - other) / np.linalg.norm(one - other)


def connect(land, ends, targets, step, margin, room):
    """The clear way that two trees find, each of `room` nodes at most, and how many targets it took."""
    trees = [Tree(end, room) for end in ends]
    for turn in range(len(targets)):
        tree, other = trees[turn % 2], trees[1 - turn % 2]
        target = other.states[0] if turn < 2 else targets[turn]
        near = nearest(tree.states, target)
        if near in tree.stuck and turn > 0:
            target = look_aside(tree.states[near], targets[turn], targets[turn - 1], LOCAL * step)
        newest = tree.extend(land, target, step, margin)
        if newest is None:
            tree.stuck.add(near)
            continue
        tip = tree.states[newest]
        last = other.extend(land, tip, step, margin)
        last = nearest(other.states, tip) if last is None else last
        met = other.states[last]
        if np.linalg.norm(met - tip) <= step * (1 + 1e-9) and edge_is_clear(land, met, tip, margin):
            halves = tree.branch(newest)[::-1] + other.branch(last)
            return np.array(halves if turn % 2 == 0 else halves[::-1]), turn + 1
    return np.empty((0, len(ends[0]))), len(targets)


def way(states):
    return np.linalg.norm(np.diff(states, axis=0), axis=1).sum()


def shorten(land, path, picks, step, margin):
    """The path with the shortcuts that are clear and shorter."""
    path = list(path)
    for pick in picks:
        i, j = sorted(int(share * len(path)) for share in pick)
        if j - i < 2:
            continue
        found, arrived = walk(land, path[i], path[j], step, margin, j - i - 1)
        last = found[-1] if found else path[i]
        if not arrived or not edge_is_clear(land, last, path[j], margin):
            continue
        if way([path[i], *found, path[j]]) <= 0.999 * way(path[i : j + 1]):
            path[i + 1 : j] = found
    return np.array(path)


# Pushes


def push(slope, depth, steepest, normal, tangents, stiff=STIFF):
    """Stiffness and force along the tangents of ½ stiff (depth / ‖slope‖)², off the surface by `normal`."""
    weight = stiff / max(slope @ slope, (BLUNT * steepest) ** 2, 1e-300)
    along = tangents @ slope
    return weight * np.outer(along, along), weight * along * (depth + slope @ normal)


def push_off_obstacles(chart, balls, state, normal, tangents, margin, steepest):
    """Stiffness, force, least clearance in sight, steepest gradient."""
    d = len(tangents)
    stiffness, force = np.zeros((d, d)), np.zeros(d)
    distances, gradients = balls.within(state, SIGHT * margin)
    for distance, gradient in zip(distances, gradients, strict=True):
        slope = to_slope(chart, gradient)
        steepest = max(steepest, np.linalg.norm(slope))
        if distance < margin:
            more, pushed = push(slope, margin - distance, steepest, normal, tangents)
            stiffness, force = stiffness + more, force + pushed
    return stiffness, force, min([SIGHT * margin, *distances]), steepest


def push_off_limits(chart, state, normal, tangents):
    d = len(tangents)
    stiffness, force = np.zeros((d, d)), np.zeros(d)
    for c, value in enumerate(state):
        depths = value - chart.upper[c], chart.lower[c] - value
        depth = max(depths) + INSET * chart.scale
        if depth > 0:
            sign = -1.0 if depths[0] > depths[1] else 1.0
            more, pushed = push(sign * chart.scale * chart.axes[:, c], depth, 0.0, normal, tangents, STIFF_LIMIT)
            stiffness, force = stiffness + more, force + pushed
    return stiffness, force


# Detours


def frames(land, path):
    """Displacements (n, D) and tangents (n, d, D)."""
    kept, (n, D) = land.surface.points.shape[0], path.shape
    normals, tangents = np.zeros((n, D)), []
    for i, z in enumerate(path):
        normals[i, :kept], basis, _, _ = twins.displacement(land.surface, land.field, z[:kept])
        tangents.append(whole_basis(basis, D))
    return normals, np.array(tangents)


class Memory:
    """What an iteration remembers of each of n states in D dimensions."""

    def __init__(self, n, D):
        self.steps, self.clear, self.slack, self.steepest = np.zeros((n, D)), np.zeros(n), np.zeros(n), 0.0


def bend_once(chart, balls, path, chain, normals, tangents, stiffness, force, margin, cap, memory):
    """The path after one step; `stiffness` and `force` are springs that are there besides the penalties."""
    n = len(path)
    stiffness, force = stiffness.copy(), force.copy()
    for i in range(1, n - 1):
        state = to_state(chart, path[i])
        pushes = [push_off_limits(chart, state, normals[i], tangents[i])]
        memory.slack[i] -= np.linalg.norm(memory.steps[i])
        if memory.slack[i] <= 0:
            *pushed, memory.clear[i], memory.steepest = push_off_obstacles(
                chart, balls, state, normals[i], tangents[i], margin, memory.steepest
            )
            pushes.append(pushed)
            if memory.clear[i] >= SIGHT * margin and memory.steepest > 0:
                memory.slack[i] = (memory.clear[i] - margin) / memory.steepest
        for more, pushed in pushes:
            stiffness[i] += more
            force[i] += pushed
    steps = twins.newton_steps(chain, normals, tangents, stiffness, force)
    for i in range(1, n - 1):
        stride = cap
        if memory.clear[i] < SIGHT * margin:
            stride = min(cap, max(STRIDE * memory.clear[i], FREED * margin) / memory.steepest)
        steps[i] *= min(1.0, stride / max(np.linalg.norm(steps[i]), 1e-300))
    memory.steps = steps
    return path + steps


def iterate(step, path, D, tolerance, limit):
    """The path after steps until none is longer than the tolerance; iterations, and the last."""
    memory, moved, iteration = Memory(len(path), D), np.inf, 0
    while iteration < limit and moved >= tolerance:
        path, iteration = step(path, memory), iteration + 1
        moved = np.linalg.norm(memory.steps, axis=1).max()
    return path, iteration, moved


class Hold:
    """What pulls a path back to the edge of the demonstrations; anchors around are looked up in some steps alone."""

    def __init__(self, land, path, spacing):
        self.rows, self.iteration, kept = land.surface.points.T, 0, len(land.surface.points)
        ways = [
            np.linalg.norm(twins.way_in(land.surface, land.field, path[i, :kept], path[j, :kept]))
            for i, j in ((0, 1), (-1, -2))
        ]
        self.allowed = max(0.02 * spacing, *(1.5 * way for way in ways))
        step = np.linalg.norm(np.diff(path, axis=0), axis=1).mean()
        self.stiffness = (step / (0.1 * spacing)) ** 2

    def __call__(self, path, tangents):
        """Stiffness (n, d, d) and force (n, d)."""
        (n, d, _), kept = tangents.shape, self.rows.shape[1]
        if self.iteration % 4 == 0 and self.iteration < 12:
            points = path[:, :kept]
            self.around = [np.argsort(((self.rows - x) ** 2).sum(1), kind="stable")[: 12 + 4 * d] for x in points]
        self.iteration += 1
        stiffness, force = np.zeros((n, d, d)), np.zeros((n, d))
        for i in range(1, n - 1):
            offsets = (self.rows[self.around[i]] - path[i, :kept]) @ tangents[i, :, :kept].T
            force[i], stiffness[i] = twins.pull_and_slope(offsets, self.allowed, self.stiffness)
        return stiffness, force


def bend_clear(land, path, margin, cap, tolerance, limit, hold=None):
    n, D = path.shape

    def step(path, memory):
        normals, tangents = frames(land, path)
        normals[[0, -1]] = 0.0
        d = tangents.shape[1]
        springs = (np.zeros((n, d, d)), np.zeros((n, d))) if hold is None else hold(path, tangents)
        return bend_once(land.chart, land.balls, path, path, normals, tangents, *springs, margin, cap, memory)

    return iterate(step, path, D, tolerance, limit)


def bend_aside(chart, balls, path, margin, reach, cap, tolerance, limit):
    n, D = path.shape
    before, eyes = path.copy(), np.tile(np.eye(D), (n, 1, 1))

    def step(path, memory):
        offsets = path - before
        springs = eyes / reach**2, -offsets / reach**2
        return bend_once(chart, balls, path, offsets, np.zeros((n, D)), eyes, *springs, margin, cap, memory)

    return iterate(step, path, D, tolerance, limit)


def settle_path(land, path):
    """Inner states on the surface, all moved as long as one is off; whether all got there and are believed."""
    kept, path = land.surface.points.shape[0], path.copy()
    for _ in range(STEPS):
        found = [twins.displacement(land.surface, land.field, z[:kept]) for z in path[1:-1]]
        off = max((np.linalg.norm(normal) for normal, *_ in found), default=0.0)
        for z, (normal, *_) in zip(path[1:-1], found, strict=True):
            z[:kept] -= normal
        if off < ON:
            break
    believed = all(square < land.support.farthest and doubt < land.support.doubt for _, _, square, doubt in found)
    return path, off < ON and believed


def first_blocked(land, path, margin):
    blocked = [i for i in range(len(path) - 1) if not edge_is_clear(land, path[i], path[i + 1], margin)]
    return blocked[0] if blocked else -1


# Springs


def pull_of(neighbour, here, rest):
    away = here - neighbour
    length = np.linalg.norm(away)
    return 0.5 * RATE * (rest - length) * away / length


def bend(path):
    """Second differences (n, D), zero at the ends, and their mean (D,) over the inner states."""
    bends = np.zeros(path.shape)
    bends[1:-1] = path[:-2] - 2 * path[1:-1] + path[2:]
    return bends, bends.sum(0) / max(len(path) - 2, 1)


def relax_springs(land, path, margin, tolerance, limit):
    rest, iteration, moved = way(path) / (len(path) - 1), 0, np.inf
    while iteration < limit and moved >= tolerance:
        normals, tangents = frames(land, path)
        bends, mean = bend(path)
        moves = np.zeros(path.shape)
        for i in range(1, len(path) - 1):
            distances, gradients = land.balls.within(to_state(land.chart, path[i]), margin)
            for distance, gradient in zip(distances, gradients, strict=True):
                slope = to_slope(land.chart, gradient)
                moves[i] += RATE * (margin - distance) * slope / max(slope @ slope, 1e-300) / len(distances)
            if len(distances):
                moves[i] += pull_of(path[i - 1], path[i], rest) + pull_of(path[i + 1], path[i], rest)
            moves[i] += EVENING * (bends[i] - mean)
            moves[i] = tangents[i].T @ tangents[i] @ moves[i]
        moved = np.linalg.norm(moves, axis=1).max()
        normals[[0, -1]] = 0.0
        path, iteration = path + moves - normals, iteration + 1
    return path, iteration, moved
