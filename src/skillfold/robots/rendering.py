"""Pictures of a robot at work, drawn by MuJoCo without a window."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.errors import RobotError
from skillfold.robots.engine import mujoco
from skillfold.robots.falling import Falling
from skillfold.robots.merging import PREFIX
from skillfold.robots.world import World
from skillfold.tables import Array

WIDTH, HEIGHT = 640, 480  # pixels: MuJoCo's offscreen buffer
MOST = 20_000  # shapes in a picture
AZIMUTH, ELEVATION = 135.0, -18.0  # degrees
MOMENTS = 25  # of a motion, at which it is looked how much room it takes
BESIDE, FRONT = 1.0, 215.0  # m and degrees: whence snapshots are taken
Paint = Mapping[str, tuple[float, float, float]]
"""Red, green and blue of bodies and of obstacles, by name."""


@dataclass(frozen=True)
class View:
    """Where a picture is taken from.

    Attributes:
        toward: (3,) the point in its middle [m].
        distance: from there [m].
        azimuth, elevation: [degrees].
        size: width and height [pixels].
    """

    toward: tuple[float, float, float]
    distance: float
    azimuth: float = AZIMUTH
    elevation: float = ELEVATION
    size: tuple[int, int] = (WIDTH, HEIGHT)


@dataclass(frozen=True, eq=False)
class Mark:
    """Something drawn into a picture that is not in the world.

    Attributes:
        places: (n, 3) of a line, or of the middles of ellipsoids [m].
        color: (4,) red, green, blue, opacity.
        radius: of a line [m].
        shapes: (n, 3, 3) of ellipsoids: v'A⁻¹v ≤ 1 [m²]; None for a line.
    """

    places: Array
    color: tuple[float, float, float, float]
    radius: float = 0.002
    shapes: Array | None = None


def pictures(
    world: World,
    times: Array,
    states: Array,
    tumblers: Array,
    view: View | None = None,
    marks: Sequence[Sequence[Mark]] = (),
) -> Iterator[Any]:
    """A picture (height, width, 3), uint8, for each of the times (n,), states (n, D), tumblers' poses (n, k, 7).

    Args:
        world: with the robot.
        times, states, tumblers: of the pictures.
        view: where from; left out, from the side, far enough to see the whole motion.
        marks: of each picture, what is drawn besides.

    Raises:
        RobotError: no way to draw off the screen.
    """
    with _renderer(world.model, *(view.size if view else (WIDTH, HEIGHT))) as renderer:
        camera = _placed(view) if view else _camera(world, states)
        for index, (time, q, poses) in enumerate(zip(times, states, tumblers, strict=True)):
            world.show(float(time), q, poses)
            renderer.update_scene(world.data, camera)
            for mark in marks[index] if marks else ():
                _draw(renderer.scene, mark)
            yield renderer.render().copy()


def picture(world: World, q: Array, view: View, marks: Sequence[Mark] = ()) -> Any:
    """A picture (height, width, 3), uint8, of a world without tumblers at joint positions q (D,).

    Raises:
        RobotError: no way to draw off the screen.
    """
    with _renderer(world.model, *view.size) as renderer:
        world.show(0.0, q, np.empty((0, 7)))
        renderer.update_scene(world.data, _placed(view))
        for mark in marks:
            _draw(renderer.scene, mark)
        return renderer.render().copy()


def snapshots(
    floor: Falling, joints: Array, bases: Array, view: View | None = None, paint: Paint | None = None
) -> Iterator[Any]:
    """A picture of a robot with a free base at joint positions (n, dof), its base at poses (n, 7).

    Args:
        floor: with shapes that please the eye.
        joints, bases: as many as there will be pictures.
        view: of every picture; left out, from the robot's front, wherever it is.
        paint: colours of some bodies and obstacles.

    Raises:
        RobotError: no way to draw off the screen.
    """
    _paint(floor.model, paint or {})
    with _renderer(floor.model, *(view.size if view else (WIDTH, HEIGHT))) as renderer:
        for q, base in zip(joints, bases, strict=True):
            floor.show(q, base)
            from_front = View((base[0], base[1], 0.75 * base[2]), BESIDE, FRONT)
            renderer.update_scene(floor.data, _placed(view or from_front))
            yield renderer.render().copy()


def _paint(model: Any, paint: Paint) -> None:
    for i in range(model.ngeom):
        names = model.body(int(model.geom_bodyid[i])).name, model.geom(i).name.removeprefix(PREFIX)
        for name in names:
            if name in paint:
                model.geom_rgba[i, :3] = paint[name]


def _placed(view: View) -> Any:
    camera = mujoco.MjvCamera()
    camera.lookat[:], camera.distance = view.toward, view.distance
    camera.azimuth, camera.elevation = view.azimuth, view.elevation
    return camera


def _renderer(model: Any, width: int, height: int) -> Any:
    model.vis.global_.offwidth = max(model.vis.global_.offwidth, width)
    model.vis.global_.offheight = max(model.vis.global_.offheight, height)
    try:
        return mujoco.Renderer(model, height, width, max_geom=MOST)
    except Exception as error:  # each of its back ends fails in its own way where there is no driver
        raise RobotError(
            f"No pictures: MuJoCo cannot draw off the screen here ({error}). Set MUJOCO_GL to egl, osmesa or glfw."
        ) from None


def _draw(scene: Any, mark: Mark) -> None:
    color = np.array(mark.color, np.float32)
    if mark.shapes is not None:
        for place, shape in zip(mark.places, mark.shapes, strict=True):
            values, axes = np.linalg.eigh(shape)
            axes[:, 0] *= np.sign(np.linalg.det(axes))
            if (geom := _next(scene)) is not None:
                size = np.sqrt(np.maximum(values, 1e-12))
                mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_ELLIPSOID, size, place, axes.ravel(), color)
        return
    for start, end in itertools.pairwise(mark.places):
        if (geom := _next(scene)) is not None:
            mujoco.mjv_initGeom(
                geom, mujoco.mjtGeom.mjGEOM_CAPSULE, np.zeros(3), np.zeros(3), np.eye(3).ravel(), color
            )
            mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_CAPSULE, mark.radius, start, end)


def _next(scene: Any) -> Any:
    """A place for one more shape, None where there is none."""
    if scene.ngeom >= scene.maxgeom:
        return None
    scene.ngeom += 1
    return scene.geoms[scene.ngeom - 1]


def _camera(world: World, states: Array) -> Any:
    """From the side, far enough to see the whole motion of every part."""
    some = states[:: max(len(states) // MOMENTS, 1)]
    places = np.concatenate([world.robot.forward(some, frame)[:, :3] for frame in (None, *world.robot.frames)])
    low, high = np.minimum(places.min(0), 0.0), np.maximum(places.max(0), 0.0)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = 0.5 * (low + high)
    camera.distance = 1.75 * max(float(np.linalg.norm(high - low)), 0.5)
    camera.azimuth, camera.elevation = AZIMUTH, ELEVATION
    return camera
