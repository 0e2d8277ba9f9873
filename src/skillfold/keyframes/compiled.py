"""Pose constraints for loops that stay compiled: functions of one type, whatever the constraint."""

import ctypes
from functools import cache
from time import perf_counter
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.jit import compile_for, function_at, pointer
from skillfold.keyframes.constraint import Array, CompiledConstraint, Indices, PoseConstraint
from skillfold.keyframes.foreign import Foreign, known
from skillfold.keyframes.kernels import charts, envelope, hand_written
from skillfold.tables import Table

SLACK = 1e-6  # metres: projections that users write need not be exact
_CALL = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64, ctypes.c_int64)


def compiled_constraint(constraint: PoseConstraint) -> CompiledConstraint:
    """Any constraint for compiled loops: its own `compiled()` where it has that, else calls back into Python.

    Those take some 10 µs each, and what the constraint itself takes. What goes wrong in them is kept in
    `owner.error`, and from then on poses count as infinitely far outside: whoever runs the loop raises it afterwards
    (see `raise_error`). The same once the time is up that `call_until` sets.

    Raises:
        InputError: it has neither `compiled` nor `distance` and `project`.
    """
    known_one = known(constraint)
    if isinstance(known_one, Foreign):
        callback = Callback(known_one)
        return CompiledConstraint(*_callback_functions(), callback.addresses, callback)
    compiled = known_one.compiled() if callable(known_one.compiled) else None
    if not isinstance(compiled, CompiledConstraint):
        raise InputError(f"constraint: compiled of {type(constraint).__name__} gives no CompiledConstraint.")
    return compiled


def call_until(compiled: CompiledConstraint, deadline: float) -> None:
    """Have a user's constraint called no more after that time, in seconds of `perf_counter`."""
    if isinstance(compiled.owner, Callback):
        compiled.owner.deadline = deadline


def raise_error(compiled: CompiledConstraint) -> None:
    """Raise what went wrong in a user's constraint while a compiled loop ran, once."""
    error = getattr(compiled.owner, "error", None)
    if error is not None:
        compiled.owner.error = None
        raise error


@cache
def prepare_constraints() -> None:
    """Have ready all kinds of constraints, and what asks them for many poses at once."""
    (excess, project), *_ = [functions() for functions in FUNCTIONS]
    table, rows = np.empty(0, np.int64), np.empty((0, 0))
    compile_for(charts.flat, rows, rows.ravel(), rows)
    compile_for(charts.full, rows, rows.ravel(), rows)
    compile_for(envelope.memberships, rows, table, rows.ravel(), rows.ravel())
    compile_for(envelope.projections, rows, table, rows, rows.ravel())
    compile_for(hand_written.excesses, excess, rows, table, rows.ravel())
    compile_for(hand_written.projections, project, rows, table, rows)


def constraint_pointers(excess: Any, project: Any) -> tuple[Any, Any]:
    """Two plain functions as `CompiledConstraint` wants them; compiled now, or found on disk."""
    row, table = np.empty(0), np.empty(0, np.int64)
    return pointer(excess, 0.0, row, table), pointer(project, 0.0, row, row, table)


def compiled_chain(table: Table) -> CompiledConstraint:
    """The functions of a chain of ellipsoids with its table."""
    return CompiledConstraint(*_chain_functions(), table.entries, table)


class Callback:
    """A constraint in Python, callable from compiled loops, whichever thread runs them.

    Attributes:
        addresses: (2,) of the functions for the excess and the projection.
        error: the first that was raised since it was last cleared, or None.
        deadline: after which it is not called any more, in seconds of `perf_counter`.
    """

    def __init__(self, constraint: Foreign) -> None:
        self.error: BaseException | None = None
        self.deadline = np.inf
        self._constraint = constraint
        self._calls = _CALL(self._excess), _CALL(self._project)  # live as long as their addresses are used
        self.addresses = np.array([ctypes.cast(call, ctypes.c_void_p).value for call in self._calls], np.int64)

    def _excess(self, pose: int, _: int) -> float:
        return self._guarded(lambda: self._distance(_numbers(pose)))

    def _project(self, pose: int, out: int) -> float:
        return self._guarded(lambda: self._projected(_numbers(pose), _numbers(out)))

    def _distance(self, pose: Array) -> float:
        return float(self._constraint.distance(pose[None])[0]) - SLACK

    def _projected(self, pose: Array, out: Array) -> float:
        excess = self._distance(pose)
        out[:] = self._constraint.project(pose[None])[0] if excess > 0.0 else pose
        return excess

    def _guarded(self, call: Any) -> float:
        if self.error is not None or perf_counter() > self.deadline:
            return np.inf
        try:
            return call()
        except BaseException as error:  # a compiled loop cannot let it through
            self.error = error
            return np.inf


def _numbers(address: int) -> Array:
    return np.ctypeslib.as_array((ctypes.c_double * 7).from_address(address))


_callback_at = function_at(0.0, 0, 0)


def _callback_excess(pose: Array, addresses: Indices) -> float:
    return _callback_at(addresses[0])(np.int64(pose.ctypes.data), 0)


def _callback_project(pose: Array, out: Array, addresses: Indices) -> float:
    for c in range(7):  # what the projection leaves, should it fail
        out[c] = pose[c]
    return _callback_at(addresses[1])(np.int64(pose.ctypes.data), np.int64(out.ctypes.data))


@cache
def _callback_functions() -> tuple[Any, Any]:
    return constraint_pointers(_callback_excess, _callback_project)


def _chain_excess(pose: Array, table: Indices) -> float:
    return envelope.excess(pose, table)


def _chain_project(pose: Array, out: Array, table: Indices) -> float:
    return envelope.projected(pose, out, table)[0]


@cache
def _chain_functions() -> tuple[Any, Any]:
    return constraint_pointers(_chain_excess, _chain_project)


def _upright_excess(pose: Array, table: Indices) -> float:
    return hand_written.upright_excess(pose, table)


def _upright_project(pose: Array, out: Array, table: Indices) -> float:
    return hand_written.upright_project(pose, out, table)


def _plane_excess(pose: Array, table: Indices) -> float:
    return hand_written.plane_excess(pose, table)


def _plane_project(pose: Array, out: Array, table: Indices) -> float:
    return hand_written.plane_project(pose, out, table)


def _region_excess(pose: Array, table: Indices) -> float:
    return hand_written.region_excess(pose, table)


def _region_project(pose: Array, out: Array, table: Indices) -> float:
    return hand_written.region_project(pose, out, table)


@cache
def upright_functions() -> tuple[Any, Any]:
    """Excess and projection of `AxisUpright`."""
    return constraint_pointers(_upright_excess, _upright_project)


@cache
def plane_functions() -> tuple[Any, Any]:
    """Excess and projection of `PlaneConstraint`."""
    return constraint_pointers(_plane_excess, _plane_project)


@cache
def region_functions() -> tuple[Any, Any]:
    """Excess and projection of `TaskSpaceRegion`."""
    return constraint_pointers(_region_excess, _region_project)


FUNCTIONS = _chain_functions, _callback_functions, upright_functions, plane_functions, region_functions
