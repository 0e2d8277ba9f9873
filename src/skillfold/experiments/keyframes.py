"""Keyframe skills (paper 002): what is learnt from seven demonstrations, and every claim about the plans from it."""

from dataclasses import dataclass

from skillfold.experiments import (
    keyframe_learning,
    keyframe_motions,
    keyframe_moving,
    keyframe_narrow,
    keyframe_peers,
    keyframe_runs,
)
from skillfold.experiments.keyframe_runs import Learnt
from skillfold.experiments.keyframe_tasks import tasks
from skillfold.experiments.rows import Row, Settings


@dataclass(frozen=True)
class Counts:
    """How many: draws of demonstrations of each task, and of what is asked of each.

    Attributes:
        draws: of demonstrations.
        seeds: starts of each draw, at both α.
        bits: skills that are asked twice.
        cost_draws, cost_seeds: of plans that go on for seconds.
        turned_draws, turned_seeds: of the direction of paths.
        narrow_draws, walls: of narrow scenes.
        episodes: with a moving box.
        peer_draws, peer_starts: that OMPL is asked too.
        late: seconds that plans go on for.
    """

    draws: int = 6
    seeds: int = 42
    bits: int = 4
    cost_draws: int = 2
    cost_seeds: int = 2
    turned_draws: int = 60
    turned_seeds: int = 6
    narrow_draws: int = 3
    walls: int = 10
    episodes: int = 20
    peer_draws: int = 3
    peer_starts: int = 2
    late: float = keyframe_motions.LATE


def measure(settings: Settings, counts: Counts | None = None) -> list[Row]:
    """All rows of what is planned."""
    counts = counts or Counts()
    skills = learn(settings, counts.draws)
    answers = keyframe_runs.answers(skills, counts.seeds, settings)
    rows = [
        *keyframe_runs.first_rows(answers),
        *keyframe_runs.inside_rows(answers),
        keyframe_runs.bits_row(_few(skills, (counts.bits + 1) // 2), settings),
        *keyframe_motions.cost_rows(_few(skills, counts.cost_draws), counts.cost_seeds, settings, counts.late),
        *keyframe_motions.turned_rows(learn(settings, counts.turned_draws), counts.turned_seeds, settings),
        *keyframe_narrow.rows(_few(skills, counts.narrow_draws), counts.walls, settings),
        *keyframe_moving.rows(skills, counts.episodes, settings),
    ]
    return rows + keyframe_peers.rows(_few(skills, counts.peer_draws), counts.peer_starts, settings)


def learning(settings: Settings, counts: keyframe_learning.Counts | None = None) -> list[Row]:
    """All rows of what is learnt."""
    return keyframe_learning.measure(settings, counts)


def learn(settings: Settings, draws: int) -> list[Learnt]:
    """A skill of every draw of both tasks' demonstrations."""
    return [keyframe_runs.learn(task, draw, settings) for task in tasks() for draw in range(draws)]


def _few(skills: list[Learnt], draws: int) -> list[Learnt]:
    """The first draws of each task."""
    return [learnt for learnt in skills if learnt.draw < draws]
