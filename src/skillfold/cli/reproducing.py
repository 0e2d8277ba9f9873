"""`skillfold reproduce`: the papers' experiments, in one report beside the papers' figures."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from skillfold.cli import console, files
from skillfold.cli.measuring import rows_table
from skillfold.cli.options import Flag, seed, shown
from skillfold.cli.screen import draw_off_screen
from skillfold.errors import InputError

if TYPE_CHECKING:
    from skillfold.viewing.reproduced.running import UnderWay

NAMES = (
    "Some of reaching (sections V-A and V-B), patches (V-B3), table-one (V-C and VI), boxes and tumblers (VI, among "
    "obstacles and pushed), nao-balance and nao-stepping (VII), pick-place (VIII); of keyframes: envelopes (figures "
    "2 and 3), keyframes (5 to 8) and keyframe-cost (9)."
)
OUT = (
    "Folder for report.html, report.json, the pictures and what is finished. A run that was stopped goes on where it "
    "was; one that is complete begins anew, with another seed."
)
SEED = "Of everything random. With the seed of the run in the folder, only what is missing there is measured."


@dataclass(frozen=True)
class Reproduce:
    """Repeat the papers' experiments: one report with tables beside the papers' figures, and pictures."""

    names: Annotated[tuple[str, ...], tyro.conf.Positional, shown("NAME", "(all when left out)", NAMES)] = ()
    quick: Flag = False
    """Few trials of everything, for a first look: two minutes instead of thirty."""
    out: Annotated[Path, shown("FOLDER", told=OUT)] = Path("results")
    data: Annotated[Path | None, shown("FOLDER", "(drawn, or left out)")] = None
    """Folder with ecomann/ and robotasks/."""
    seed: Annotated[int | None, shown("INT", "(that of the run that goes on, else a fresh one)", SEED)] = None
    fresh: Flag = False
    """Measure anew what is finished, too."""
    list: Flag = False
    """Tell names and titles, and run nothing."""
    json: Flag = False
    """Report as JSON."""

    def run(self) -> int:
        """Run, draw, report; exit code 1 where an experiment ended with an error."""
        chosen = None if self.seed is None else seed(self.seed)
        data = self.data and files.existing_folder("--data", self.data)
        draw_off_screen()
        from skillfold.viewing.reproduced import EXPERIMENTS
        from skillfold.viewing.reproduced.running import Asked, take_up

        if self.list:
            console.report({name: experiment.title for name, experiment in EXPERIMENTS.items()}, self.json)
            return 0
        unknown = [name for name in self.names if name not in EXPERIMENTS]
        if unknown:
            raise InputError(f"No experiment named {', '.join(unknown)}; there are {', '.join(EXPERIMENTS)}.")
        folder = files.folder(self.out)
        under_way = take_up(Asked(self.names, self.quick, data, chosen, self.fresh), EXPERIMENTS, folder)
        _tell_found(under_way)
        facts = self._go_on(under_way, folder)
        console.report(facts, self.json, *_tables(under_way, facts, folder))
        return 1 if under_way.failed else 0

    def _go_on(self, under_way: "UnderWay", folder: Path) -> dict[str, Any]:
        from skillfold.viewing.reproduced import EXPERIMENTS, report
        from skillfold.viewing.reproduced.running import go_on

        facts: dict[str, Any] = {}

        def tell(now: "UnderWay") -> None:
            facts.update(report.write(now, EXPERIMENTS, folder))

        try:
            with console.progress_in_parts() as begin, console.quiet():
                go_on(under_way, EXPERIMENTS, folder, begin, tell)
        except KeyboardInterrupt:
            self._tell_stopped(under_way, folder / report.PAGE)
            raise
        return facts

    def _tell_stopped(self, under_way: "UnderWay", page: Path) -> None:
        command = "the same command without --fresh" if self.fresh else "the same command"
        left = ", ".join(under_way.left)
        console.say(f"{len(under_way.done)} finished, in {page}; {left} left; {command} goes on")


def _tell_found(under_way: "UnderWay") -> None:
    for note in under_way.notes:
        console.say(f"note: {note}")
    if under_way.taken:
        console.say(f"finished before, and taken over: {', '.join(under_way.taken)}; --fresh measures them anew")


def _tables(under_way: "UnderWay", facts: dict[str, Any], folder: Path) -> list[Any]:
    from skillfold.viewing.reproduced.report import PAGE

    tables = [
        rows_table(f"{part['title']}, {part['seconds']:.0f} s", under_way.done[part["name"]].rows)
        for part in facts["experiments"]
        if part["failed"] is None
    ]
    failures = [f"{name} ended with an error. {words}" for name, words in under_way.failed.items()]
    counts = facts["targets"]
    judged = counts["met"] + counts["missed"] + counts["not measured"]
    verdict = f"{counts['met']} of {judged} targets met; seed {facts['seed']}; report: {folder / PAGE}"
    return [*tables, *failures, verdict]
