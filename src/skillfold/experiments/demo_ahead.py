"""`python -m skillfold.experiments.demo_ahead` compiles what the demo needs of what no skill has to be learnt for.

With a saved skill as its argument it compiles how the tray finds its way. Compiled loops do not know how many joints
there are, so that skill may be one of the three-link arm.
"""

import sys
from typing import Any

from skillfold.control.reactive import ReactiveController
from skillfold.control.simulate import simulate
from skillfold.control.tracking import JointTracker
from skillfold.experiments.tumbler_runs import NAIVE
from skillfold.manifold.ahead import project_onto_a_line
from skillfold.manifold.sampled import sampled_path, smoothed
from skillfold.manifold.terrain import Terrain
from skillfold.robots.robot import Robot
from skillfold.robots.shapes import Box

BRIEF = 0.01  # seconds that are simulated


def unlearnt() -> None:
    """Distances from obstacles, of which ways are made, and projection."""
    _surroundings()[1].compiled()
    project_onto_a_line()


def ways(skill: Any) -> None:
    """Smoothing, then what needs projection, which another process may be compiling yet; whatever comes of it."""
    _, obstacles = _surroundings()
    model = skill.model
    ends = model.path(model.centre, model.centre, model.anchors[:2])
    terrain = Terrain.between(model, skill.space, obstacles, ends, 0.5 * obstacles.margin)
    straight, spacing = terrain.coordinates(ends), obstacles.resolution / model.scale
    smoothed(terrain, straight, spacing)
    sampled_path(terrain, straight, spacing, 0)


def carried(skill: Any) -> None:
    """A reactive arm and a naive one for an instant each."""
    robot, obstacles = _surroundings()
    plan = skill.plan(*skill.sample(2, 0))
    if plan.success:
        made = ReactiveController(skill, plan, robot=robot, obstacles=obstacles)
        simulate(robot, made, duration=BRIEF)
        simulate(robot, JointTracker(made.reference, robot, *NAIVE["naive"]), duration=BRIEF)
        robot.jacobian(robot.home)
        obstacles.nearest(robot.home)


def _surroundings() -> tuple[Robot, Any]:
    """A robot with three joints, and a box that is in nobody's way."""
    robot = Robot.load("planar_arm")
    return robot, robot.obstacles([Box(pose=[0.0, 0.0, 2.0], size=[0.1, 0.1, 0.1], name="box")])


if __name__ == "__main__":
    from skillfold.manifold.skill import SkillManifold

    if len(sys.argv) > 1:
        ways(SkillManifold.load(sys.argv[1]))
    else:
        unlearnt()
