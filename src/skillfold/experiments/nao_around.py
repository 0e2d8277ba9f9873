"""Section VII-B of paper 000: steps of a Nao over a ball, or over the edge of a stair, that it was never shown.

A long step, and between the places of its foot an obstacle that the plain geodesic runs into. The foot is raised
where it stands, swings past obstacle and floor, and is lowered. The clearance asked for is a quarter of the usual
margin of obstacles: planners try to keep the margin, and must keep that much where both ends have twice as much.
Judged at fine steps by obstacles built anew: clear of ball or edge, of the floor, of the robot itself; and stable by
both judges, the obstacle standing in the dynamics too.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.experiments.nao_floor import FLOOR
from skillfold.experiments.nao_stability import Verdict, judge_motion
from skillfold.experiments.nao_steps import ASIDE, Skills, Stepper
from skillfold.experiments.oracle import finely
from skillfold.experiments.parallel import in_parallel
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array
from skillfold.robots.scene import Scene
from skillfold.robots.shapes import Box, Sphere
from skillfold.robots.standing import SIDES

RAISED = 0.02  # m: of the foot before it swings, and when it has
ASKED = 0.005  # m: clearance
FINE = 0.005  # rad between the states that are judged
LONG = (0.09, 0.10)  # m ahead of the stance foot and behind it
MIDDLE = 0.027  # m: of a sole from its ankle
BALL, EDGE = (0.012, 0.018), (0.010, 0.035)  # m: radii; heights
DEPTH, WIDTH = 0.01, 0.08  # m: of an edge, along the step and across
SHARE = 0.95


@dataclass(frozen=True)
class Case:
    """A step past an obstacle.

    Attributes:
        side: of the stance foot.
        obstacle: ball or edge.
        standing, raised: (2, 12) start and goal, on the floor and above it.
        blocked: (n, 12) the plain geodesic between the raised poses.
    """

    side: str
    obstacle: Any
    standing: Array
    raised: Array
    blocked: Array


@dataclass(frozen=True)
class Answer:
    """A plan and the truth about it.

    Attributes:
        case: what was asked.
        plan: of the swing.
        states: (n, 12) of the whole step.
        clearance: of the swing to obstacle, floor and itself, the smallest [m].
        whole: of the whole step to the obstacle and itself, the smallest [m].
        verdict: of the whole step.
        stumbling: of the whole step by the plain geodesic.
    """

    case: Case
    plan: Any
    states: Array
    clearance: float
    whole: float
    verdict: Verdict
    stumbling: Verdict

    @property
    def clear(self) -> bool:
        """Whether the plan says success and nothing is touched."""
        return self.plan.success and self.clearance > 0.0 and self.whole > 0.0

    @property
    def as_asked(self) -> bool:
        """Whether the swing keeps the clearance that was asked for, too."""
        return self.clear and self.clearance >= ASKED


def past(skills: dict[str, Skills], number: int, rng: np.random.Generator, settings: Settings) -> list[Answer]:
    """Steps past random obstacles, half of them balls, half edges; each draws for itself."""
    # As many of either foot meet each kind.
    drawn = [(SIDES[i % 2], i % 4 < 2, own) for i, own in enumerate(rng.spawn(number))]
    asked = [(skills[side], side, ball, own) for side, ball, own in drawn]
    return list(in_parallel(attempt, asked, settings.progress, "stepping: past obstacles", (0.6, 0.9)))


def attempt(skills: Skills, side: str, ball: bool, rng: np.random.Generator) -> Answer:
    """The first random step whose plain geodesic runs into a random obstacle, and the plan past it."""
    while True:
        case = _case(skills, side, ball, rng)
        if case is not None:
            return ask(skills, case)


def _case(skills: Skills, side: str, ball: bool, rng: np.random.Generator) -> Case | None:
    stepper, sign = Stepper(side), -1.0 if side == "left" else 1.0
    ahead = rng.uniform(*LONG, 2) * rng.permutation([1.0, -1.0])
    ends = np.stack([ahead, sign * rng.uniform(*ASIDE, 2)], axis=1)
    poses = [stepper.pose(stepper.optimiser.over_foot(np.append(end, z))) for z in (0.0, RAISED) for end in ends]
    if any(pose is None for pose in poses):
        return None
    standing, raised = np.array(poses).reshape(2, 2, -1)
    obstacle = _obstacle(ends.mean(0) + np.array([MIDDLE, 0.0]), ball, rng)
    robot = stepper.optimiser.robot
    there, both = robot.obstacles([obstacle]), robot.obstacles([obstacle, FLOOR])
    plain = skills.swing.plan(*raised).path.states
    fair = there.clearance(standing).min() > ASKED and both.clearance(raised).min() > 2 * ASKED
    if not fair or there.clearance(finely(plain, FINE)).min() > 0.0:
        return None
    return Case(side, obstacle, standing, raised, plain)


def _obstacle(middle: Array, ball: bool, rng: np.random.Generator) -> Any:
    """On the floor, between the places of the foot."""
    x, y = middle + rng.uniform(-1.0, 1.0, 2) * [0.005, 0.02]
    if ball:
        radius = rng.uniform(*BALL)
        return Sphere(center=(x, y, radius), radius=radius, name="ball")
    height = rng.uniform(*EDGE)
    return Box(pose=(x, middle[1], height / 2), size=(DEPTH, WIDTH, height), name="edge")


def ask(skills: Skills, case: Case) -> Answer:
    """A plan, and what is true of it."""
    stepper = Stepper(case.side)
    robot = stepper.optimiser.robot
    scene = Scene([case.obstacle, FLOOR])
    plan = skills.swing.plan(*case.raised, obstacles=robot.obstacles(scene))
    up = skills.swing.plan(case.standing[0], case.raised[0]).path.states
    down = skills.swing.plan(case.raised[1], case.standing[1]).path.states
    swing = finely(plan.path.states, FINE)
    states, plain = (np.concatenate([up[:-1], way, down[1:]]) for way in (plan.path.states, case.blocked))
    clearance = float(robot.obstacles(scene).clearance(swing).min())
    whole = float(robot.obstacles([case.obstacle]).clearance(finely(states, FINE)).min())
    verdicts = [judge_motion(stepper.optimiser, way, scene=[case.obstacle]) for way in (states, plain)]
    return Answer(case, plan, states, clearance, whole, *verdicts)


def rows(answers: list[Answer]) -> list[Row]:
    """Shares of steps that are clear, that keep the clearance, and that are stable."""
    clear = [answer for answer in answers if answer.clear]
    asked = sum(answer.as_asked for answer in answers)
    stable = sum(answer.verdict.stable for answer in clear)
    balls = sum(isinstance(answer.case.obstacle, Sphere) for answer in answers)
    total = max(len(answers), 1)
    said = sum(answer.plan.success for answer in answers)
    kept = np.array([answer.clearance for answer in clear] or [np.nan])
    fall = sum(not answer.stumbling.upright for answer in answers)
    note = (
        f"{len(clear)} of {total}, {balls} of them past balls; {said} say success; the plain geodesic hits in all, "
        f"and in dynamics falls in {fall}"
    )
    return [
        Row("Nao's steps past a ball or an edge: clear", len(clear) / total, "share", SHARE, ">=", "", note),
        Row(
            f"Nao's steps past a ball or an edge: swing clear by the {ASKED:g} m that were asked",
            asked / total,
            "share",
            SHARE,
            ">=",
            "",
            f"{asked} of {total}; clear ones by {kept.min():.4f} m at least, median {np.median(kept):.4f} m",
        ),
        Row(
            "Nao's steps past a ball or an edge: clear ones stable by both judges",
            stable / max(len(clear), 1),
            "share",
            SHARE,
            ">=",
            "",
            f"{stable} of {len(clear)}",
        ),
    ]
