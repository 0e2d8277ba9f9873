"""Plans around obstacles: patches and walls on the three-link arm's manifold, boxes beside an arm with a tray."""

from dataclasses import dataclass, field

from skillfold.experiments import around_arm, around_peers, around_tray
from skillfold.experiments.rows import Row, Settings


@dataclass(frozen=True)
class Counts:
    """How many cases: of the three-link arm, past boxes, past walls and boxes, and of those that OMPL is asked."""

    arm: around_arm.Counts = field(default_factory=around_arm.Counts)
    past: int = 200
    hard: int = 100
    peers: int = 40


def measure(settings: Settings, counts: Counts | None = None) -> list[Row]:
    """All rows; every case counts."""
    counts = counts or Counts()
    found = around_arm.measure(settings, counts.arm)
    task = around_tray.prepare(settings, counts.past, counts.hard)
    runs = around_tray.run(task, settings)
    found += around_tray.rows(task, runs)
    return found + around_peers.rows(runs[0].skill, task.past[: counts.peers], settings)
