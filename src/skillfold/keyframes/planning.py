"""Plans of keyframe skills, pair after pair (algorithm 1 of paper 002)."""

from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from skillfold.errors import InputError
from skillfold.keyframes.answers import not_begun, told
from skillfold.keyframes.asking import obstacles_of, read_alpha, read_limits, read_start, start_trouble
from skillfold.keyframes.constrained import plan_constrained as plan_constrained
from skillfold.keyframes.envelope import SoftEnvelope
from skillfold.keyframes.legs import Search
from skillfold.keyframes.pairs import Asked, Outcome, plan_pair
from skillfold.keyframes.printed import prepare_printed, search_printed
from skillfold.keyframes.rrtstar import prepare, search
from skillfold.motion import Plan
from skillfold.robots.robot import Robot

if TYPE_CHECKING:
    from skillfold.keyframes.skill import KeyframeSkill

Array = np.ndarray[Any, np.dtype[np.float64]]

ATTEMPTS = 4  # where a later pair fails: another end of the one before may lead on
ANOTHER = 7919  # added to the seed of each attempt

VARIANTS: dict[str, Search] = {"mended": search, "paper": search_printed}


def plan_skill(
    skill: "KeyframeSkill",
    robot: Robot,
    q_start: Any = None,
    scene: Any = None,
    alpha: float = 100.0,
    time_limit: float = 1.0,
    stop: str = "first",
    seed: int = 0,
    variant: str = "mended",
    *,
    start_at: int | None = None,
    until: int | None = None,
) -> Plan:
    """A path of a robot's joints through the envelopes of a skill to its last Gaussian, clear of obstacles.

    Where nothing is found, paths may come nearer to obstacles than the margin; then the gates are widened, ×2 and ×4
    in squared distance, and the plan tells; what cannot be is told at once: a start in collision, beyond joint limits
    or outside every gate, a goal out of reach or blocked.

    Args:
        skill: with ordered Gaussians.
        robot: whose tool moves; what it holds counts.
        q_start: joint positions (dof,); None is the robot's home.
        scene: a `Scene`, a list of shapes, or `robot.obstacles(...)` made before, which saves making them.
        alpha: percent of the variance that a reduced envelope keeps; 100 is the full envelope.
        time_limit: seconds.
        stop: "first" ends with the first path; "time" makes it shorter until the time is up.
        seed: same seed, same path, unless a try runs out of time (the first has .3 of it) or `stop` is "time".
        variant: "mended", or "paper" for algorithms 3 to 5 as printed, which neither keep paths inside nor widen
            gates: such plans seldom say success.
        start_at: the pair to start with; None tells it from the start's pose.
        until: the Gaussian to end at; None is the last.

    Returns:
        A plan by route "envelope", its states .01 rad apart. Of `stats`: nodes, iterations; first_solution [s], after
        the call; seconds, of all; gate_factor; costs, (seconds, length [rad]) of each better path; pair, the first;
        pairs, of each its number, which states of the path it starts at (`from`) and is inside the reduced envelope
        from (`entered`), gate_factor, nodes; entered, check and tree of the last, the tree as joint positions
        (n, dof) and parents (n,).

    Raises:
        InputError: says what was given and what was expected.
    """
    prepare()
    if variant == "paper":
        prepare_printed()
    begun = perf_counter()
    limit, alpha = read_limits(time_limit, stop, seed), read_alpha(alpha)
    if not isinstance(variant, str) or variant not in VARIANTS:
        raise InputError(f"variant={variant!r:.80}; possible: {', '.join(VARIANTS)}.")
    obstacles = obstacles_of(robot, scene)
    start = read_start(robot, robot.home if q_start is None else q_start)
    phase = skill.phase(robot.forward(start), start_at)
    last = _read_until(until, len(skill.gaussians))
    why = start_trouble(robot, obstacles, start)
    if why:
        return not_begun(robot, start[None], why, begun, "envelope")
    if phase.pair >= last:
        told_so = f"The start is {phase.told}; the end asked for is Gaussian {last}."
        return not_begun(robot, np.stack([start, start]), told_so, begun, "envelope", True)
    asked = Asked(robot, obstacles, alpha, stop == "first", begun, VARIANTS[variant], variant == "paper")
    envelopes = [skill.envelope(i) for i in range(phase.pair, last)]
    plan = told(robot, start, _plan_pairs(asked, envelopes, start, begun + limit, int(seed)), begun, phase.pair)
    if start_at is not None or phase.outside == 0.0 or phase.pair == 0:
        return plan
    # Nobody asked to leave out the pairs before it.
    return replace(plan, reason=f"{plan.reason} Pairs before {phase.pair} are left out: the start lies {phase.told}.")


def _plan_pairs(
    asked: Asked, envelopes: list[SoftEnvelope], start: Array, deadline: float, seed: int
) -> list[Outcome]:
    """What became of each pair, up to the first that failed; earlier ones are asked again for other ends."""
    outcomes: list[Outcome] = []
    for attempt in range(ATTEMPTS):
        while len(outcomes) < len(envelopes) and not (outcomes and outcomes[-1].reason):
            left = len(envelopes) - len(outcomes)
            here = outcomes[-1].states[-1] if outcomes else start
            until = deadline if asked.first else perf_counter() + (deadline - perf_counter()) / left
            envelope = envelopes[len(outcomes)]
            outcomes.append(plan_pair(asked, envelope, here, until, seed + ANOTHER * attempt, left == 1))
        hopeless = len(outcomes) == 1 or perf_counter() > deadline or attempt == ATTEMPTS - 1
        if not outcomes[-1].reason or hopeless:
            break
        del outcomes[-2:]
    return outcomes


def _read_until(until: Any, count: int) -> int:
    if until is None:
        return count - 1
    whole = isinstance(until, int | np.integer) and not isinstance(until, bool)
    if not (whole and 1 <= until < count):
        raise InputError(f"until={until!r:.80}; expected a Gaussian from 1 to {count - 1}.")
    return int(until)
