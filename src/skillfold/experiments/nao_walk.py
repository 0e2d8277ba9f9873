"""Section VII-A3 of paper 000, figure 21: a walk of random steps, planned one by one, played in dynamics.

Each step starts where the one before has ended, seen from the foot that now stands. Nothing is fed back: the servos
are led along the joint positions, and the robot stays up or it does not.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from skillfold.errors import SkillfoldError
from skillfold.experiments.nao_stability import LEANING, lasting
from skillfold.experiments.nao_steps import Skills, Step, Stepper, draw, other_side
from skillfold.experiments.rows import Row
from skillfold.motion import Array
from skillfold.robots.falling import Falling
from skillfold.robots.robot import Robot
from skillfold.robots.standing import base_of

TRIES = 200  # of a random step, until one is within reach
SETTLE = 2.0  # s after the last step


@dataclass(frozen=True)
class Walk:
    """What was walked.

    Attributes:
        steps: one after another, each in the frame of its own stance foot.
        feet: (steps + 1, 2) where each stance foot was meant to stand in the world [m].
        plans: of swing and shift of each step.
        whole: (n, 24) joint positions of the whole walk.
        bases: (m, 7) of the torso, every hundredth of a second of the dynamics.
        leaning: at most, and at the end [rad].
        height: of the torso, the least against the first.
        expected: (3,) where the torso was meant to end.
    """

    steps: list[Step]
    feet: Array
    plans: list[tuple[Any, Any]]
    whole: Array
    bases: Array
    leaning: tuple[float, float]
    height: float
    expected: Array

    @property
    def up(self) -> bool:
        """Whether it never fell."""
        return self.leaning[0] < LEANING and self.height > 0.8


def walk(skills: dict[str, Skills], number: int, rng: np.random.Generator) -> Walk:
    """Plan and play so many random steps, from standing on the left foot with the right foot beside it."""
    steps, plans, feet, pieces = [], [], [np.zeros(2)], []
    side, beside = "left", np.array([0.0, -0.1])
    pose = None
    for _ in range(number):
        stepper = Stepper(side)
        step, swing, shift = planned(skills[side], stepper, pose, beside, rng)
        steps.append(step)
        plans.append((swing, shift))
        feet.append(feet[-1] + step.goal)
        pieces += [(stepper, swing.path.states), (stepper, shift.path.states)]
        pose = stepper.onward(shift.path.states[-1])
        side, beside = other_side(side), -step.goal
    return played(steps, np.array(feet), plans, pieces)


def planned(
    skills: Skills, stepper: Stepper, pose: Array | None, start: Array, rng: np.random.Generator
) -> tuple[Step, Any, Any]:
    """A random step within reach from a pose (12,), or from the optimal one: swing and weight shift."""
    for _ in range(TRIES):
        step = draw(stepper.side, rng, start)
        asks = [stepper.swinging(step, 0.0), stepper.swinging(step, 0.5), stepper.swinging(step, 1.0)]
        first, apex, landed = (stepper.pose(asked) for asked in asks)
        shifted = stepper.pose(stepper.shifting(step, 1.0))
        if first is None or apex is None or landed is None or shifted is None:
            continue
        swing = skills.swing.plan(first if pose is None else pose, landed, via=apex[None])
        return step, swing, skills.shift.plan(swing.path.states[-1], shifted)
    raise SkillfoldError(
        f"No step from {start} m was within reach in {TRIES} tries; expected feet nearer each other."
    )


def row(found: Walk) -> Row:
    """Whether it stays up."""
    drift = float(np.linalg.norm(found.bases[-1, :2] - found.expected[:2]))
    said = sum(plan.success for pair in found.plans for plan in pair)
    note = (
        f"{len(found.steps)} steps; leans {found.leaning[0]:.3f} rad at most, {found.leaning[1]:.3f} at the end; "
        f"torso {1e3 * drift:.0f} mm from where it was meant to be; {said} of {2 * len(found.plans)} say success"
    )
    return Row("Nao's walk of random steps: stays up in dynamics", float(found.up), "", 1.0, ">=", "stable", note)


def played(steps: list[Step], feet: Array, plans: list[tuple[Any, Any]], pieces: list[tuple[Stepper, Array]]) -> Walk:
    """Pieces of joint positions with their stance, played one after another, and the rest told."""
    nao, floor = robot(), Falling(robot())
    stepper, states = pieces[0]
    floor.reset(*placed(stepper, states[0], feet[0]))
    seen, whole = [floor.base[None]], []
    for stepper, states in pieces:
        joints = stepper.optimiser.robot.whole(states)
        whole.append(joints)
        seen.append(floor.follow(joints, lasting(states)))
    seen.append(floor.follow(whole[-1][-1:], SETTLE))
    bases = np.concatenate(seen)
    stepper, states = pieces[-1]
    expected = base_of(nao, whole[-1][-1], stepper.optimiser.robot.stance, np.append(feet[-2], 0.0))
    leans = leaning(bases)
    height = float((bases[:, 2] / bases[0, 2]).min())
    return Walk(
        steps, feet, plans, np.concatenate(whole), bases, (float(leans.max()), float(leans[-1])), height, expected[:3]
    )


def placed(stepper: Stepper, q: Array, foot: Array) -> tuple[Array, Array]:
    """Joints (24,) and base (7,) of a pose (12,) whose stance foot stands at a place (2,) of the world."""
    whole = stepper.optimiser.robot.whole(q)
    return whole, base_of(robot(), whole, stepper.optimiser.robot.stance, np.append(foot, 0.0))


def leaning(bases: Array) -> Array:
    """Angles (n,) of the torso from upright."""
    x, y = bases[:, 4], bases[:, 5]
    return np.arccos(np.clip(1.0 - 2.0 * (x**2 + y**2), -1.0, 1.0))


@cache
def robot() -> Robot:
    """The whole Nao."""
    return Robot.load("nao")
