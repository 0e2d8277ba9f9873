"""Section III of paper 002: pick and drop past a cracker box, pick and place past a coffee can, with the Jaco.

The arm stands on a short edge of the table, its base at the origin the table's top at z = 0; the hand points down.
In task 1 it reaches out, in task 2 across. Seven demonstrations of two keyframes are drawn from Gaussians that stand
here, and no learner sees: first where the hand sets out, then where it ends. The scene while demonstrating has what
the task is about; afterwards something stands in the straight way.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from skillfold.motion import Array
from skillfold.robots.obstacles import Obstacles
from skillfold.robots.poses import multiply
from skillfold.robots.reaching import reach
from skillfold.robots.robot import Robot
from skillfold.robots.scene import Scene
from skillfold.robots.shapes import Box, Cylinder, Shape, Sphere

DEMONSTRATIONS = 7
DOWN = np.array([0.0, 1.0, 0.0, 0.0])  # the tool's z axis toward the table
TRIES = 1000  # of a pose that can be reached
TABLE = Box((0.53, 0.0, -0.365), (1.22, 0.61, 0.73), name="table")
GLASS = Cylinder((0.60, 0.0, 0.0685), 0.0445, 0.137, name="wine glass")
CRACKERS = Box((0.42, 0.0, 0.1067), (0.0718, 0.164, 0.2134), name="cracker box")
CAN = Cylinder((0.40, 0.0, 0.0701), 0.0512, 0.1402, name="coffee can")
CHERRY = Sphere((0.0, 0.0, 0.008), 0.01, name="cherry")
PARCEL = Box((0.0, 0.0, 0.025), (0.04, 0.04, 0.07), name="parcel")


@dataclass(frozen=True, eq=False)
class Spread:
    """How people vary a keyframe: a Gaussian of positions, and one of rotation vectors about the mean.

    Attributes:
        place: (3,) mean position [m].
        metres: (3,) standard deviations along x, y and z.
        radians: (3,) about the axes of the hand.
    """

    place: tuple[float, float, float]
    metres: tuple[float, float, float]
    radians: tuple[float, float, float] = (0.10, 0.10, 0.15)

    def draw(self, count: int, rng: np.random.Generator) -> Array:
        """Poses (count, 7)."""
        from scipy.spatial.transform import Rotation

        places = np.array(self.place) + self.metres * rng.standard_normal((count, 3))
        turned = Rotation.from_rotvec(self.radians * rng.standard_normal((count, 3))).as_quat(scalar_first=True)
        return np.concatenate([places, multiply(np.broadcast_to(DOWN, (count, 4)), turned)], axis=1)


@dataclass(frozen=True, eq=False)
class Task:
    """What is to be done, and what comes in the way.

    Attributes:
        name: of the task.
        keyframes: how its poses vary, in order.
        shown: what stands around while it is demonstrated.
        obstacle: what stands in the way afterwards.
        held: what the hand holds.
    """

    name: str
    keyframes: tuple[Spread, Spread]
    shown: tuple[Shape, ...]
    obstacle: Shape
    held: Shape

    @cached_property
    def robot(self) -> Robot:
        """The arm, holding what it brings."""
        return Robot.load("jaco").holding(self.held, mass=0.02)

    @cached_property
    def scene(self) -> Scene:
        """All that stands around when it is planned."""
        return Scene([*self.shown, self.obstacle])

    @cached_property
    def clear(self) -> tuple[Obstacles, Obstacles]:
        """What must be kept clear of while demonstrating, and while planning."""
        return self.robot.obstacles(self.shown), self.robot.obstacles(self.scene)

    def demonstrations(self, seed: Any, count: int = DEMONSTRATIONS) -> Array:
        """Keyframes (count, 2, 7) that the arm could be led to among what is shown."""
        rng = np.random.default_rng(seed)
        poses = [[self._reached(spread, self.clear[0], rng)[0] for spread in self.keyframes] for _ in range(count)]
        return np.array(poses)

    def start(self, seed: Any, inside: Any = None) -> Array:
        """Joint positions (dof,) from which to plan: the tool where someone might set out, the arm clear of all.

        Args:
            seed: of the pose.
            inside: a pose (7,) → whether it may be the start's, such as a learnt gate.
        """
        return self._reached(self.keyframes[0], self.clear[1], np.random.default_rng(seed), inside)[1]

    def _reached(self, spread: Spread, obstacles: Obstacles, rng: Any, inside: Any = None) -> tuple[Array, Array]:
        """A pose and joint positions that lead there."""
        for _ in range(TRIES):
            pose = spread.draw(1, rng)[0]
            if inside is None or inside(pose):
                postures = reach(self.robot, pose, obstacles, int(rng.integers(2**31)))
                if len(postures):
                    return pose, postures[0]
        raise RuntimeError(f"{self.name}: none of {TRIES} poses can be reached.")


@lru_cache(1)
def tasks() -> tuple[Task, Task]:
    """Task 1, whose first Gaussian varies sideways and the second upward; task 2, whose varies less markedly."""
    turned = (0.08, 0.08, 0.12)
    aside, upward = (0.012, 0.050, 0.012), (0.012, 0.012, 0.045)
    drop = Task(
        "pick and drop",
        (Spread((0.27, 0.0, 0.10), aside, turned), Spread((0.60, 0.0, 0.26), upward, turned)),
        (TABLE, GLASS),
        CRACKERS,
        CHERRY,
    )
    place = Task(
        "pick and place",
        (Spread((0.40, -0.24, 0.13), (0.030, 0.020, 0.018)), Spread((0.40, 0.24, 0.12), (0.022, 0.025, 0.015))),
        (TABLE,),
        CAN,
        PARCEL,
    )
    return drop, place
