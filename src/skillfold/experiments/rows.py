"""What every experiment returns: rows that stand beside a target and the paper's figure."""

import operator
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

Comparison = Literal["<=", "<", ">=", ">", "=="]
Progress = Callable[[str, float], None]
"""Called with what is being measured and the share of it that is done."""
Fit = Callable[..., Any]
"""`SkillManifold.fit`, or anything that answers like it."""

_COMPARE = {"<=": operator.le, "<": operator.lt, ">=": operator.ge, ">": operator.gt, "==": operator.eq}


@dataclass(frozen=True)
class Row:
    """One measured figure.

    Attributes:
        name: what was measured.
        measured: the figure, None where it could not be measured (the note says why).
        unit: of the figure; empty for a ratio or a count.
        target: what it must reach, None where the figure only stands beside another.
        comparison: between measured and target.
        paper: the paper's own figure, as it prints it.
        note: spread, shares and circumstances.
        group: the group of `skillfold bench` that measured it.
    """

    name: str
    measured: float | None
    unit: str = ""
    target: float | None = None
    comparison: Comparison = "<="
    paper: str = ""
    note: str = ""
    group: str = ""

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None where there is no target or no figure."""
        if self.target is None or self.measured is None:
            return None
        return bool(_COMPARE[self.comparison](self.measured, self.target))

    def as_dict(self) -> dict[str, Any]:
        """Every attribute and `met`, ready for JSON."""
        return {**asdict(self), "met": self.met}


@dataclass(frozen=True)
class Settings:
    """What a run of experiments shares.

    Attributes:
        seed: of everything random.
        data: folder with `ecomann/` and `robotasks/`, or None.
        progress: told how far the work is.
        fit: what learns a skill from samples or recordings; `SkillManifold.fit` unless told otherwise.
        quick: few trials of everything, for a first look.
    """

    seed: int
    data: Path | None = None
    progress: Progress = lambda label, share: None
    fit: Fit | None = None
    quick: bool = False

    def few(self, many: int, few: int) -> int:
        """How many trials: `many`, or `few` for a first look."""
        return few if self.quick else many

    def learn(self, demos: Any, **options: Any) -> Any:
        """A skill fitted with the given options and, apart from them, the defaults that a user gets."""
        return (self.fit or _default_fit())(demos, **options)


def _default_fit() -> Fit:
    # Loaded here: the truths of the experiments stand without any skill.
    from skillfold.manifold.skill import SkillManifold

    return SkillManifold.fit
