"""What the compiled distance loops are given: laid out once for robot and scene, then filled in for each thread."""

import threading
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from skillfold.robots import distances as dist
from skillfold.robots import shape_distances as near
from skillfold.robots.bounds import pair_bounds, shape_bounds, travel
from skillfold.robots.clusters import clustered, spheres
from skillfold.robots.engine import mujoco
from skillfold.robots.joints import Joints, Limits, pose_slots
from skillfold.robots.merging import Merged, merge
from skillfold.robots.pairs import moving, scene_pairs, self_pairs
from skillfold.robots.poses import place_points
from skillfold.robots.scene import Scene
from skillfold.robots.shapes import PointCloud
from skillfold.tables import Array, Indices, Table, table_of

if TYPE_CHECKING:
    from skillfold.robots.robot import Robot


@dataclass(frozen=True)
class Layout:
    """A robot and a scene, laid out for the loops; the same for every place of the movable obstacles.

    Attributes:
        merged: their model.
        joints: of the robot.
        pairs, bounds: (P, 2) and (P, K) as in `Clearance`.
        radii, spines, girths, boxes, crates: of each shape, as in `distances`.
        moving: shapes of the robot that points are compared with.
        moving_bounds: (G, K) of those.
        clouds: order and first points of the clusters of each point cloud, by name.
        local: each thread's `MjData`; making one takes time.
    """

    merged: Merged
    joints: Joints
    pairs: Indices
    bounds: Array
    radii: Array
    spines: Array
    girths: Array
    boxes: Array
    crates: Indices
    moving: Indices
    moving_bounds: Array
    clouds: dict[str, tuple[Indices, Indices]]
    local: threading.local = field(default_factory=threading.local)

    def data(self) -> Any:
        """This thread's `MjData`; all that is read from it is written before, in every call."""
        found = getattr(self.local, "data", None)
        if found is None:
            found = self.local.data = mujoco.MjData(self.merged.model)
        return found


def layout_of(robot: "Robot", scene: Scene, movable: Collection[str], self_collision: bool) -> Layout:
    """Lay out a robot in a scene."""
    joints = robot.joints
    merged = merge(robot.lean_spec(), scene, movable, joints, robot.source)
    model = merged.model
    clouds = {shape.name: clustered(shape.points) for shape in scene if isinstance(shape, PointCloud)}
    solid = [number for name, number in merged.shapes.items() if name not in clouds]
    parts = [scene_pairs(merged, joints, solid)]
    if self_collision:
        parts.append(self_pairs(merged, joints))
    pairs = np.concatenate(parts)
    shapes = np.array(moving(merged, joints), np.int64)
    return Layout(
        merged,
        joints,
        pairs,
        pair_bounds(model, joints, pairs),
        *shape_bounds(model),
        shapes,
        travel(model, joints)[shapes],
        clouds,
    )


def table_for(
    layout: Layout, scene: Scene, standing: Mapping[str, Array], limits: Limits | None, base: Array | None
) -> Table:
    """Table of a robot among obstacles, for this thread.

    Args:
        layout: of robot and scene.
        scene: its shapes.
        standing: pose (7,) of each obstacle.
        limits: joint limits that count as obstacles.
        base: (7,) pose of a floating base.
    """
    model, data = layout.merged.model, layout.data()
    poses = model.body_pos[model.body_mocapid >= 0], model.body_quat[model.body_mocapid >= 0]
    for name, row in layout.merged.mocaps.items():
        poses[0][row], poses[1][row] = standing[name][:3], standing[name][3:]
    infinite = np.full(layout.joints.dof, np.inf)
    lower, upper = limits or (-infinite, infinite)
    slots = pose_slots(model, data, layout.joints, base) | {
        dist.PAIRS: layout.pairs,
        dist.BOUNDS: layout.bounds,
        near.RADII: layout.radii,
        near.CENTRES: data.geom_xpos,
        near.AXES: data.geom_xmat,
        near.SPINES: layout.spines,
        near.GIRTHS: layout.girths,
        near.BOXES: layout.boxes,
        near.CRATES: layout.crates,
        dist.BODIES: model.geom_bodyid,
        dist.MOCAP_POS: data.mocap_pos,
        dist.MOCAP_QUAT: data.mocap_quat,
        dist.STANDING_POS: poses[0],
        dist.STANDING_QUAT: poses[1],
        dist.LOWER: lower,
        dist.UPPER: upper,
        dist.GAPS: np.zeros(len(layout.pairs)),
        dist.WINNER: np.zeros(2, np.int64),
        dist.SEGMENT: np.zeros(6),
        near.TRIAL: np.zeros(6),
    }
    return table_of(slots | _points(layout, scene, standing), dist.SLOTS, model, data)


def _points(layout: Layout, scene: Scene, standing: Mapping[str, Array]) -> dict[int, Any]:
    """All point clouds of a scene as one, by slot."""
    if not layout.clouds:
        return {}
    points, starts, proxies, reaches, centres = [], [np.zeros(1, np.int64)], [], [], []
    for name, (order, first) in layout.clouds.items():
        shape: Any = scene[name]
        points.append(place_points(standing[name], np.asarray(shape.points)[order]))
        middle, radii = spheres(points[-1], first)
        starts.append(starts[-1][-1] + first[1:])
        centres.append(middle)
        reaches.append(radii + shape.radius)
        proxies.append(np.full(len(middle), layout.merged.shapes[name], np.int64))
    return {
        dist.CLUSTERS: np.concatenate(centres),
        dist.REACHES: np.concatenate(reaches),
        dist.STARTS: np.concatenate(starts),
        dist.PROXIES: np.concatenate(proxies),
        dist.POINTS: np.concatenate(points),
        dist.FEELERS: layout.moving,
        dist.FEELER_BOUNDS: layout.moving_bounds,
    }
