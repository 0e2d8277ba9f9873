"""Work shared among threads: compiled code and linear algebra hold no lock."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import TypeVar

import numpy as np
from joblib import effective_n_jobs

T = TypeVar("T")

FEWEST = 32  # rows a thread: fewer are done sooner than it starts


def in_parts(work: Callable[[slice], T], count: int, jobs: int) -> list[T]:
    """Results of work on consecutive parts of `count` rows, one part a thread.

    Plain threads: for work of milliseconds joblib's own scheduling would cost more than it saves.
    """
    workers = min(effective_n_jobs(jobs), -(-count // FEWEST))
    parts = [slice(a, b) for a, b in pairwise(np.linspace(0, count, workers + 1).astype(int).tolist())]
    if workers == 1:
        return [work(parts[0])]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(work, parts))
