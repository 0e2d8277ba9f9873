"""`skillfold fit-keyframes`: from keyframes of a few demonstrations to a saved skill, and what is in one."""

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from skillfold.cli import console, files
from skillfold.cli.options import Flag, seed, shown

if TYPE_CHECKING:
    from skillfold.keyframes.skill import KeyframeSkill

FORMAT = (
    "A CSV or NPZ file, or a folder of them, with columns x, y, z (metres), qw, qx, qy, qz (unit quaternion) and "
    "demo, which tells demonstrations apart: a row for each keyframe, in order, or with --extract or --gripper for "
    "each sample of full recordings (column t, in seconds)."
)
CHOSEN = "(chosen by evidence when left out)"


@dataclass(frozen=True)
class FitKeyframes:
    """Learn a skill from keyframes of the tool and save it."""

    keyframes: Annotated[Path, tyro.conf.Positional, shown("KEYFRAMES.CSV", "(a file or folder)", FORMAT)]
    out: Annotated[Path, shown("SKILL.NPZ")]
    """File for the skill."""
    number: Annotated[int | None, tyro.conf.arg(name="keyframes"), shown("K", CHOSEN)] = None
    """Number of keyframes of the skill."""
    coverage: Annotated[float, shown("SHARE")] = 0.975
    """Share of further keyframes that the gates hold, in position and in rotation."""
    interpolation: Literal["linear", "bures"] = "linear"
    """Of covariances between keyframes."""
    extract: Flag = False
    """Take keyframes from full recordings: at rests, sharp turns and both ends."""
    gripper: Annotated[str | None, shown("COLUMN", "(none)")] = None
    """Take them where this column of full recordings says that the gripper opens or closes."""
    seed: int = 0
    """Of everything random: the same seed gives the same skill."""
    json: Flag = False
    """Report as JSON."""

    def run(self) -> int:
        """Learn, save, report."""
        from skillfold.keyframes.skill import KeyframeSkill

        out = files.writable(self.out)
        start = perf_counter()
        with console.quiet():
            skill = KeyframeSkill.fit(
                self.keyframes,
                self.number,
                self.coverage,
                self.interpolation,
                seed(self.seed),
                extract=self.extract,
                gripper=self.gripper,
            )
        seconds = perf_counter() - start
        skill.save(out)
        for note in skill.notes:
            console.say(f"note: {note}")
        tell(skill, self.json, {"seconds": seconds, "out": str(out)})
        return 0


def tell(skill: "KeyframeSkill", as_json: bool, more: dict[str, Any] | None = None) -> None:
    """Report a skill to stdout."""
    told = {**facts(skill), **(more or {})}
    notes = [] if more else [f"Note: {note}" for note in skill.notes]
    gaussians = [_gaussian(skill, i) for i in range(len(skill.gaussians))]
    selection = [{"keyframes": k, "evidence": score} for k, score in skill.selection]
    everything = {**told, "gaussians": gaussians, "selection": selection, "notes": list(skill.notes)}
    console.report(everything, as_json, console.facts_table(told), _table(gaussians), _tried(skill), *notes)


def facts(skill: "KeyframeSkill") -> dict[str, Any]:
    """What `repr` tells, as plain values."""
    return {
        "keyframes": skill.n_keyframes,
        "demonstrations": len(skill.keyframes),
        "extra_keyframes": skill.extras,
        "coverage": skill.coverage,
        "interpolation": skill.interpolation,
    }


def _gaussian(skill: "KeyframeSkill", i: int) -> dict[str, Any]:
    import numpy as np

    gaussian = skill.gaussians[i]
    spread = [np.sqrt(np.linalg.eigvalsh(gaussian.covariance[b : b + 3, b : b + 3])[::-1]) for b in (0, 3)]
    return {
        "count": int(gaussian.count),
        "mean": gaussian.mean.tolist(),
        "spread": [part.tolist() for part in spread],
        "gates": gaussian.gates.tolist(),
    }


def _table(gaussians: list[dict[str, Any]]) -> Any:
    columns = {
        "#": "right",
        "from": "right",
        "x, y, z [m]": "left",
        "qw, qx, qy, qz": "left",
        "spread [mm]": "left",
        "spread [rad]": "left",
    }
    rows = [
        (
            i,
            g["count"],
            _numbers(g["mean"][:3], "{:.3f}"),
            _numbers(g["mean"][3:], "{:.3f}"),
            _numbers([1000 * s for s in g["spread"][0]], "{:.0f}"),
            _numbers(g["spread"][1], "{:.2f}"),
        )
        for i, g in enumerate(gaussians)
    ]
    return console.table("Keyframes, with how many each was learnt from", columns, rows)


def _tried(skill: "KeyframeSkill") -> Any:
    rows = [("✓" if k == skill.n_keyframes else "", k, f"{score:.1f}") for k, score in skill.selection]
    title = "Numbers of keyframes that fit tried, and took (✓)"
    return console.table(title, {"": "left", "keyframes": "right", "log evidence": "right"}, rows)


def _numbers(values: list[float], form: str) -> str:
    return " ".join(form.format(value) for value in values)
