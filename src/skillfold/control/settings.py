"""What a controller is set to: gains, limits, and whether skill, plan and robot go together."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from skillfold.errors import InputError
from skillfold.motion import Array, Plan

RATE = 12.0  # 1/s, fastest change of the reference's rate
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
        if not all(np.isfinite(value) and value > 0 for value in values):
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


def check(skill: Any, plan: Plan, robot: Any) -> None:
    """Whether they go together.

    Raises:
        InputError: they do not.
    """
    if not plan.success:
        raise InputError(f"The plan was made without success: {plan.reason}")
    if plan.path.states.shape[1] != skill.n_dims:
        raise InputError(f"plan of {plan.path.states.shape[1]} coordinates; the skill has {skill.n_dims}.")
    if "quaternion" in skill.space.kinds:
        raise InputError("The skill has quaternions; expected coordinates that subtract, such as joint positions.")
    if robot is not None and robot.dof != skill.n_dims:
        raise InputError(f"{robot.name} has {robot.dof} joints; the skill has {skill.n_dims} coordinates.")
