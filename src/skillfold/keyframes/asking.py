"""What users ask planners, read and checked."""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from skillfold.errors import InputError
from skillfold.robots.obstacles import Obstacles
from skillfold.robots.robot import Robot
from skillfold.robots.scene import Scene

Array = np.ndarray[Any, np.dtype[np.float64]]

STOPS = ("first", "time")
LONGEST = 3600.0  # seconds
SEEDS = 2**32 - 1

# Another question in the same scene is asked soon: to make a model of robot and scene takes as long as to plan.
_lately: "WeakKeyDictionary[Robot, Obstacles]" = WeakKeyDictionary()


def obstacles_of(robot: Any, scene: Any) -> Obstacles:
    """The robot's obstacles in a scene; a scene seen last, or obstacles made by the user, are taken as they are.

    Raises:
        InputError: no robot, or obstacles of another one.
        SceneError: no scene.
    """
    if not isinstance(robot, Robot):
        raise InputError(f"robot: {type(robot).__name__}; expected a Robot, as Robot.load('jaco') makes one.")
    if isinstance(scene, Obstacles):
        if scene.robot is not robot:
            raise InputError(f"scene: obstacles of another robot ({scene.robot.name}); expected those of this one.")
        return scene
    lately = _lately.get(robot)
    if lately is not None and lately.scene is scene:
        return lately
    obstacles = robot.obstacles(scene)
    if isinstance(scene, Scene):
        _lately[robot] = obstacles
    return obstacles


def read_start(robot: Robot, q: Any, what: str = "q_start") -> Array:
    """One vector of joint positions (dof,), followers where their leaders put them."""
    array = robot.couple(q)
    if array.ndim != 1:
        raise InputError(f"{what}: shape {array.shape}; expected one vector of joint positions ({robot.dof},).")
    return array


def start_trouble(robot: Robot, obstacles: Obstacles, q: Array, what: str = "start") -> str:
    """Why no path can begin or end at joint positions (dof,), in words; empty where one may."""
    lower, upper = robot.limits
    beyond = np.maximum(q - upper, lower - q)
    worst = int(beyond.argmax())
    if beyond[worst] > 0.0:
        return f"The {what} breaks the limits of {robot.names[worst]} by {beyond[worst]:.3g}."
    clearance = float(obstacles.clearance(q))
    if not clearance > 0.0:
        return f"The {what} is in collision: {obstacles.nearest(q)}, {clearance:.3g} m."
    return ""


def read_alpha(alpha: Any) -> float:
    """Percent of the variance."""
    number = isinstance(alpha, int | float | np.integer | np.floating) and not isinstance(alpha, bool)
    if not (number and 1.0 <= alpha <= 100.0):  # less than one percent is hardly meant
        raise InputError(f"alpha={alpha!r:.80}; expected percent, from 1 to 100: 85 is 85 % of the variance.")
    return float(alpha)


def read_limits(time_limit: Any, stop: Any, seed: Any) -> float:
    """The time limit [s], once all three are looked at."""
    number = isinstance(time_limit, int | float | np.integer | np.floating) and not isinstance(time_limit, bool)
    if not (number and 0.0 < time_limit <= LONGEST):
        raise InputError(f"time_limit={time_limit!r:.80}; expected seconds, above zero and {LONGEST:g} at most.")
    if not isinstance(stop, str) or stop not in STOPS:
        raise InputError(f"stop={stop!r:.80}; possible: {', '.join(STOPS)}.")
    whole = isinstance(seed, int | np.integer) and not isinstance(seed, bool)
    if not (whole and 0 <= seed <= SEEDS):
        raise InputError(f"seed={seed!r:.80}; expected a whole number from 0 to {SEEDS}.")
    return float(time_limit)
