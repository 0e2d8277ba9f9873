"""OMPL's planners against ours in the same envelopes: the same starts and scenes, one after the other."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skillfold.errors import MissingExtraError
from skillfold.experiments.keyframe_judge import judge
from skillfold.experiments.keyframe_ompl import SPACES, EnvelopePeer, PeerPath
from skillfold.experiments.keyframe_runs import Answer, Learnt, ask
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array
from skillfold.robots.reaching import reach
from skillfold.robots.world import World

SECONDS = 3.0  # that OMPL may take
FASTER = 10.0  # that ours must be
GOALS = 10  # poses of the child's gate whose postures OMPL is given


@dataclass(frozen=True)
class Race:
    """Our answer, and OMPL's path with how many of its states are outside or in touch."""

    ours: Answer
    theirs: PeerPath
    wrong: int


def rows(skills: Sequence[Learnt], starts: int, settings: Settings) -> list[Row]:
    """Each of OMPL's ways beside ours; without figures where OMPL is not installed."""
    found: list[Row] = []
    for number, space in enumerate(SPACES):
        settings.progress("keyframes: OMPL", 0.85 + 0.07 * number)
        try:
            races = [race(learnt, seed, space, settings) for learnt in skills for seed in range(starts)]
        except MissingExtraError as error:
            found += [Row(name, None, unit, target, ">=", "", str(error)) for name, unit, target in _names(space)]
            continue
        found += compare(races, space)
    return found


def race(learnt: Learnt, seed: int, space: str, settings: Settings, seconds: float = SECONDS) -> Race:
    """Ours first; OMPL's functions are compiled, and its goals found, before its clock starts."""
    task = learnt.task
    start = learnt.start([settings.seed, 9, learnt.draw, seed])
    ours = ask(learnt, start, 100.0, seed)
    peer = EnvelopePeer(task.robot, task.clear[1], learnt.envelope, start, _goals(learnt), space)
    peer.distance(start)
    peer.valid(start)
    theirs = peer.plan(seed + 1, seconds)
    wrong = 0
    if theirs.solved:
        seen = judge(task.robot, World(task.robot, task.scene), learnt.envelope, theirs.states)
        wrong = seen.outside + seen.touching
    return Race(ours, theirs, wrong)


def compare(races: Sequence[Race], space: str) -> list[Row]:
    """Median times, a failure counting as the time it took, and shares solved."""
    (faster, unit, target), (solved, share, _) = _names(space)
    ours = np.array([race.ours.seconds for race in races])
    theirs = np.array([race.theirs.seconds for race in races])
    mine, other = 1e3 * np.median(ours), 1e3 * np.median(theirs)
    done = [race for race in races if race.theirs.solved]
    wrong = sum(bool(race.wrong) for race in done)
    note = f"{other:.3g} over {mine:.3g} ms, {len(races)} cases; OMPL stopped after {SECONDS:g} s, its goals given"
    success = float(np.mean([race.ours.solved for race in races]))
    said = f"of OMPL's {len(done)} paths {wrong} leave the envelope or touch something at every 0.005 rad"
    return [
        Row(faster, float(other / mine), unit, target, ">=", "", note),
        Row(solved, success, share, len(done) / len(races), ">=", "", said),
    ]


def _names(space: str) -> tuple[tuple[str, str, float | None], tuple[str, str, float | None]]:
    what = {"rejection": "poses outside rejected", "projected": "its projected space"}[space]
    return (
        (f"OMPL's RRTConnect, {what}: its first path over our whole plan, median", "×", FASTER),
        (f"cases solved, the share of OMPL's ({what}) as target", "share", None),
    )


def _goals(learnt: Learnt) -> Array:
    poses = learnt.envelope.child.sample(GOALS, 0)
    return np.concatenate([reach(learnt.task.robot, pose, learnt.task.clear[1], i) for i, pose in enumerate(poses)])
