"""Pictures of a robot at work, drawn by MuJoCo without a window."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from skillfold.errors import RobotError
from skillfold.robots.engine import mujoco
from skillfold.robots.world import World
from skillfold.tables import Array

WIDTH, HEIGHT = 640, 480  # pixels: MuJoCo's offscreen buffer
AZIMUTH, ELEVATION = 135.0, -18.0  # degrees


def pictures(world: World, times: Array, states: Array, tumblers: Array) -> Iterator[Any]:
    """A picture (height, width, 3), uint8, for each of the times (n,), states (n, D), tumblers' poses (n, k, 7).

    Raises:
        RobotError: no way to draw off the screen.
    """
    try:
        renderer = mujoco.Renderer(world.model, HEIGHT, WIDTH)
    except Exception as error:  # each of its back ends fails in its own way where there is no driver
        raise RobotError(
            f"No pictures: MuJoCo cannot draw off the screen here ({error}). Set MUJOCO_GL to egl, osmesa or glfw."
        ) from None
    with renderer:
        camera = _camera(world, states)
        for time, q, poses in zip(times, states, tumblers, strict=True):
            world.show(float(time), q, poses)
            renderer.update_scene(world.data, camera)
            yield renderer.render().copy()


def _camera(world: World, states: Array) -> Any:
    """From the side, far enough to see the whole motion of the tool."""
    tools = world.robot.forward(states)[:, :3]
    low, high = np.minimum(tools.min(0), 0.0), np.maximum(tools.max(0), 0.0)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = 0.5 * (low + high)
    camera.distance = 1.6 * max(float(np.linalg.norm(high - low)), 0.5)
    camera.azimuth, camera.elevation = AZIMUTH, ELEVATION
    return camera
