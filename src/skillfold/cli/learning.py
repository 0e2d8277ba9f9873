"""`skillfold fit` and `skillfold info`: from recordings to a saved skill, and what is in one."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from skillfold.cli import console, files, keyframes
from skillfold.cli.options import Flag, shown
from skillfold.errors import InputError

if TYPE_CHECKING:
    from skillfold.demonstrations import Demonstrations
    from skillfold.manifold.skill import SkillManifold
    from skillfold.manifold.table import Trial

FORMAT = (
    "CSV or NPZ files, or folders of them. A CSV has a header and a row per sample; column t holds seconds, column "
    "demo tells recordings apart, all others are coordinates: angles in radians, the rest in any unit."
)
CHOSEN = "(chosen from the data when left out)"
SHOWN = 6  # trials of each choice


@dataclass(frozen=True)
class Fit:
    """Learn a skill from recordings and save it."""

    recordings: Annotated[tuple[Path, ...], tyro.conf.Positional, shown("RECORDINGS...", "(one at least)", FORMAT)]
    out: Annotated[Path, shown("SKILL.NPZ")]
    """File for the skill."""
    dim: Annotated[int | None, shown("D", CHOSEN)] = None
    """Dimension of the manifold."""
    kernels: Annotated[int | None, shown("K", CHOSEN)] = None
    """Radial basis functions of the tangent field."""
    ridge: Annotated[float | None, shown("L", CHOSEN)] = None
    """Regulariser λ, for steps of unit rms."""
    neighbors: Annotated[int | None, shown("N", "(6 to 10, by the number of coordinates, when left out)")] = None
    """Neighbours of each sample to start with; grown until all samples are connected."""
    seed: int = 0
    """Of everything random: the same seed gives the same skill."""
    cloud: Flag = False
    """Take the rows as samples without order."""
    phase: Flag = False
    """Append progress along each recording as a coordinate: for motions that cross their own path."""
    velocity: Flag = False
    """Append velocities (units per second) as coordinates; needs times."""
    json: Flag = False
    """Report as JSON."""

    def run(self) -> int:
        """Learn, save, report."""
        out = files.writable(self.out)
        demos = self._demonstrations()
        start = perf_counter()
        with console.progress() as progress, console.quiet():
            skill = self._learn(demos, progress)
        seconds = perf_counter() - start
        skill.save(out)
        for note in skill.notes:
            console.say(f"note: {note}")
        console.report({**facts(skill), "seconds": seconds, "out": str(out)}, self.json)
        return 0

    def _demonstrations(self) -> "Demonstrations":
        from skillfold.demonstrations import Demonstrations

        if self.cloud and (self.phase or self.velocity):
            raise InputError("--cloud: samples without order have neither phase nor velocity.")
        if not self.recordings:
            raise InputError("No recordings given; expected CSV or NPZ files, or folders of them.")
        demos = Demonstrations.load(list(self.recordings))
        demos = demos.with_velocity() if self.velocity else demos
        return demos.with_phase() if self.phase else demos

    def _learn(self, demos: "Demonstrations", progress: console.Progress) -> "SkillManifold":
        from skillfold.manifold.skill import SkillManifold

        space = demos.space if self.cloud else None
        options: dict[str, Any] = {"space": space, "progress": progress}
        given = demos.states if self.cloud else demos
        skill = SkillManifold.fit(given, self.dim, self.kernels, self.ridge, self.neighbors, self.seed, **options)
        return replace(skill, names=demos.names)  # an array has lost them


@dataclass(frozen=True)
class Info:
    """Tell what a saved skill is, a manifold or keyframes, and how fit chose it."""

    skill: Annotated[Path, tyro.conf.Positional, shown("SKILL.NPZ")]
    """A saved skill."""
    json: Flag = False
    """Report as JSON."""

    def run(self) -> int:
        """Load and report."""
        if files.kind(self.skill) == "keyframes":
            keyframes.tell(files.load_keyframes(self.skill), self.json)
            return 0
        skill = files.load(self.skill)
        told = facts(skill)
        trials = [asdict(trial) for trial in skill.selection]
        notes = [f"Note: {note}" for note in skill.notes]
        everything = {**told, "selection": trials, "notes": list(skill.notes)}
        console.report(everything, self.json, console.facts_table(told), _selection(skill), *notes)
        return 0


def facts(skill: "SkillManifold") -> dict[str, Any]:
    """What `repr` tells and the little beside it, as plain values."""
    return {
        "dim": skill.dim,
        "n_dims": skill.n_dims,
        "coordinates": list(skill.names),
        "space": repr(skill.space),
        "samples": skill.n_samples,
        "demonstrations": len(skill.route.curves) if skill.route else None,
        "kernels": skill.kernels,
        "ridge": float(skill.ridge),
        "residual": float(skill.residual),
        "noise": float(skill.noise),
        "tolerance": float(skill.tolerance),
        "converged": bool(skill.converged),
    }


def _selection(skill: "SkillManifold") -> Any:
    choices = list(dict.fromkeys(trial.choice for trial in skill.selection))
    trials = [trial for choice in choices for trial in _nearest_taken(skill.selection.of(choice))]
    columns = {"": "left", "choice": "left", "setting": "left", "score": "right", "judged by": "left"}
    rows = [("✓" if t.chosen else "", t.choice, t.setting, f"{t.score:.4g}", t.measure) for t in trials]
    hidden = len(skill.selection) - len(trials)
    title = "What fit tried and took (✓)" + (f"; {hidden} more in --json" if hidden else "")
    return console.table(title, columns, rows)


def _nearest_taken(trials: Sequence["Trial"]) -> list["Trial"]:
    """The trial taken and those whose scores come nearest to its own, in their order."""
    taken = next((trial.score for trial in trials if trial.chosen), trials[0].score)
    nearest = sorted(trials, key=lambda trial: (not trial.chosen, abs(trial.score - taken)))[:SHOWN]
    return [trial for trial in trials if trial in nearest]
