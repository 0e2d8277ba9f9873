"""Section VII-A of paper 000: steps of a Nao, optimised pose by pose, and the skills learnt from them.

A step is taken in the frame of its stance foot: first the other foot swings, along a straight line and as high as a
sinusoid, with the pelvis over the stance foot; then, both feet down, the pelvis moves over the foot that has landed.
Feet point ahead. Ten poses to a phase, each optimised from home, as in the paper.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from skillfold.experiments.nao_poses import Asked, Optimiser
from skillfold.experiments.parallel import in_parallel
from skillfold.experiments.rows import Settings
from skillfold.motion import Array
from skillfold.robots.standing import SIDES
from skillfold.spaces import StateSpace

POINTS = 10  # poses of a phase
AHEAD = (-0.10, 0.10)  # m: where the swing foot stands, before and after, along x
ASIDE = (0.08, 0.10)  # m from the stance ankle, sideways; farther out a foot that is high meets its ankle's limit
APEX = (0.02, 0.06)  # m


@dataclass(frozen=True)
class Step:
    """Where the swing foot goes.

    Attributes:
        side: of the stance foot.
        start, goal: (2,) of the swing ankle from the stance ankle [m].
        apex: how high it swings [m].
    """

    side: str
    start: Array
    goal: Array
    apex: float

    def foot(self, share: float) -> Array:
        """(3,) of the swing sole at a share of the swing."""
        return np.append(self.start + share * (self.goal - self.start), self.apex * np.sin(np.pi * share))


@dataclass(frozen=True)
class Example:
    """An optimised step: swing (10, 12) and weight shift (10, 12)."""

    step: Step
    swing: Array
    shift: Array


@dataclass(frozen=True)
class Stepper:
    """Optimised poses of steps on one foot."""

    side: str

    @cached_property
    def optimiser(self) -> Optimiser:
        """Of this stance."""
        return Optimiser(self.side)

    def swinging(self, step: Step, share: float) -> Asked:
        """What a share of the swing asks for."""
        return self.optimiser.over_foot(step.foot(share))

    def shifting(self, step: Step, share: float) -> Asked:
        """What a share of the weight shift asks for."""
        landed = step.goal + self.optimiser.centre * [1.0, -1.0]
        centre = self.optimiser.centre
        return Asked(np.append(step.goal, 0.0), centre + share * (landed - centre))

    def pose(self, asked: Asked, analytic: bool = True) -> Array | None:
        """The optimal pose (12,); None where it is out of reach."""
        found = self.optimiser.optimise(asked, analytic=analytic)
        return found.pose if found.reached else None

    def example(self, step: Step, points: int = POINTS, analytic: bool = True) -> Example | None:
        """The whole step, optimised, with finite differences where not analytic; None where any is out of reach."""
        shares = np.linspace(0.0, 1.0, points)
        phases = []
        for asks in (self.swinging, self.shifting):
            poses = []
            for share in shares:
                pose = self.pose(asks(step, float(share)), analytic)
                if pose is None:
                    return None
                poses.append(pose)
            phases.append(np.array(poses))
        return Example(step, *phases)

    def errors(self, states: Array, asked: Callable[[Array], Asked], number: int) -> Array:
        """RMS over the joints between some states of a path (n, 12) and the optimal poses that they ask for [rad]."""
        some = states[np.linspace(0, len(states) - 1, number).astype(int)]
        best = np.array([self.optimiser.optimise(asked(q)).pose for q in some])
        return np.sqrt(np.mean((some - best) ** 2, axis=1))

    def soles(self, step: Step) -> Array:
        """(m, 2) corners of the support polygon of both soles once the swing foot has landed."""
        stance = self.optimiser.polygon
        corners = np.concatenate([stance, step.goal + stance * [1.0, -1.0]])
        return corners[ConvexHull(corners).vertices]

    def onward(self, q: Array) -> Array:
        """The same pose (..., 12) with the other foot as its stance."""
        other = Optimiser(other_side(self.side)).robot
        return other.legs(self.optimiser.robot.whole(q))


@dataclass(frozen=True)
class Skills:
    """What is learnt for one stance: swing and weight shift, from as many steps."""

    swing: Any
    shift: Any
    examples: list[Example]


def other_side(side: str) -> str:
    """Of the other foot."""
    return SIDES[1 - SIDES.index(side)]


def draw(side: str, rng: np.random.Generator, start: Array | None = None) -> Step:
    """A random step, from a given start or a random one."""
    sign = -1.0 if side == "left" else 1.0
    places = [np.array([rng.uniform(*AHEAD), sign * rng.uniform(*ASIDE)]) for _ in range(2)]
    return Step(side, places[0] if start is None else start, places[1], float(rng.uniform(*APEX)))


def examples(side: str, number: int, rng: np.random.Generator) -> list[Example]:
    """Random steps, optimised, over all cores; those out of reach are drawn again."""
    stepper = Stepper(side)
    found: list[Example] = []
    while len(found) < number:
        steps = [(draw(side, rng),) for _ in range(number - len(found))]
        found += [example for example in in_parallel(stepper.example, steps) if example is not None]
    return found


def learn(settings: Settings, shown: list[Example]) -> Skills:
    """A skill for each phase, of poses without order: new steps are geodesics."""
    space = stance_space(shown[0].step.side)
    swing, shift = (np.concatenate([getattr(example, phase) for example in shown]) for phase in ("swing", "shift"))
    return Skills(settings.learn(swing, space=space), settings.learn(shift, space=space), shown)


def stance_space(side: str) -> StateSpace:
    """Leg joints with their limits, which plans keep."""
    return Optimiser(side).robot.space


def same_pace(path: Array, poses: Array) -> Array:
    """Differences (m, 12) between poses (m, 12) and a path (n, 12) at the same shares of their ways."""
    shares = []
    for states in (path, poses):
        way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(states, axis=0), axis=1)))
        shares.append(way / way[-1])
    return np.stack([np.interp(shares[1], shares[0], column) for column in path.T], axis=1) - poses
