"""Experiments of the papers run one after the other; what is finished is kept, and a run that was stopped goes on."""

import secrets
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from traceback import extract_tb
from typing import Any

from skillfold import __version__
from skillfold.errors import SkillfoldError
from skillfold.experiments import bench
from skillfold.experiments.rows import Progress, Settings
from skillfold.viewing.reproduced import stored
from skillfold.viewing.reproduced.result import Experiment
from skillfold.viewing.reproduced.stored import Finished, Run

REPORT = "report.json"
Begin = Callable[[str, float], Progress]
"""Called with the experiment that begins and the share of all that is done; answers what is told of its inside."""


@dataclass(frozen=True)
class Asked:
    """What a user asks for.

    Attributes:
        names: of experiments; empty for all.
        quick: few trials of everything.
        data: folder of recordings, or None.
        seed: of everything random; None for that of the run in the folder, else a fresh one.
        fresh: measure all that is asked for, even what is stored.
    """

    names: tuple[str, ...] = ()
    quick: bool = False
    data: Path | None = None
    seed: int | None = None
    fresh: bool = False


@dataclass
class UnderWay:
    """A run under way.

    Attributes:
        run: what its experiments share.
        left: names of the experiments still to run.
        taken: names of those asked for that an earlier call finished.
        done: experiments that are finished.
        failed: what went wrong, in words, by the names of those that ended with an error.
        notes: sentences on what was found in the folder.
    """

    run: Run
    left: list[str]
    taken: list[str]
    done: dict[str, Finished] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def take_up(asked: Asked, experiments: Mapping[str, Experiment], folder: Path) -> UnderWay:
    """What is left of the run in the folder, or a new run.

    The run goes on where the settings, versions and machine are the same, and so is the seed unless none is given.
    Where all experiments are finished and neither seed nor names are given, a new run begins.
    """
    notes: list[str] = []
    run = _run(asked, folder, notes)
    names = list(dict.fromkeys(asked.names or experiments))
    anew = set(names) if asked.fresh else set[str]()
    done = _kept(run, [name for name in experiments if name not in anew], folder, notes)
    if asked.seed is None and not asked.names and len(done) == len(experiments):
        run, done = replace(run, seed=secrets.randbits(32)), {}
        notes.append(f"the run in {folder} is complete: begun anew.")
    taken = [name for name in names if name in done]
    return UnderWay(run, [name for name in names if name not in done], taken, done, notes=notes)


def machine() -> dict[str, Any]:
    """Machine and versions, this library's as it runs here."""
    facts = bench.machine()
    return facts | {"packages": facts["packages"] | {"skillfold": __version__}}


def go_on(
    under_way: UnderWay,
    experiments: Mapping[str, Experiment],
    folder: Path,
    begin: Begin,
    tell: Callable[[UnderWay], None],
) -> None:
    """Run what is left; `tell` is called at the start and after every experiment, with all that is there by then.

    An experiment that ends with an error does not stop the others: what went wrong is kept in words.
    """
    left = list(under_way.left)
    tell(under_way)
    for number, name in enumerate(left, 1):
        progress = begin(f"{name} ({number} of {len(left)})", (number - 1) / len(left))
        try:
            under_way.done[name] = _measured(name, experiments[name], under_way.run, folder, progress)
        except Exception as error:
            under_way.failed[name] = in_words(error)
        under_way.left.remove(name)
        tell(under_way)


def file_of(folder: Path, name: str) -> Path:
    """Where an experiment is kept."""
    return folder / f"{name}.json"


def in_words(error: Exception) -> str:
    """What went wrong; for an error that is no word of ours to a user, also its kind and where it arose."""
    if isinstance(error, SkillfoldError):
        return str(error)
    place = extract_tb(error.__traceback__)[-1:]
    where = "".join(f" ({Path(frame.filename).name}, line {frame.lineno})" for frame in place)
    return f"{type(error).__name__}: {' '.join(str(error).split())[:300]}{where}"


def _run(asked: Asked, folder: Path, notes: list[str]) -> Run:
    """The run in the folder where it is the one that is asked for, else a new one."""
    data = None if asked.data is None else str(asked.data.resolve())
    new = Run(secrets.randbits(32) if asked.seed is None else asked.seed, asked.quick, data, machine())
    earlier = None if asked.fresh else stored.read_run(folder / REPORT)
    if asked.seed is None and earlier and replace(earlier, seed=new.seed) == new:
        return earlier
    if earlier and earlier != new:
        notes.append(f"{folder} holds a run of another seed, of other settings or versions: begun anew.")
    return new


def _measured(name: str, experiment: Experiment, run: Run, folder: Path, progress: Progress) -> Finished:
    """Run an experiment and keep what it comes to."""
    data = None if run.data is None else Path(run.data)
    file = file_of(folder, name)
    file.unlink(missing_ok=True)  # of another run, whose pictures are now drawn over
    begun = perf_counter()
    result = experiment.run(Settings(run.seed, data, progress, quick=run.quick), folder)
    finished = Finished(tuple(result.rows), tuple(result.pictures), perf_counter() - begun)
    for picture in finished.pictures:
        stored.png(picture.file)
    stored.write(file, run, finished)
    return finished


def _kept(run: Run, names: Iterable[str], folder: Path, notes: list[str]) -> dict[str, Finished]:
    """What is finished of this run; of what cannot be read a note is made."""
    kept = {}
    for name in names:
        file = file_of(folder, name)
        if not file.exists():
            continue
        try:
            of, finished = stored.read(file)
        except ValueError as error:
            notes.append(f"{file} does not count: {error}.")
            continue
        if of == run:
            kept[name] = finished
    return kept
