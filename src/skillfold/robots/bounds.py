"""What is known of shapes without asking for their distance: how large they are, how fast their points can move."""

from typing import Any

import numpy as np

from skillfold.robots.engine import mujoco
from skillfold.robots.joints import Joints, moves_of
from skillfold.tables import Array, Indices

ENDLESS = 10.0  # metres that a prismatic joint without limits is taken to travel
_GEOM = mujoco.mjtGeom


def shape_bounds(model: Any) -> tuple[Array, Array, Array, Array, Indices]:
    """Radii of bounding spheres, spines, girths (n_shapes,), bounding boxes (n_shapes, 6) and which shapes are boxes.

    All as in `distances`.
    """
    kinds, sizes = model.geom_type, model.geom_size
    planes = kinds == _GEOM.mjGEOM_PLANE
    radii = np.where(planes, np.inf, model.geom_rbound)
    long = (kinds == _GEOM.mjGEOM_CAPSULE) | (kinds == _GEOM.mjGEOM_CYLINDER)
    boxes = np.where(planes[:, None], [0, 0, 0, np.inf, np.inf, np.inf], model.geom_aabb.reshape(-1, 6))
    crates = (kinds == _GEOM.mjGEOM_BOX).astype(np.int64)
    return radii, np.where(long, sizes[:, 1], 0.0), np.where(long, sizes[:, 0], radii), boxes, crates


def pair_bounds(model: Any, joints: Joints, pairs: Indices) -> Array:
    """(P, K) longest way a point of one shape moves against the other while joint k moves by one.

    Joints that move both shapes move them as one and count nothing.
    """
    ways, moves = travel(model, joints), moves_of(model, joints)
    bodies = model.geom_bodyid[pairs]
    alone = moves[bodies[:, 0]] != moves[bodies[:, 1]]
    return np.where(alone, np.where(moves[bodies[:, 0]], ways[pairs[:, 0]], ways[pairs[:, 1]]), 0.0)


def travel(model: Any, joints: Joints) -> Array:
    """(n_shapes, K) longest way of any point of a shape, in any pose, while joint k moves by one; 0 if it does not.

    From joint to joint along the chain distances are the same in every pose but for what prismatic joints add: their
    sum, and the last joint's distance to the shape's farthest point, bound the lever arm.
    """
    data = mujoco.MjData(model)
    data.qpos[: len(joints.rest)] = joints.rest
    mujoco.mj_kinematics(model, data)
    out = np.zeros((model.ngeom, joints.dof))
    chains = _chains(model, joints)
    for g in range(model.ngeom):
        chain = chains[int(model.geom_bodyid[g])]
        corners, radius = _extent(model, data, g)
        for at, k in enumerate(chain):
            out[g, k] = _lever(data, joints, chain[at:], corners) + radius if not joints.slides[k] else 1.0
    return out


def _lever(data: Any, joints: Joints, chain: list[int], corners: Array) -> float:
    """Longest distance from the axis of the first joint of a chain to the farthest corner behind it."""
    numbers = joints.numbers[chain]
    anchors, axis = data.xanchor[numbers], data.xaxis[numbers[0]]
    tips = corners if len(chain) == 1 else anchors[1:2]
    arms = tips - anchors[0]
    reach = float(np.linalg.norm(arms - np.outer(arms @ axis, axis), axis=1).max())
    if len(chain) > 1:
        reach += float(np.linalg.norm(np.diff(anchors[1:], axis=0), axis=1).sum())
        reach += float(np.linalg.norm(corners - anchors[-1], axis=1).max())
    return reach + sum(_stroke(joints, k) for k in chain[1:] if joints.slides[k])


def _stroke(joints: Joints, k: int) -> float:
    """Farthest that a prismatic joint can be from where it is measured."""
    low, high = joints.limits.lower[k], joints.limits.upper[k]
    here = joints.rest[joints.addresses[k]]
    way = max(abs(low - here), abs(high - here))
    return float(way) if np.isfinite(way) else ENDLESS


def _chains(model: Any, joints: Joints) -> list[list[int]]:
    """Joints that move each body, from the root on."""
    column = {int(number): k for k, number in enumerate(joints.numbers)}
    chains: list[list[int]] = [[]]
    for body in range(1, model.nbody):
        first = int(model.body_jntadr[body])
        mine = [column[n] for n in range(first, first + int(model.body_jntnum[body])) if n in column]
        chains.append(chains[model.body_parentid[body]] + mine)
    return chains


def _extent(model: Any, data: Any, g: int) -> tuple[Array, float]:
    """Points in the world and a radius about them that together hold a shape."""
    kind, size = model.geom_type[g], model.geom_size[g]
    centre, axes = data.geom_xpos[g], data.geom_xmat[g].reshape(3, 3)
    if kind in (_GEOM.mjGEOM_CAPSULE, _GEOM.mjGEOM_CYLINDER):
        return centre + np.outer([-size[1], size[1]], axes[:, 2]), float(size[0])
    if kind == _GEOM.mjGEOM_BOX:
        signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        return centre + (signs * size) @ axes.T, 0.0
    if kind == _GEOM.mjGEOM_MESH:
        mesh = model.geom_dataid[g]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        return centre + model.mesh_vert[first : first + count].astype(float) @ axes.T, 0.0
    return centre[None], float(size.max() if kind == _GEOM.mjGEOM_ELLIPSOID else model.geom_rbound[g])
