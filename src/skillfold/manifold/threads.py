"""Work shared among threads: compiled code and linear algebra hold no lock.

Plain threads: for work of milliseconds joblib's own scheduling would cost more than it saves.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import TypeVar

import numpy as np
from joblib import effective_n_jobs

S = TypeVar("S")
T = TypeVar("T")

FEWEST = 32  # rows a thread: fewer are done sooner than it starts


def in_parts(work: Callable[[slice], T], count: int, jobs: int) -> list[T]:
    """Results of work on consecutive parts of `count` rows, one part a thread."""
    workers = min(effective_n_jobs(jobs), -(-count // FEWEST))
    parts = [slice(a, b) for a, b in pairwise(np.linspace(0, count, workers + 1).astype(int).tolist())]
    if workers == 1:
        return [work(parts[0])]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(work, parts))


def in_turn(work: Callable[[S], T], items: Sequence[S], jobs: int) -> Iterator[T]:
    """Results of work on each item, in their order, as they are ready."""
    workers = min(effective_n_jobs(jobs), len(items))
    if workers == 1:
        yield from map(work, items)
        return
    with ThreadPoolExecutor(workers) as pool:
        yield from pool.map(work, items)
