"""Numba as this library uses it: compiled at first use, kept on disk where a cache folder can be written.

A compiled function takes in all that it calls, and is optimised and translated as a whole, once more in each function
that calls it. So three kinds are told apart: those that Python calls; those that only compiled code calls, which need
no way in from Python; and parts of one function, which are functions for the reader alone.
"""

from collections.abc import Callable
from typing import Any

import numba
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

_OPTIONS: dict[str, Any] = {
    "nogil": True,
    # Sums may be reordered so that loops vectorise; NaN and infinities keep their meaning.
    "fastmath": {"reassoc", "contract", "nsz", "arcp"},
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
}


def njit(function: Callable[..., Any]) -> Any:
    """Compile lazily, without the interpreter's lock, cached on disk if that is possible."""
    return _compiled(function)


def inner(function: Callable[..., Any]) -> Any:
    """The same, for compiled code alone: a way in from Python would take a fifth of the time that it compiles."""
    return _compiled(function, no_cpython_wrapper=True)


def inlined(function: Callable[..., Any]) -> Any:
    """A part of the compiled function that calls it: for what is called from one place."""
    return _compiled(function, inline="always")


def pointer(function: Callable[..., Any], returns: Any, *arguments: Any) -> Any:
    """Compile now, for values like those given: a function to pass to compiled loops as an argument.

    They see its type alone, so one loop serves all functions of that type and its compiled form is found on disk
    again; a function made by `njit` would make them compile anew in every process.
    """
    signature = numba.typeof(returns)(*(numba.typeof(value) for value in arguments))
    maths, errors = _OPTIONS["fastmath"], _OPTIONS["error_model"]
    return _cached(lambda **options: numba.cfunc(signature, fastmath=maths, error_model=errors, **options)(function))


def _compiled(function: Callable[..., Any], **how: Any) -> Any:
    return _cached(lambda **options: numba.njit(**_OPTIONS, **how, **options)(function))


def compile_for(function: Any, *values: Any) -> None:
    """Compile a function of `njit` for arguments like these, or find it on disk: before a clock starts."""
    function.compile(tuple(numba.typeof(value) for value in values))


def function_at(returns: Any, *arguments: Any) -> Any:
    """A compiled function from the address of a `pointer` to what can be called, for values like those given.

    To be called from Python with a `pointer` itself costs 25 µs, with its address none.
    """
    kind = types.FunctionType(numba.typeof(returns)(*(numba.typeof(value) for value in arguments)))

    def to_function(typing: Any, where: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            made = cgutils.create_struct_proxy(kind)(context, builder)
            made.c_addr = builder.inttoptr(values[0], made.c_addr.type)
            return made._getvalue()

        return kind(types.int64), generate

    return intrinsic(to_function)


def _cached(compiled: Callable[..., Any]) -> Any:
    try:
        return compiled(cache=True)
    except RuntimeError:  # Numba found no folder that it may write its cache to
        return compiled()
