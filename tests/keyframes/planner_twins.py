"""Plain NumPy and SciPy twins of the planner's loops; none calls a kernel of its own."""

import numpy as np
from scipy.spatial.transform import Rotation

from keyframes.asked import TURN, UNITS
from skillfold.keyframes.grown import REACH
from skillfold.keyframes.kernels import descent, edges, nodes, rrtstar


def turned(angle):
    return angle - TURN * np.floor(angle / TURN + 0.5)


def difference(turning, a, b):
    d = b - a
    return np.where(turning, turned(d), d)


def gap(turning, a, b):
    return np.linalg.norm(difference(turning, a, b), axis=-1)


def along_axis(axis, y):
    way = (axis[1] - axis[0]) * UNITS
    return np.clip(way @ ((y - axis[0]) * UNITS) / (way @ way), 0.0, 1.0) if way @ way > 0 else 0.0


def pull(axis, y, target):
    ahead = target - y
    line = axis[0] + along_axis(axis, y) * (axis[1] - axis[0])
    offset = target - (axis[0] + along_axis(axis, target) * (axis[1] - axis[0]))
    step = descent.GAIN * (ahead + line + offset - y)
    length = np.linalg.norm(step * UNITS)
    return step * min(1.0, descent.STRIDE / length), np.linalg.norm(ahead * UNITS)


def twist(pose, wanted):
    """From one pose to the other, turns as `LENGTH` metres."""
    a, b = (Rotation.from_quat(p[3:], scalar_first=True) for p in (pose, wanted))
    return np.concatenate([wanted[:3] - pose[:3], (b * a.inv()).as_rotvec()]) * UNITS


class Twin:
    """Descents, edges and the tree in plain code, for one question."""

    def __init__(self, asked):
        self.asked, self.leg, self.robot = asked, asked.leg, asked.robot
        self.turning, self.margin = asked.question.turning, asked.question.margin

    def excess(self, pose):
        return np.sqrt(self.leg.hold.membership(pose)[0]) - 1.0

    def is_inside(self, pose):
        return self.excess(pose) <= self.leg.level

    def is_goal(self, pose):
        return np.sqrt(self.leg.goal.membership(pose)[0]) - 1.0 <= self.leg.goal_level

    def keep_inside(self, wanted):
        if self.is_inside(wanted):
            return wanted
        chart = self.leg.chart
        there, nearest = chart.to_chart(wanted), chart.to_chart(self.leg.hold.project(wanted))
        return chart.to_pose(nearest + descent.INWARD * (nearest - there))

    def jacobian(self, q):
        return self.robot.jacobian(q) * UNITS[:, None]

    def follow(self, q, wanted):
        J = self.jacobian(q)
        step = J.T @ np.linalg.solve(J @ J.T + descent.DAMPING * np.eye(6), twist(self.robot.forward(q), wanted))
        step *= min(1.0, REACH / np.linalg.norm(step))
        return np.clip(q + step, *self.robot.limits)

    def descend(self, q, target, constrained):
        chart = self.leg.chart
        y = chart.to_chart(self.robot.forward(q))
        step, left = pull(self.leg.axis, y, target)
        wanted = chart.to_pose(y + step)
        return self.follow(q, self.keep_inside(wanted) if constrained else wanted), left

    def stays_inside(self, a, b):
        """As closely as the loop looks, from another side: all poses at once."""
        d = difference(self.turning, a, b)
        spans = int(np.linalg.norm(d) / edges.SPAN) + 1
        values = [self.excess(self.robot.forward(a + i / (2 * spans) * d)) for i in range(2 * spans + 1)]
        for i in range(spans):
            first, middle, last = values[2 * i : 2 * i + 3]
            if max(middle, last) > self.leg.level:
                return False
            if max(first, middle, last) + abs(first - 2 * middle + last) > self.leg.level:
                shares = (i + np.arange(1, edges.CLOSER) / edges.CLOSER) / spans
                if max(self.excess(self.robot.forward(a + s * d)) for s in shares) > self.leg.level:
                    return False
        return True

    def is_clear(self, q):
        return self.asked.obstacles.clearance(q) > self.margin

    def seems_to_hold(self, a, b):
        d = difference(self.turning, a, b)
        return self.is_clear(a + 0.5 * d) and self.stays_inside(a, b)

    def edge_is_clear(self, a, b):
        return self.asked.obstacles.edge_advance(a, a + difference(self.turning, a, b), self.margin) >= 1.0


class Tree:
    """Nodes in lists; costs are summed anew along parents whenever they are asked for."""

    def __init__(self, twin, root):
        self.twin, self.leg = twin, twin.leg
        self.q, self.z, self.parents, self.goals, self.weights = [], [], [], [], []
        self.put(root, -1)

    def put(self, q, parent):
        pose = self.twin.robot.forward(q)
        self.q.append(np.array(q))
        self.z.append(self.leg.metric @ self.leg.chart.to_chart(pose))
        self.parents.append(parent)
        self.goals.append(bool(self.twin.is_goal(pose)))
        self.weights.append(1.0)

    def cost(self, node):
        parent = self.parents[node]
        if parent < 0:
            return 0.0
        return self.cost(parent) + gap(self.twin.turning, self.q[parent], self.q[node])

    def add(self, near, q, star):
        node, radius = len(self.q), np.sqrt(near_radius(len(self.q), len(q)))
        self.put(q, near)
        if not star:
            return node
        lengths = gap(self.twin.turning, np.array(self.q[:node]), q)
        close = [i for i in range(node) if lengths[i] < radius]
        through = {i: self.cost(i) + lengths[i] for i in close}
        now = self.cost(node)
        cheaper = [i for i in sorted(close, key=through.get) if through[i] < now - nodes.TIE and i != near][
            : nodes.TRIES
        ]
        for i in cheaper:
            if self.twin.seems_to_hold(self.q[i], q):
                self.parents[node] = i
                break
        for i in close:
            if i == 0 or i == self.parents[node] or self.cost(i) - self.cost(node) - lengths[i] <= nodes.TIE:
                continue
            if self.twin.seems_to_hold(q, self.q[i]):
                self.parents[i] = node
        return node

    def try_add(self, near, q, star):
        pose = self.twin.robot.forward(q)
        fits = self.twin.is_inside(pose) and self.twin.is_clear(q) and self.twin.seems_to_hold(self.q[near], q)
        return self.add(near, q, star) if fits else -1

    def nearest(self, white):
        return int((np.array(self.weights) * ((np.array(self.z) - white) ** 2).sum(1)).argmin())

    def extend(self, target, star):
        near = self.nearest(self.leg.metric @ target)
        q, last, newest, before = self.q[near].copy(), near, -1, np.inf
        for _ in range(rrtstar.STEPS):
            q, left = self.twin.descend(q, target, True)
            done = left < rrtstar.ARRIVED or left > rrtstar.PROGRESS * before
            before, length = left, gap(self.twin.turning, self.q[last], q)
            if length >= rrtstar.LEAST and (done or length >= 0.5 * REACH):
                node = self.try_add(last, q, star)
                if node < 0:
                    break
                last = newest = node
                done = done or self.goals[node]
            if done:
                break
        if newest < 0:
            self.weights[near] *= rrtstar.REFUSED
        return newest

    def get_inside(self, q, target, goal):
        before = np.inf
        for _ in range(rrtstar.STEPS):
            q, left = self.twin.descend(q, target, False)
            pose = self.twin.robot.forward(q)
            if self.twin.is_inside(pose) and (not goal or self.twin.is_goal(pose)):
                return q
            if left > rrtstar.PROGRESS * before:
                return None
            before = left
        return None

    def connect(self, q, star):
        lengths = gap(self.twin.turning, np.array(self.q), q)
        last, newest = int(lengths.argmin()), -1
        q = self.q[last] + difference(self.twin.turning, self.q[last], q)
        for i in range(int(lengths.min() / REACH) + 1, 0, -1):
            node = self.try_add(last, self.q[last] + (q - self.q[last]) / i, star)
            if node < 0:
                break
            last = newest = node
            if self.goals[node]:
                break
        return newest

    def grow(self, targets, kinds, starts, first):
        for t, target in enumerate(targets):
            newest = -1
            if kinds[t] == rrtstar.FROM_TREE:
                newest = self.extend(target, not first)
            else:
                far = kinds[t] == rrtstar.FROM_FAR
                q = starts[t] if kinds[t] >= rrtstar.JOIN else self.get_inside(starts[t], target, far)
                newest = -1 if q is None else self.connect(q, not first)
                if kinds[t] == rrtstar.END and newest >= 0:
                    same = gap(self.twin.turning, self.q[newest], starts[t]) < 1e-9
                    self.goals[newest] = self.goals[newest] or bool(same)
            if first and newest >= 0 and self.goals[newest]:
                return t + 1
        return len(targets)


def near_radius(count, dof):
    n = max(count, 2)
    return min(nodes.FACTOR * (np.log(n) / n) ** (1 / dof), nodes.WIDEST) ** 2
