"""A robot and a scene as one MuJoCo model; what moves is a mocap body, points have one proxy sphere per cloud."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.robots.engine import mujoco
from skillfold.robots.joints import Joints, robot_bodies
from skillfold.robots.loading import compiled
from skillfold.robots.poses import HERE
from skillfold.robots.scene import Scene
from skillfold.robots.shapes import Box, Capsule, Cylinder, Mesh, PointCloud, Shape, Sphere

PREFIX = "scene: "  # before the names of obstacles, which may be those of the robot's shapes
MEMORY = 1 << 21  # bytes of MuJoCo's stack: distances need little, and its usual megabytes take time to get


@dataclass(frozen=True)
class Merged:
    """One model of robot and scene.

    Attributes:
        model: MuJoCo's.
        shapes: MuJoCo's number of each obstacle's shape, by name; of its proxy for a point cloud.
        mocaps: place of each movable obstacle among the mocap bodies, by name.
        own: (n,) MuJoCo's numbers of the robot's shapes.
    """

    model: Any
    shapes: dict[str, int]
    mocaps: dict[str, int]
    own: np.ndarray[Any, np.dtype[np.int64]]


def merge(spec: Any, scene: Scene, movable: Collection[str], joints: Joints, source: str) -> Merged:
    """Robot and scene in one model; obstacles stand where they are at rest."""
    spec = spec.copy()
    spec.memory = MEMORY
    for shape in scene:
        add_shape(spec, shape, shape.name in movable)
    model = compiled(spec, source)
    shapes = {shape.name: model.geom(PREFIX + shape.name).id for shape in scene}
    mocaps = {
        shape.name: int(model.body_mocapid[model.body(PREFIX + shape.name).id])
        for shape in scene
        if shape.name in movable and not isinstance(shape, PointCloud)
    }
    mine = robot_bodies(model, joints)
    others = set(shapes.values())
    own = [g for g in range(model.ngeom) if g not in others and mine[model.geom_bodyid[g]] and _collides(model, g)]
    return Merged(model, shapes, mocaps, np.array(own, np.int64))


def _collides(model: Any, geom: int) -> bool:
    kinds = (mujoco.mjtGeom.mjGEOM_HFIELD, mujoco.mjtGeom.mjGEOM_SDF)  # MuJoCo tells no distance to these
    masks = model.geom_contype[geom] | model.geom_conaffinity[geom]
    return bool(masks) and model.geom_type[geom] not in kinds


def add_shape(spec: Any, shape: Shape, moves: bool) -> None:
    """Add an obstacle to a specification, on a body of its own where it moves."""
    pose, body = shape.placed, spec.worldbody
    if isinstance(shape, PointCloud):  # the proxy is put where it is needed
        pose = np.array(HERE)
    elif moves:
        body = spec.worldbody.add_body(name=PREFIX + shape.name, mocap=True, pos=pose[:3], quat=pose[3:])
        pose = np.array(HERE)
    write_shape(spec, body, shape, PREFIX + shape.name, pose, contype=1, conaffinity=1)


def write_shape(spec: Any, body: Any, shape: Shape, name: str, pose: Any, **look: Any) -> None:
    """Add a shape to a body, at a pose (7,) in it; `look` is what else MuJoCo's geom shall have."""
    geom = body.add_geom(name=name, pos=pose[:3], quat=pose[3:], **look)
    _WRITERS[type(shape)](spec, geom, shape)


def _box(_: Any, geom: Any, shape: Any) -> None:
    geom.type, geom.size = mujoco.mjtGeom.mjGEOM_BOX, [edge / 2 for edge in shape.size]


def _sphere(_: Any, geom: Any, shape: Any) -> None:
    geom.type, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, [shape.radius, 0, 0]


def _cylinder(_: Any, geom: Any, shape: Any) -> None:
    geom.type, geom.size = mujoco.mjtGeom.mjGEOM_CYLINDER, [shape.radius, shape.length / 2, 0]


def _capsule(_: Any, geom: Any, shape: Any) -> None:
    geom.type, geom.size = mujoco.mjtGeom.mjGEOM_CAPSULE, [shape.radius, shape.length / 2, 0]


def _mesh(spec: Any, geom: Any, shape: Any) -> None:
    mesh = spec.add_mesh(name=PREFIX + shape.name)
    mesh.uservert = np.asarray(shape.vertices).ravel()
    # The hull's volume whatever the order of its faces; thin ones would be refused otherwise.
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, mesh.name


_WRITERS: dict[type[Shape], Callable[[Any, Any, Any], None]] = {
    Box: _box,
    Sphere: _sphere,
    PointCloud: _sphere,
    Cylinder: _cylinder,
    Capsule: _capsule,
    Mesh: _mesh,
}
