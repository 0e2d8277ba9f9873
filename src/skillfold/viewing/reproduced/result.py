"""What a repeated experiment is, and what it comes to: rows beside the paper's figures, and pictures."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from skillfold.experiments.rows import Row, Settings


@dataclass(frozen=True)
class Picture:
    """A picture of our own data that shows what figures of the paper show.

    Attributes:
        file: where it was written.
        figures: of the paper, as "figures 9 and 10".
        caption: what is to be seen.
    """

    file: Path
    figures: str
    caption: str


@dataclass(frozen=True)
class Result:
    """Rows and pictures of one experiment."""

    rows: list[Row]
    pictures: list[Picture]


@dataclass(frozen=True)
class Experiment:
    """An experiment of the papers that can be repeated.

    Attributes:
        title: section and what it is about.
        paper: "000" (skill manifolds) or "002" (pose constraints).
        run: given settings and a folder for the pictures.
        differs: what is done otherwise than in the paper, and why; a sentence each.
    """

    title: str
    paper: str
    run: Callable[[Settings, Path], Result]
    differs: tuple[str, ...] = ()
