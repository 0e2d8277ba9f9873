"""Pictures of a robot at work, drawn by MuJoCo without a window."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from skillfold.errors import RobotError
from skillfold.robots.engine import mujoco
from skillfold.robots.falling import Falling
from skillfold.robots.world import World
from skillfold.tables import Array

WIDTH, HEIGHT = 640, 480  # pixels: MuJoCo's offscreen buffer
AZIMUTH, ELEVATION = 135.0, -18.0  # degrees
BESIDE, FRONT = 1.0, 215.0  # m and degrees: whence snapshots are taken


def pictures(world: World, times: Array, states: Array, tumblers: Array) -> Iterator[Any]:
    """A picture (height, width, 3), uint8, for each of the times (n,), states (n, D), tumblers' poses (n, k, 7).

    Raises:
        RobotError: no way to draw off the screen.
    """
    with _renderer(world.model) as renderer:
        camera = _camera(world, states)
        for time, q, poses in zip(times, states, tumblers, strict=True):
            world.show(float(time), q, poses)
            renderer.update_scene(world.data, camera)
            yield renderer.render().copy()


def snapshots(floor: Falling, joints: Array, bases: Array) -> Iterator[Any]:
    """A picture of a robot with a free base at joint positions (n, dof), its base at poses (n, 7), from its front.

    Raises:
        RobotError: no way to draw off the screen.
    """
    with _renderer(floor.model) as renderer:
        for q, base in zip(joints, bases, strict=True):
            floor.show(q, base)
            camera = mujoco.MjvCamera()
            camera.lookat[:] = [base[0], base[1], 0.75 * base[2]]
            camera.distance, camera.azimuth, camera.elevation = BESIDE, FRONT, ELEVATION
            renderer.update_scene(floor.data, camera)
            yield renderer.render().copy()


def _renderer(model: Any) -> Any:
    try:
        return mujoco.Renderer(model, HEIGHT, WIDTH)
    except Exception as error:  # each of its back ends fails in its own way where there is no driver
        raise RobotError(
            f"No pictures: MuJoCo cannot draw off the screen here ({error}). Set MUJOCO_GL to egl, osmesa or glfw."
        ) from None


def _camera(world: World, states: Array) -> Any:
    """From the side, far enough to see the whole motion of the tool."""
    tools = world.robot.forward(states)[:, :3]
    low, high = np.minimum(tools.min(0), 0.0), np.maximum(tools.max(0), 0.0)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = 0.5 * (low + high)
    camera.distance = 1.6 * max(float(np.linalg.norm(high - low)), 0.5)
    camera.azimuth, camera.elevation = AZIMUTH, ELEVATION
    return camera
