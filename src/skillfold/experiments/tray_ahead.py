"""`python -m skillfold.experiments.tray_ahead FILE` compiles what the demo's tray needs, with a small skill's file.

Here control comes first and planning last. The demo takes them the other way round, so that where it overtakes, each
is compiled by one of the two.
"""

import sys
from typing import Any

import numpy as np

from skillfold.control.pushes import Push
from skillfold.control.simulate import simulate
from skillfold.experiments import tray
from skillfold.experiments.tray_demo import NAIVE, planned, skill_of
from skillfold.experiments.tumbler_runs import TRAY, Trial, controller

SAMPLES = 60
BRIEF = 0.01  # seconds that are simulated


def small_skill() -> Any:
    """A skill that serves for nothing else."""
    return skill_of(np.random.default_rng(0), SAMPLES, dim=3, kernels=5, ridge=1e-5)


def control(skill: Any) -> None:
    """A reactive controller and the naive one for an instant each."""
    start, goal = skill.sample(2, 0)
    trial = Trial(start, goal, 5.0, Push(0.0, "link7", (1.0, 0.0, 0.0), BRIEF))
    plan = skill.plan(start, goal, route="geodesic")
    if plan.success:
        obstacles = tray.arm().obstacles()
        simulate(tray.arm(), controller("skill", skill, trial, obstacles, plan), tray=TRAY, duration=BRIEF)
    simulate(tray.arm(), controller(NAIVE, skill, trial), tray=TRAY, duration=BRIEF)


def planning(skill: Any) -> None:
    """Paths around boxes; whatever comes of it."""
    planned(skill)


if __name__ == "__main__":
    from skillfold.manifold.skill import SkillManifold

    small = SkillManifold.load(sys.argv[1])
    control(small)
    planning(small)
