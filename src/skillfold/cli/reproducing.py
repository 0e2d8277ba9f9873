"""`skillfold reproduce`: the paper's experiments, each with a table beside the paper's and a picture."""

import secrets
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from skillfold.cli import console, files
from skillfold.cli.measuring import rows_table
from skillfold.cli.options import Flag, seed, shown
from skillfold.cli.screen import draw_off_screen
from skillfold.errors import InputError

NAMES = (
    "Some of patches (section V-B3), table-one (V-C and VI), boxes and tumblers (VI, among obstacles and pushed), "
    "nao-balance and nao-stepping (VII), pick-place (VIII); of keyframes: envelopes (figures 2 and 3), keyframes "
    "(5 to 8) and keyframe-cost (9)."
)


@dataclass(frozen=True)
class Reproduce:
    """Repeat experiments of the paper: for each a table beside the paper's figures, and a picture."""

    names: Annotated[tuple[str, ...], tyro.conf.Positional, shown("NAME", "(all when left out)", NAMES)] = ()
    out: Annotated[Path, shown("FOLDER")] = Path("results")
    """Folder for the pictures; made where it is missing."""
    seed: Annotated[int | None, shown("INT", "(a fresh one, which is told)")] = None
    """Of everything random."""
    json: Flag = False
    """Report as JSON."""

    def run(self) -> int:
        """Run, draw, report."""
        chosen = secrets.randbits(32) if self.seed is None else seed(self.seed)
        folder = files.folder(self.out)
        draw_off_screen()
        from skillfold.experiments.rows import Settings
        from skillfold.viewing.reproduced import EXPERIMENTS

        unknown = [name for name in self.names if name not in EXPERIMENTS]
        if unknown:
            raise InputError(f"No experiment named {', '.join(unknown)}; there are {', '.join(EXPERIMENTS)}.")
        told: list[dict[str, Any]] = []
        tables = []
        with console.progress() as progress, console.quiet():
            for name in dict.fromkeys(self.names or EXPERIMENTS):
                result = EXPERIMENTS[name].run(Settings(chosen, None, progress), folder)
                files_of = [str(picture.file) for picture in result.pictures]
                told.append({"name": name, "pictures": files_of, "rows": [row.as_dict() for row in result.rows]})
                tables.append(rows_table(name, result.rows))
        pictures = ", ".join(file for part in told for file in part["pictures"])
        facts = {"seed": chosen, "experiments": told}
        console.report(facts, self.json, *tables, f"seed {chosen}; pictures: {pictures}")
        return 0
