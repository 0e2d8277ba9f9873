"""Plain frozen data for motions: `Path` (no time), `Trajectory` (timed) and `Plan` (a path and its story)."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skillfold.errors import InputError

Array = np.ndarray[Any, np.dtype[np.float64]]

_FLOAT64 = np.dtype(np.float64)


def is_real(values: Any) -> bool:
    """Whether these are an array of float64 already, and nothing that NumPy would have to look into."""
    return type(values) is np.ndarray and values.dtype is _FLOAT64


def is_finite(values: Array) -> bool:
    """Whether all numbers are finite: most often their sum of squares is, which is told sooner."""
    return math.isfinite(np.vdot(values, values)) or bool(np.isfinite(values).all())


def _frozen(values: Any, name: str, ndim: int) -> Array:
    """A copy that cannot be written to, if these are finite numbers in that many dimensions."""
    array = values.copy() if is_real(values) else _numbers(values, name, ndim)
    if array.ndim != ndim or not is_finite(array):
        raise InputError(f"{_wanted(name, ndim)}, got shape {array.shape}.")
    array.flags.writeable = False
    return array


def _numbers(values: Any, name: str, ndim: int) -> Array:
    try:
        given = np.asarray(values)
    except (TypeError, ValueError):
        raise InputError(f"{_wanted(name, ndim)}, got ragged rows.") from None
    if given.size and given.dtype.kind not in "iuf":  # text, flags, complex numbers
        raise InputError(f"{_wanted(name, ndim)}, got an array of {given.dtype}.")
    return np.array(given, dtype=np.float64)


def _wanted(name: str, ndim: int) -> str:
    return f"{name}: expected {ndim} dimensions of finite numbers"


@dataclass(frozen=True)
class Path:
    """A sequence of states without time.

    Attributes:
        states: (n_steps, n_dims), in the units of the demonstrations, or joint positions; read-only.
        names: coordinate names, or empty.

    Raises:
        InputError: states that are no finite numbers in two dimensions.
    """

    states: Array
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "states", _frozen(self.states, "states", 2))

    def __len__(self) -> int:
        return len(self.states)

    @property
    def length(self) -> float:
        """Sum of the distances between consecutive states."""
        moves = self.states[1:] - self.states[:-1]
        return float(np.sqrt(np.einsum("ic,ic->i", moves, moves)).sum())


@dataclass(frozen=True)
class Trajectory:
    """A timed sequence of states.

    Attributes:
        times: (n_steps,), seconds, increasing.
        states: (n_steps, n_dims).
        names: coordinate names, or empty.

    Raises:
        InputError: times or states of other shapes or not finite, or times that do not increase.
    """

    times: Array
    states: Array
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "times", _frozen(self.times, "times", 1))
        object.__setattr__(self, "states", _frozen(self.states, "states", 2))
        if len(self.times) != len(self.states):
            raise InputError(f"{len(self.times)} times for {len(self.states)} states.")
        if (np.diff(self.times) <= 0).any():
            raise InputError("Times must increase strictly.")


@dataclass(frozen=True)
class Plan:
    """The answer to a planning query; failure is data, not an exception.

    Attributes:
        success: whether the path passed the independent check.
        reason: in words, why it failed; where it succeeded, what was done (ends moved, route taken).
        path: the path found, also where it failed the check; `path.states` is (n, D). Where none was looked for, the
            states that were asked for.
        length: of the path, in straight steps.
        residual: largest distance from the modelled surface; of keyframes, of the tool from its envelope or
            constraint [m]. Infinite where nothing was checked.
        iterations: of the solver.
        converged: whether the solver's own stop rule was met.
        route: "geodesic" (the paper's shortest path) or "demonstrated" (the way the demonstrations take); of
            keyframes "envelope", of `plan_constrained` "constrained".
        start_moved, goal_moved: how far the asked ends lay off the manifold and were projected.
        stats: anything else worth knowing, see the planners: `check` is the verdict, a `skillfold.check.Check`.
    """

    success: bool
    reason: str
    path: Path
    length: float
    residual: float
    iterations: int
    converged: bool
    route: str = "geodesic"
    start_moved: float = 0.0
    goal_moved: float = 0.0
    stats: dict[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        verdict = "success" if self.success else "failure"
        return (
            f"Plan({verdict}: {self.reason} {len(self.path)} states, length {self.length:.4g}, "
            f"residual {self.residual:.2g}, {self.iterations} iterations)"
        )
