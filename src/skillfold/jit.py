"""`njit` as this library uses it: compiled at first use, kept on disk where a cache folder can be written."""

from collections.abc import Callable
from typing import Any

import numba

# Sums may be reordered so that loops vectorise; NaN and infinities keep their meaning.
_MATHS = {"reassoc", "contract", "nsz", "arcp"}


def njit(function: Callable[..., Any]) -> Any:
    """Compile lazily, without the interpreter's lock, cached on disk if that is possible."""
    return _cached(
        lambda **options: numba.njit(nogil=True, fastmath=_MATHS, error_model="numpy", **options)(function)
    )


def pointer(function: Callable[..., Any], returns: Any, *arguments: Any) -> Any:
    """Compile now, for values like those given: a function to pass to compiled loops as an argument.

    They see its type alone, so one loop serves all functions of that type and its compiled form is found on disk
    again; a function made by `njit` would make them compile anew in every process.
    """
    signature = numba.typeof(returns)(*(numba.typeof(value) for value in arguments))
    return _cached(
        lambda **options: numba.cfunc(signature, fastmath=_MATHS, error_model="numpy", **options)(function)
    )


def _cached(compiled: Callable[..., Any]) -> Any:
    try:
        return compiled(cache=True)
    except RuntimeError:  # Numba found no folder that it may write its cache to
        return compiled()
