"""What was tried and what was taken: the record of every choice that fitting made for the user."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Trial:
    """One candidate.

    Attributes:
        choice: what is chosen: "dimension", "free directions", "surface", "smoothing" or "field".
        setting: the candidate, such as "degree 3, 22 neighbours".
        score: what it was judged by; its meaning is in `measure`.
        measure: name of the score, and which way is better.
        chosen: whether it was taken.
    """

    choice: str
    setting: str
    score: float
    measure: str
    chosen: bool


class Selection(tuple[Trial, ...]):
    """All trials of a fit, in order; prints as a table."""

    __slots__ = ()

    def of(self, choice: str) -> "Selection":
        """The trials of one choice."""
        return Selection(trial for trial in self if trial.choice == choice)

    def to_json(self) -> list[list[Any]]:
        """Rows for a saved skill."""
        return [[t.choice, t.setting, t.score, t.measure, t.chosen] for t in self]

    def __repr__(self) -> str:
        lines = [
            f"{'*' if t.chosen else ' '} {t.choice:<16} {t.setting:<32} {t.score:<12.4g} {t.measure}" for t in self
        ]
        return "\n".join(["  chosen by fit (*)", *lines])
