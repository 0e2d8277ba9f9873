"""Show a robot a skill a few times; plan new motions that hold it; come back to it when pushed.

Everything loads on first use, so that `import skillfold` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from skillfold.demonstrations import Demonstration as Demonstration
    from skillfold.demonstrations import Demonstrations as Demonstrations
    from skillfold.errors import SkillfoldError as SkillfoldError
    from skillfold.manifold.skill import SkillManifold as SkillManifold
    from skillfold.motion import Path as Path
    from skillfold.motion import Plan as Plan
    from skillfold.motion import Trajectory as Trajectory
    from skillfold.spaces import StateSpace as StateSpace

__version__ = "0.1.0"

_HOME = {
    "Demonstration": "skillfold.demonstrations",
    "Demonstrations": "skillfold.demonstrations",
    "Path": "skillfold.motion",
    "Plan": "skillfold.motion",
    "SkillManifold": "skillfold.manifold.skill",
    "SkillfoldError": "skillfold.errors",
    "StateSpace": "skillfold.spaces",
    "Trajectory": "skillfold.motion",
}

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'skillfold' has no attribute '{name}'; it has {', '.join(_HOME)}.")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
