"""Section VII of paper 000: poses of a Nao on one leg, optimised one by one.

A pose is the twelve leg joints of `robots.standing`, whose stance sole is fixed to the ground; one motor drives both
hip yaw-pitch joints, so eleven are free. The cost is a sum of squares as in Equation 22: swing foot where it is asked
to be, flat and straight, pelvis over the support polygon, waist upright, joints away from their limits. These leave
the pelvis' height open; a weak pull toward the robot's home pose, where the paper's optimiser starts, settles it.
SciPy's trust-region-reflective solver, as in the paper, with analytic derivatives; limits are hard bounds besides.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from skillfold.motion import Array
from skillfold.robots.standing import Standing, standing
from skillfold.tables import Indices

# What counts as one unit of cost: a centimetre, a twentieth of a radian; the pull home is to move neither.
LENGTH, ANGLE = 0.01, 0.05
POSTURE = 0.05  # per rad from home
NEAR = 0.02  # rad from a limit within which a joint costs
# Corners of the sole, x and y [m] from the ankle: the left force sensors; the right ones mirror them to .6 mm.
SOLE = np.array([[0.07025, 0.0299], [0.07025, -0.0231], [-0.02965, -0.0191], [-0.03025, 0.0299]])
CENTRE = np.array([0.02, 0.0044])  # m from the ankle: the middle of those corners
REACHED = 0.1  # cost above which a goal counts as out of reach: three millimetres, or the pull home from six rad


@dataclass(frozen=True)
class Asked:
    """One query of the optimiser.

    Attributes:
        foot: (3,) of the swing sole, below its ankle [m].
        pelvis: (2,) over which point of the ground [m].
    """

    foot: Array
    pelvis: Array


@dataclass(frozen=True)
class Found:
    """What it answered: pose (12,), final cost, evaluations of the cost, those for finite differences among them."""

    pose: Array
    cost: float
    evaluations: int

    @property
    def reached(self) -> bool:
        """Whether the final cost is one that a reachable goal has; the paper discards others."""
        return self.cost < REACHED


@dataclass(frozen=True)
class Optimiser:
    """Optimal poses on the `left` or `right` foot."""

    side: str

    @cached_property
    def robot(self) -> Standing:
        """The robot that stands."""
        return standing(self.side)

    @property
    def mirror(self) -> float:
        """Sign of y for this stance: the constants above are for the left foot."""
        return 1.0 if self.side == "left" else -1.0

    @property
    def centre(self) -> Array:
        """(2,) middle of the support polygon."""
        return CENTRE * [1.0, self.mirror]

    @property
    def polygon(self) -> Array:
        """(4, 2) corners of the support polygon."""
        return SOLE * [1.0, self.mirror]

    @cached_property
    def free(self) -> Indices:
        """Places of the eleven joints that follow none."""
        return np.array([k for k, name in enumerate(self.robot.names) if name not in self.robot.couplings])

    def over_foot(self, foot: Array) -> Asked:
        """The swing foot somewhere, the pelvis over the stance foot."""
        return Asked(np.asarray(foot, float), self.centre)

    def optimise(self, asked: Asked, first: Array | None = None, analytic: bool = True) -> Found:
        """The optimal pose, from `first` (12,) or from home; with finite differences where not analytic."""
        lower, upper = (side[self.free] for side in self.robot.limits)
        start = np.clip(self.robot.home if first is None else first, *self.robot.limits)[self.free]
        jac: Any = (lambda z: self.derivative(self._whole(z))) if analytic else "2-point"
        evaluated = 0

        def cost(z: Array) -> Array:
            nonlocal evaluated
            evaluated += 1
            return self.residuals(self._whole(z), asked)

        result = least_squares(cost, start, jac=jac, bounds=(lower, upper), method="trf")
        return Found(self._whole(result.x), 2.0 * float(result.cost), evaluated)

    def residuals(self, q: Array, asked: Asked) -> Array:
        """(31,) of a pose (12,); their squares add up to the cost."""
        foot, pelvis = self.robot.forward(q, self.robot.swing), self.robot.forward(q, "Torso")
        x, y, _ = axes(foot[3:])
        upright = axes(pelvis[3:])[2]
        task = [
            (foot[:3] - asked.foot) / LENGTH,
            np.array([x[1], x[2], y[2]]) / ANGLE,
            (pelvis[:2] - asked.pelvis) / LENGTH,
            upright[:2] / ANGLE,
        ]
        z = q[self.free]
        return np.concatenate([*task, self._crowding(z)[0], POSTURE * (z - self.robot.home[self.free])])

    def derivative(self, q: Array) -> Array:
        """(31, 11) of the residuals by the free joints."""
        foot, pelvis = self.robot.forward(q, self.robot.swing), self.robot.forward(q, "Torso")
        by_foot = self.robot.jacobian(q, self.robot.swing)[:, self.free]
        by_pelvis = self.robot.jacobian(q, "Torso")[:, self.free]
        x, y, _ = axes(foot[3:])
        # An axis a that turns with ω changes by ω × a.
        dx, dy = (np.cross(by_foot[3:], a, axisa=0, axisc=0) for a in (x, y))
        dz = np.cross(by_pelvis[3:], axes(pelvis[3:])[2], axisa=0, axisc=0)
        task = [by_foot[:3] / LENGTH, np.stack([dx[1], dx[2], dy[2]]) / ANGLE, by_pelvis[:2] / LENGTH, dz[:2] / ANGLE]
        crowding = np.diag(self._crowding(q[self.free])[1])
        return np.concatenate([*task, crowding, POSTURE * np.eye(len(self.free))])

    def _crowding(self, z: Array) -> tuple[Array, Array]:
        """How far each free joint is into the last stretch before a limit, and its derivative."""
        lower, upper = (side[self.free] for side in self.robot.limits)
        over, under = np.maximum(z - upper + NEAR, 0.0), np.maximum(lower + NEAR - z, 0.0)
        return (over - under) / ANGLE, ((over > 0).astype(float) + (under > 0)) / ANGLE

    def _whole(self, z: Array) -> Array:
        q = np.zeros(self.robot.dof)
        q[self.free] = z
        return self.robot.couple(q)


def axes(quaternion: Array) -> Array:
    """(3, 3) x, y and z axes of a frame turned by a unit quaternion, a row each."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
            [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
            [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
