"""Show a robot a skill a few times; plan new motions that hold it; come back to it when pushed.

Everything loads on first use, so that `import skillfold` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from skillfold.control.pushes import Push as Push
    from skillfold.control.reactive import ReactiveController as ReactiveController
    from skillfold.control.rollout import Rollout as Rollout
    from skillfold.control.settings import Gains as Gains
    from skillfold.control.simulate import simulate as simulate
    from skillfold.demonstrations import Demonstration as Demonstration
    from skillfold.demonstrations import Demonstrations as Demonstrations
    from skillfold.errors import SkillfoldError as SkillfoldError
    from skillfold.keyframes.constrained import plan_constrained as plan_constrained
    from skillfold.keyframes.envelope import SoftEnvelope as SoftEnvelope
    from skillfold.keyframes.gaussians import PoseGaussian as PoseGaussian
    from skillfold.keyframes.hand_written import AxisUpright as AxisUpright
    from skillfold.keyframes.hand_written import PlaneConstraint as PlaneConstraint
    from skillfold.keyframes.hand_written import TaskSpaceRegion as TaskSpaceRegion
    from skillfold.keyframes.skill import KeyframeSkill as KeyframeSkill
    from skillfold.manifold.skill import SkillManifold as SkillManifold
    from skillfold.motion import Path as Path
    from skillfold.motion import Plan as Plan
    from skillfold.motion import Trajectory as Trajectory
    from skillfold.planning.point_obstacles import PointObstacles as PointObstacles
    from skillfold.robots.robot import Robot as Robot
    from skillfold.robots.scene import Scene as Scene
    from skillfold.robots.shapes import Box as Box
    from skillfold.robots.shapes import Capsule as Capsule
    from skillfold.robots.shapes import Cylinder as Cylinder
    from skillfold.robots.shapes import Mesh as Mesh
    from skillfold.robots.shapes import Motion as Motion
    from skillfold.robots.shapes import PointCloud as PointCloud
    from skillfold.robots.shapes import Sphere as Sphere
    from skillfold.robots.tray import Tray as Tray
    from skillfold.spaces import StateSpace as StateSpace
    from skillfold.viewing.plan_pictures import draw_plan as draw_plan

__version__ = "0.1.0"

_HOME = {
    "AxisUpright": "skillfold.keyframes.hand_written",
    "Box": "skillfold.robots.shapes",
    "Capsule": "skillfold.robots.shapes",
    "Cylinder": "skillfold.robots.shapes",
    "Demonstration": "skillfold.demonstrations",
    "Demonstrations": "skillfold.demonstrations",
    "Gains": "skillfold.control.settings",
    "KeyframeSkill": "skillfold.keyframes.skill",
    "Mesh": "skillfold.robots.shapes",
    "Motion": "skillfold.robots.shapes",
    "Path": "skillfold.motion",
    "Plan": "skillfold.motion",
    "PlaneConstraint": "skillfold.keyframes.hand_written",
    "PointCloud": "skillfold.robots.shapes",
    "PointObstacles": "skillfold.planning.point_obstacles",
    "PoseGaussian": "skillfold.keyframes.gaussians",
    "Push": "skillfold.control.pushes",
    "ReactiveController": "skillfold.control.reactive",
    "Robot": "skillfold.robots.robot",
    "Rollout": "skillfold.control.rollout",
    "Scene": "skillfold.robots.scene",
    "SkillManifold": "skillfold.manifold.skill",
    "SkillfoldError": "skillfold.errors",
    "SoftEnvelope": "skillfold.keyframes.envelope",
    "Sphere": "skillfold.robots.shapes",
    "StateSpace": "skillfold.spaces",
    "TaskSpaceRegion": "skillfold.keyframes.hand_written",
    "Trajectory": "skillfold.motion",
    "Tray": "skillfold.robots.tray",
    "draw_plan": "skillfold.viewing.plan_pictures",
    "plan_constrained": "skillfold.keyframes.constrained",
    "simulate": "skillfold.control.simulate",
}

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'skillfold' has no attribute '{name}'; it has {', '.join(_HOME)}.")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
