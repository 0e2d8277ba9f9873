"""Tables III and IV of paper 000 from what was measured, and what they leave out: shapes."""

from collections.abc import Callable, Sequence
from time import perf_counter, process_time
from typing import Any

import numpy as np

from skillfold.baselines.gmr_dynamics import Dynamics
from skillfold.errors import MissingExtraError
from skillfold.experiments.pick_place import KERNELS, Compared, Method, planned
from skillfold.experiments.pick_place_sets import SMALL, START, MotionSet, cube
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array

DIM = 1  # the paper's, where training is timed
TRAININGS = (20, 3)  # as in the paper, and for a first look
PAPER = {("start", "small"): "27; GMM/GMR 12", ("start", "large"): "27; GMM/GMR 8"}
PAPER |= {("goal", "small"): "27; GMM/GMR –", ("goal", "large"): "27; GMM/GMR –"}
SHAPE_WORDS = ("the recordings", "the recording most alike")


def rows(compared: Sequence[Compared]) -> list[Row]:
    """Table IV, with what the paper leaves out; its own figures stand beside the first set, which is like its own."""
    return [
        row
        for index, each in enumerate(compared)
        for row in (*_reached_rows(each, index == 0), *_shape_rows(each), _left_out_row(each))
    ]


def training_rows(motions: MotionSet, settings: Settings) -> list[Row]:
    """Table III: both methods with five kernels, in seconds that one waits; the processor's are told beside."""
    settings.progress("pick and place: training", 0.72)
    trainings = settings.few(*TRAININGS)
    trained: dict[str, Callable[[int], Method]] = {
        "manifold": lambda i: planned(settings.learn(list(motions.recordings), dim=DIM, kernels=KERNELS)),
        "GMM/GMR": lambda i: Dynamics.fit(motions.recordings, settings.seed + i, KERNELS).paths,
    }
    taken: dict[str, tuple[Array, Array]] = {}
    missing = ""
    for name, train in trained.items():
        try:
            taken[name] = _times(train, motions, trainings)
        except MissingExtraError as error:
            missing = str(error)
    papers = (("training, 5 kernels", "1.38; GMM/GMR 2.35"), ("generation", "0.0817; GMM/GMR 0.0853"))
    return [
        _time_row(*paper, {name: times[k] for name, times in taken.items()}, missing)
        for k, paper in enumerate(papers)
    ]


def _times(train: Callable[[int], Method], motions: MotionSet, trainings: int) -> tuple[Array, Array]:
    """Seconds (n, 2), of the clock and of the processor, of each training, and of a motion from each near start."""
    method = train(trainings)  # what is compiled once is there before anything is timed
    starts = cube(motions.start, SMALL * motions.reach / float(np.linalg.norm(START)))
    method(starts[:1], motions.goal[None])
    learning = [_timed(lambda i=i: train(i)) for i in range(trainings)]
    moving = [_timed(lambda start=start: method(start[None], motions.goal[None])) for start in starts]
    return np.array(learning), np.array(moving)


def _timed(call: Callable[[], Any]) -> tuple[float, float]:
    begun = perf_counter(), process_time()
    call()
    return perf_counter() - begun[0], process_time() - begun[1]


def _time_row(name: str, paper: str, taken: dict[str, Array], missing: str) -> Row:
    """Means; the target is learnt dynamics' here."""
    clock = {method: float(times[:, 0].mean()) for method, times in taken.items()}
    told = [f"{method} {times[:, 1].mean():.2g} s of the processor" for method, times in taken.items()]
    note = "; ".join(
        [f"mean of {len(taken['manifold'])}; all threads together: {', '.join(told)}", *filter(None, [missing])]
    )
    return Row(f"Table III: {name}", clock["manifold"], "s", clock.get("GMM/GMR"), "<", paper, note)


def _reached_rows(each: Compared, first: bool) -> list[Row]:
    found = []
    for index, cell in enumerate(each.cells["manifold"]):
        others = [f"{name} {int(cells[index].reached.sum())}" for name, cells in _others(each.cells).items()]
        name = f"Table IV: {each.motions.name}, {cell.what} changed, {cell.size} cube: reached"
        count, paper = len(cell.reached), PAPER[cell.what, cell.size] if first else ""
        note = "; ".join([*others, *each.missing])
        found.append(Row(name, int(cell.reached.sum()), f"of {count}", count, ">=", paper, note))
    return found


def _shape_rows(each: Compared) -> list[Row]:
    """Mean shape distances at changed starts, where dynamics can be asked too."""
    means = [
        {
            name: float(np.mean([cell.shapes[:, k].mean() for cell in cells if cell.what == "start"]))
            for name, cells in each.cells.items()
        }
        for k in range(len(SHAPE_WORDS))
    ]
    return [_shape_row(each, mean, words) for mean, words in zip(means, SHAPE_WORDS, strict=True)]


def _left_out_row(each: Compared) -> Row:
    return _shape_row(each, {name: float(d.mean()) for name, d in each.left_out.items()}, "a recording left out")


def _shape_row(each: Compared, means: dict[str, float], words: str) -> Row:
    """The manifold's; the others' least is the target."""
    others = _others(means)
    note = "; ".join([*(f"{name} {mean:.3f}" for name, mean in others.items()), *each.missing])
    name = f"{each.motions.name}: shape distance from {words}"
    return Row(name, means.get("manifold"), "", min(others.values(), default=None), "<", "", note)


def _others(of: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in of.items() if name != "manifold"}
