"""What a controller is set to: gains, limits, and whether skill, plan and robot go together."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from skillfold.errors import InputError
from skillfold.manifold.inputs import amount
from skillfold.motion import Array, Plan

RATE = 12.0  # 1/s, fastest change of the reference's rate
SLIGHT = 1e-3  # rad or m that a path may leave the limits by: so little is not missed
UNKNOWN = 1e4  # velocity that none has whose limits are unknown


class Gains(NamedTuple):
    """How hard the controller holds (section IV-D); pushes along the manifold are harmless, off it they cost.

    Attributes:
        along: ω² [1/s²] toward the reference along the manifold.
        along_damping: ζ of that.
        off: ω² [1/s²] toward the manifold, on it.
        off_damping: ζ of that.
        stiffening: times `off` that it grows to with the distance from the manifold.
        reach: distance at which it has; None is a tenth of the demonstrations' radius.
        hold: ω [1/s] toward the last good state where there are no samples to go by.
    """

    along: float = 100.0
    along_damping: float = 4.0
    off: float = 1600.0
    off_damping: float = 1.0
    stiffening: float = 2.0
    reach: float | None = None
    hold: float = 10.0

    def numbers(self, scale: float) -> Array:
        """(7,) as the compiled law takes them; `scale` is the radius of the demonstrations."""
        values = [*self[:5], 0.1 * scale if self.reach is None else self.reach, self.hold]
        if not all(isinstance(value, int | float | np.number) and 0 < value < np.inf for value in values):
            raise InputError(f"{self}; expected positive numbers.")
        values[1] = 2.0 * self.along_damping * np.sqrt(self.along)
        return np.array(values, np.float64)


@dataclass(frozen=True)
class Bounds:
    """What a controller keeps, each (D,), infinite where there is no limit.

    Attributes:
        lower, upper: of positions.
        velocity, acceleration: of the reference, and of what it is held with.
        torque: of the robot.
    """

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    torque: Array

    @classmethod
    def of(cls, skill: Any, robot: Any) -> "Bounds":
        """What skill and robot, or None, allow both."""
        infinite = np.full(skill.n_dims, np.inf)
        lower, upper = np.array(skill.space.lower), np.array(skill.space.upper)
        if robot is None:
            return cls(lower, upper, infinite, infinite, infinite)
        ends = robot.limits
        return cls(
            np.maximum(lower, ends.lower),
            np.minimum(upper, ends.upper),
            robot.velocity_limits,
            robot.acceleration_limits,
            robot.torque_limits,
        )

    def slower(self, pace: float) -> "Bounds":
        """The same for motions at that share of the speed."""
        return replace(self, velocity=pace * self.velocity, acceleration=pace**2 * self.acceleration)

    def left(self, states: Array) -> str:
        """Where a path (n, D) leaves the limits of positions, in words; nothing where it does not."""
        beyond = np.maximum(self.lower - states, states - self.upper)
        i, c = (int(k) for k in np.unravel_index(np.argmax(beyond), beyond.shape))
        if beyond[i, c] <= SLIGHT:
            return ""
        ends = f"{self.lower[c]:.4g} to {self.upper[c]:.4g}"
        return f"State {i} of the path has coordinate {c} at {states[i, c]:.4g}, outside the limits {ends}."

    @property
    def brake(self) -> float:
        """How fast the rate of a reference may change [1/s]: braking at full speed keeps the limits."""
        known = np.isfinite(self.velocity) & np.isfinite(self.acceleration)
        quickest = self.acceleration[known] / self.velocity[known]
        return min(RATE, 0.8 * float(np.e * quickest.min())) if known.any() else RATE

    @property
    def fastest(self) -> float:
        """Velocity that no robot with such limits has."""
        finite = self.velocity[np.isfinite(self.velocity)]
        return 20.0 * float(finite.max()) if finite.size else UNKNOWN


def turning(skill: Any, robot: Any) -> Array:
    """(D,) 1 for joints of which full turns change nothing."""
    kinds = (skill if robot is None else robot).space.kinds
    return np.array([float(kind == "continuous") for kind in kinds])


def thresholds(skill: Any, deviation: Any, off: Any) -> tuple[float, float]:
    """Distances along the manifold and off it that call for a new plan; where they are left out, see the controller.

    Raises:
        InputError: they are no distances.
    """
    scale = skill.model.scale
    return (
        0.15 * scale if deviation is None else amount("deviation", deviation, np.inf, zero=True),
        max(0.05 * scale, 3.0 * skill.tolerance) if off is None else amount("off", off, np.inf, zero=True),
    )


def check_obstacles(obstacles: Any) -> None:
    """Whether a controller can look out for them.

    Raises:
        InputError: it cannot.
    """
    if not (obstacles is None or hasattr(obstacles, "compiled")):
        raise InputError(f"obstacles: {type(obstacles).__name__}; expected robot.obstacles(scene), or None.")


def check(skill: Any, plan: Plan, robot: Any, gains: Any, planner: Any, load: Any) -> None:
    """Whether they go together.

    Raises:
        InputError: they do not.
    """
    if not hasattr(skill, "model"):
        raise InputError(f"skill: {type(skill).__name__}; expected a SkillManifold.")
    if not isinstance(plan, Plan):
        raise InputError(f"plan: {type(plan).__name__}; expected a Plan, as skill.plan(...) makes one.")
    if not (robot is None or hasattr(robot, "dynamics")):
        raise InputError(f"robot: {type(robot).__name__}; expected a Robot, or None.")
    if not (gains is None or isinstance(gains, Gains)):
        raise InputError(f"gains: {type(gains).__name__}; expected Gains(...), or None.")
    if not (planner is None or callable(planner)):
        raise InputError(f"planner: {type(planner).__name__}; expected a function of start, goal and obstacles.")
    if not (isinstance(load, tuple | list) and 1 <= len(load) <= 2):
        raise InputError(f"load: {load!r:.40}; expected a mass [kg] and its centre (3,) [m], as tray.load.")
    if not plan.success:
        raise InputError(f"The plan was made without success: {plan.reason}")
    if not len(plan.path):
        raise InputError("plan without states; expected one at least.")
    if plan.path.states.shape[1] != skill.n_dims:
        raise InputError(f"plan of {plan.path.states.shape[1]} coordinates; the skill has {skill.n_dims}.")
    if "quaternion" in skill.space.kinds:
        raise InputError("The skill has quaternions; expected coordinates that subtract, such as joint positions.")
    if robot is not None and robot.dof != skill.n_dims:
        raise InputError(f"{robot.name} has {robot.dof} joints; the skill has {skill.n_dims} coordinates.")
    left = Bounds.of(skill, robot).left(plan.path.states)
    if left:
        raise InputError(
            f"{left} Fit the skill with space=robot.space, or plan with obstacles=robot.obstacles(scene): "
            "both keep the robot's limits."
        )
