"""Which pairs of shapes can collide."""

from typing import Any

import numpy as np

from skillfold.robots.engine import mujoco
from skillfold.robots.joints import Joints, moves_of
from skillfold.robots.merging import Merged
from skillfold.tables import Indices

SAMPLES = 40  # random poses after which a pair that touched in all of them counts as neighbours


def self_pairs(merged: Merged, joints: Joints) -> Indices:
    """(P, 2) pairs of the robot's own shapes whose distance can change and can become zero.

    Left out: shapes of one rigid part or of neighbours, pairs that the model excludes, and pairs that touch in every
    one of some random poses: neighbours too, though parts without shapes lie between.
    """
    model = merged.model
    moves = moves_of(model, joints)
    excluded = {(int(s) >> 16, int(s) & 0xFFFF) for s in model.exclude_signature}
    pairs = []
    for i, a in enumerate(merged.own):
        for b in merged.own[i + 1 :]:
            left, right = int(model.geom_bodyid[a]), int(model.geom_bodyid[b])
            meet = (model.geom_contype[a] & model.geom_conaffinity[b]) | (
                model.geom_contype[b] & model.geom_conaffinity[a]
            )
            fixed = (moves[left] == moves[right]).all()
            apart = (left, right) in excluded or (right, left) in excluded or _neighbours(model, left, right)
            if meet and not fixed and not apart:
                pairs.append((int(a), int(b)))
    return _ever_apart(model, joints, np.array(pairs, np.int64).reshape(-1, 2))


def scene_pairs(merged: Merged, joints: Joints, obstacles: list[int]) -> Indices:
    """(P, 2) pairs of a shape of the robot that moves and an obstacle's; what a fixed base touches is left out."""
    return np.array([(g, o) for o in obstacles for g in moving(merged, joints)], np.int64).reshape(-1, 2)


def moving(merged: Merged, joints: Joints) -> list[int]:
    """Shapes of the robot that joints move, and all of them where the base is free."""
    model = merged.model
    moves = moves_of(model, joints)
    rooted = [int(model.geom_bodyid[g]) for g in merged.own]
    free = joints.base is not None
    return [int(g) for g, body in zip(merged.own, rooted, strict=True) if moves[body].any() or (free and body > 0)]


def _neighbours(model: Any, left: int, right: int) -> bool:
    if 0 in (left, right):  # a floor or wall of the robot's file, not its base
        return False
    a, b = int(model.body_weldid[left]), int(model.body_weldid[right])
    above = [int(model.body_weldid[model.body_parentid[x]]) for x in (a, b)]
    return a == b or above[0] == b or above[1] == a


def _ever_apart(model: Any, joints: Joints, pairs: Indices) -> Indices:
    """The pairs that do not touch in every one of some random poses."""
    data, segment = mujoco.MjData(model), np.zeros(6)
    data.qpos[: len(joints.rest)] = joints.rest
    lower, upper = (np.where(np.isfinite(v), v, s * np.pi) for v, s in zip(joints.limits, (-1, 1), strict=True))
    rng = np.random.default_rng(0)
    touching = np.ones(len(pairs), bool)
    for _ in range(SAMPLES):
        if not touching.any():
            break
        q = joints.offsets + joints.ratios * rng.uniform(lower, upper)[joints.columns]
        data.qpos[joints.addresses] = q
        mujoco.mj_kinematics(model, data)
        for p in np.flatnonzero(touching):
            a, b = (int(g) for g in pairs[p])
            touching[p] = mujoco.mj_geomDistance(model, data, a, b, 1.0, segment) < 0
    return pairs[~touching]
