"""Trials that know nothing of each other, run over all cores."""

import os
from collections.abc import Iterator, Sequence
from typing import Any

from skillfold.experiments.rows import Progress


def in_parallel(
    function: Any,
    cases: Sequence[tuple[Any, ...]],
    progress: Progress | None = None,
    label: str = "",
    between: tuple[float, float] = (0.0, 1.0),
) -> Iterator[Any]:
    """`function(*case)` for every case, in order, in as many processes as there are cores.

    Args:
        function: can be pickled, and so can its answers.
        cases: arguments of every call.
        progress: told after every case, with `label` and a share that grows between the two given.
    """
    # Loaded here: most who name this room run nothing.
    from joblib import Parallel, delayed

    jobs = min(os.cpu_count() or 1, max(len(cases), 1))
    low, high = between
    answers = Parallel(jobs, return_as="generator")(delayed(function)(*case) for case in cases)
    for done, answer in enumerate(answers, 1):
        if progress:
            progress(label, low + (high - low) * done / len(cases))
        yield answer
