"""Balance of section VII-C by one who knows the floor: states led out of it, geodesics planned around it.

Neither the demonstrations nor the projection know of a floor. The skill is learnt down to it: a projected foot may
end a few millimetres below, and a geodesic may dip through it. The library is told of it as of any other obstacle,
and of the robot's own parts and limits besides. A state that is not clear is moved along the manifold, up the
clearance's gradient, until it is; plans are asked with the same obstacles.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.experiments.nao_poses import Optimiser
from skillfold.experiments.nao_stability import Verdict, judge_motion
from skillfold.motion import Array
from skillfold.robots.shapes import Box

FLOOR = Box(pose=(0.0, 0.0, -0.02), size=(1.0, 1.0, 0.04), name="floor")
CLEAR = 0.005  # m: servos that give way by a twentieth of a radian let a foot a decimetre aside down as far
BEYOND = 0.001  # m: aimed at besides, since gradients bend
STEP, STEPS = 0.05, 100  # rad at a time, and how often at most


@dataclass(frozen=True)
class Known:
    """A projection led out of the floor and of the robot itself, and the way to it.

    Attributes:
        pose: (12,).
        plan: from the one before.
        clear: whether the pose keeps the clearance.
        verdicts: of pose and plan, on flat ground.
    """

    pose: Array
    plan: Any
    clear: bool
    verdicts: tuple[Verdict, Verdict]


def around(optimiser: Optimiser) -> Any:
    """What a pose must keep clear of: the floor, the robot itself, its limits."""
    return optimiser.robot.obstacles([FLOOR], limits=True)


def led_out(skill: Any, obstacles: Any, q: Array) -> Array:
    """The state (12,) that q (12,) is led to; the last one where none is clear in so many steps."""
    for _ in range(STEPS):
        missing = CLEAR - obstacles.clearance(q)
        if missing <= 0.0:
            break
        tangent = skill.tangent(q)
        uphill = tangent @ (tangent.T @ obstacles.clearance_gradient(q))
        move = uphill * (missing + BEYOND) / max(float(uphill @ uphill), 1e-9)
        q = skill.project(q + move * min(1.0, STEP / max(float(np.linalg.norm(move)), 1e-12)), near=q)
    return q


def known(optimiser: Optimiser, skill: Any, start: Array, pose: Array) -> Known:
    """Plan from one state to the next, both led out, and judge."""
    obstacles = around(optimiser)
    plan = skill.plan(start, pose, obstacles=obstacles)
    verdicts = judge_motion(optimiser, pose[None]), judge_motion(optimiser, plan.path.states)
    return Known(pose, plan, bool(obstacles.clearance(pose) >= CLEAR), verdicts)
