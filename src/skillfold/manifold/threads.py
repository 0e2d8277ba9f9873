"""Work shared among threads: compiled code and linear algebra hold no lock.

Plain threads: for work of milliseconds joblib's own scheduling would cost more than it saves. Trials go to a backend
of joblib all the same where the user has set one.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from functools import cache
from itertools import pairwise
from threading import current_thread
from typing import Any, TypeVar

import numpy as np
from joblib import Parallel, delayed, effective_n_jobs
from joblib.parallel import ThreadingBackend, get_active_backend
from threadpoolctl import ThreadpoolController

T = TypeVar("T")

HELPER = "skillfold helper"
FEWEST = 32  # rows a thread: fewer are done sooner than it starts


def libraries_alone() -> AbstractContextManager[Any]:
    """While it is entered, linear algebra starts no threads of its own: in each worker, it would get in their way."""
    return _libraries().limit(limits=1)


@cache
def _libraries() -> ThreadpoolController:
    """Those with threads; all that a fit calls are loaded with it. To look for them takes as long as some stages."""
    return ThreadpoolController()


def in_parts(work: Callable[[slice], T], count: int, jobs: int) -> list[T]:
    """Results of work on consecutive parts of `count` rows, one part a thread."""
    workers = min(effective_n_jobs(jobs), -(-count // FEWEST))
    parts = [slice(a, b) for a, b in pairwise(np.linspace(0, count, workers + 1).astype(int).tolist())]
    if workers == 1 or current_thread().name.startswith(HELPER):  # who helps must not wait for help
        return [work(part) for part in parts]
    others = _helpers(workers - 1).map(work, parts[1:])
    return [work(parts[0]), *others]


@cache
def _helpers(count: int) -> ThreadPoolExecutor:
    """Threads that stay: to start them takes as long as some parts."""
    return ThreadPoolExecutor(count, HELPER)


if hasattr(os, "register_at_fork"):  # a child process has none of its parent's threads
    os.register_at_fork(after_in_child=_helpers.cache_clear)


def in_turn(work: Callable[..., T], cases: Sequence[tuple], jobs: int) -> Iterator[T]:
    """Results of work on each case's arguments, in their order, as they are ready.

    Within `joblib.parallel_config`, of Dask or Ray for instance, its backend does the work: all of it is picklable.
    """
    workers = min(effective_n_jobs(jobs), len(cases))
    if not isinstance(get_active_backend(prefer="threads")[0], ThreadingBackend):
        results: Any = Parallel(jobs, return_as="generator")(delayed(work)(*case) for case in cases)
        yield from results
    elif workers == 1:
        yield from (work(*case) for case in cases)
    else:
        with ThreadPoolExecutor(workers) as pool:
            yield from pool.map(work, *zip(*cases, strict=True))
