"""`njit` as this library uses it: compiled at first use, kept on disk where a cache folder can be written."""

from collections.abc import Callable
from typing import Any

import numba

# Sums may be reordered so that loops vectorise; NaN and infinities keep their meaning.
_MATHS = {"reassoc", "contract", "nsz", "arcp"}


def njit(function: Callable[..., Any]) -> Any:
    """Compile lazily, without the interpreter's lock, cached on disk if that is possible."""
    try:
        return numba.njit(cache=True, nogil=True, fastmath=_MATHS, error_model="numpy")(function)
    except RuntimeError:  # Numba found no folder that it may write its cache to
        return numba.njit(nogil=True, fastmath=_MATHS, error_model="numpy")(function)
