"""Compiled ahead: another process fills Numba's cache on disk with what this one will need later."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def running(module: str, *arguments: str) -> Iterator[None]:
    """Run a module of this library, with arguments, beside what is done here; at the end it is waited for.

    Both processes look on disk before they compile and write there what they compiled, so whatever is needed is
    compiled by one of them, seldom by both. Nothing depends on it: where the other fails, this one compiles all.
    """
    if (os.cpu_count() or 1) < 2:
        yield
        return
    silent = subprocess.DEVNULL
    with subprocess.Popen([sys.executable, "-m", module, *arguments], stdin=silent, stdout=silent, stderr=silent):
        yield
