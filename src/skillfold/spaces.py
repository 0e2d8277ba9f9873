"""What the coordinates of a state mean: lengths, bounded or continuous angles, quaternions.

Two arrays of numbers can name one and the same state: a continuous angle plus a full turn, a quaternion
and its negative. A `StateSpace` knows which, and takes differences and distances accordingly. Once the
states are made consistent (`unwrap`, `align`), plain arithmetic on them is right locally.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import Any, Self

import numpy as np

from skillfold.errors import InputError, SkillFileError

Array = np.ndarray[Any, np.dtype[np.float64]]

KINDS = ("linear", "angle", "continuous", "quaternion")
TURN = 2 * math.pi
# A step of half a turn may round to either side; leaving it alone keeps `unwrap` idempotent.
_HALF_TURN = math.pi + 1e-9
# Quaternions this close to unit length stay as they are, so that normalising twice changes no bit.
_UNIT = 1e-12


@dataclass(frozen=True, repr=False)
class StateSpace:
    """The kinds and limits of the D coordinates of a state.

    Attributes:
        kinds: one of "linear", "angle" (a joint with stops), "continuous" (an angle that repeats every turn)
            or "quaternion" (always four in a row, scalar first) for each coordinate.
        lower, upper: limits of each coordinate, infinite where there are none; only linear coordinates and
            angles have any. Left out, there are none. What cannot be is an `InputError`.
    """

    kinds: tuple[str, ...]
    lower: tuple[float, ...] = ()
    upper: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "kinds", tuple(self.kinds))
        _check_kinds(self.kinds)
        for name, missing in (("lower", -math.inf), ("upper", math.inf)):
            given = getattr(self, name)
            limits = tuple(_limit(v, name) for v in given) if len(given) else (missing,) * self.n_dims
            object.__setattr__(self, name, limits)
        self._check_limits()

    def _check_limits(self) -> None:
        if not len(self.lower) == len(self.upper) == self.n_dims:
            raise InputError(
                f"{len(self.lower)} lower and {len(self.upper)} upper limits for {self.n_dims} coordinates."
            )
        for i, (kind, low, high) in enumerate(zip(self.kinds, self.lower, self.upper, strict=True)):
            if not low < high:
                raise InputError(f"Limits of coordinate {i}: lower {low:g} is not below upper {high:g}.")
            if kind in ("continuous", "quaternion") and (math.isfinite(low) or math.isfinite(high)):
                raise InputError(f"Coordinate {i} is {kind}: only linear coordinates and angles have limits.")

    @classmethod
    def linear(
        cls,
        n: int,
        lower: float | Sequence[float] | None = None,
        upper: float | Sequence[float] | None = None,
    ) -> Self:
        """Space of `n` coordinates that simply subtract: positions, velocities, forces; limits optional."""
        return cls(("linear",) * _count(n), _spread(lower, n), _spread(upper, n))

    @classmethod
    def angles(
        cls,
        n: int,
        lower: float | Sequence[float] | None = None,
        upper: float | Sequence[float] | None = None,
    ) -> Self:
        """Space of `n` angles [rad] that do not repeat (joints with stops); one limit for all, or `n`."""
        return cls(("angle",) * _count(n), _spread(lower, n), _spread(upper, n))

    @classmethod
    def continuous(cls, n: int) -> Self:
        """Space of `n` angles [rad] that repeat every full turn."""
        return cls(("continuous",) * _count(n))

    @classmethod
    def quaternion(cls) -> Self:
        """Space of one orientation: unit quaternion qw, qx, qy, qz, the same as its negative."""
        return cls(("quaternion",) * 4)

    @classmethod
    def pose(cls) -> Self:
        """Space of one pose: x, y, z, then the unit quaternion qw, qx, qy, qz."""
        return cls.linear(3) + cls.quaternion()

    def __add__(self, other: "StateSpace") -> Self:
        """Space of the coordinates of both, one after the other."""
        if not isinstance(other, StateSpace):
            return NotImplemented
        return type(self)(self.kinds + other.kinds, self.lower + other.lower, self.upper + other.upper)

    def select(self, columns: Sequence[int]) -> Self:
        """Space of some coordinates in the order given; quaternions only as a whole."""
        for block in self.quaternions.tolist():
            inside = [i for i, column in enumerate(columns) if column in block]
            if inside and list(columns[inside[0] : inside[0] + 4]) != block:
                raise InputError(f"Coordinates {block} are one quaternion: select all four in this order, or none.")
        kinds = tuple(self.kinds[i] for i in columns)
        return type(self)(kinds, tuple(self.lower[i] for i in columns), tuple(self.upper[i] for i in columns))

    def __repr__(self) -> str:
        runs = [(kind, len(list(run))) for kind, run in groupby(self.kinds)]
        parts = [f"{n // 4 if kind == 'quaternion' else n} {kind}" for kind, n in runs]
        return f"StateSpace({', '.join(parts)})"

    @property
    def n_dims(self) -> int:
        """Number of coordinates D."""
        return len(self.kinds)

    @cached_property
    def quaternions(self) -> np.ndarray[Any, np.dtype[np.intp]]:
        """(n_quaternions, 4) columns of each quaternion."""
        return np.array([i for i, kind in enumerate(self.kinds) if kind == "quaternion"], int).reshape(-1, 4)

    @cached_property
    def _turning(self) -> np.ndarray[Any, np.dtype[np.intp]]:
        return np.array([i for i, kind in enumerate(self.kinds) if kind == "continuous"], int)

    @cached_property
    def is_flat(self) -> bool:
        """Whether states simply subtract: no continuous angles, no quaternions."""
        return not (len(self._turning) or len(self.quaternions))

    @cached_property
    def is_bounded(self) -> bool:
        """Whether any coordinate has a limit."""
        return bool(np.isfinite(self.lower + self.upper).any())

    def difference(self, a: Any, b: Any) -> Array:
        """`b` seen from `a`: (..., D), the shortest over all the ways to write `b`.

        Continuous angles differ by half a turn at most; quaternions by the chord to the nearer of `b`, `-b`.
        Shapes broadcast.
        """
        return self.align(b, a) - self._read(a)

    def distance(self, a: Any, b: Any) -> Array:
        """(...,) Euclidean norm of `difference(a, b)`."""
        return np.linalg.norm(self.difference(a, b), axis=-1)

    def align(self, states: Any, reference: Any) -> Array:
        """(..., D) `states` written nearest to `reference`: full turns added, quaternion signs chosen."""
        out, near = self._together(states, reference)
        if self.is_flat:
            return out
        t, q = self._turning, self.quaternions
        out[..., t] -= TURN * np.round((out[..., t] - near[..., t]) / TURN)
        dots = (out[..., q] * near[..., q]).sum(axis=-1, keepdims=True)
        out[..., q] = np.where(dots < 0, -out[..., q], out[..., q])
        return out

    def unwrap(self, states: Any) -> Array:
        """(..., n_steps, D) `states` without jumps along the recording; the first state stays as it is."""
        out = self._read(states).copy()
        if out.ndim < 2:
            raise InputError(f"unwrap: expected states (n_steps, {self.n_dims}), got shape {out.shape}.")
        t, q = self._turning, self.quaternions
        steps = np.diff(out[..., t], axis=-2)
        turns = np.where(np.abs(steps) > _HALF_TURN, np.round(steps / TURN), 0.0)
        out[..., 1:, t] -= TURN * np.cumsum(turns, axis=-2)
        dots = (out[..., 1:, q] * out[..., :-1, q]).sum(axis=-1, keepdims=True)
        out[..., 1:, q] *= np.cumprod(np.where(dots < 0, -1.0, 1.0), axis=-3)
        return out

    def normalize(self, states: Any) -> Array:
        """(..., D) `states` with every quaternion at unit length; all else untouched.

        Raises:
            InputError: a quaternion is all zeros or not finite.
        """
        out = self._read(states).copy()
        if not len(self.quaternions):
            return out
        parts = out[..., self.quaternions]
        largest = np.abs(parts).max(axis=-1, keepdims=True)
        if not (np.isfinite(largest) & (largest > 0)).all():
            raise InputError("normalize: a quaternion is all zeros or not finite; it has no direction.")
        # Divided by the largest entry first: squares of very large or small entries would not be finite.
        relative = np.linalg.norm(parts / largest, axis=-1, keepdims=True)
        unit = (parts / largest) / relative
        out[..., self.quaternions] = np.where(np.abs(largest * relative - 1) > _UNIT, unit, parts)
        return out

    def wrap(self, states: Any) -> Array:
        """(..., D) `states` with continuous angles brought into [-π, π); all else untouched."""
        out = self._read(states).copy()
        angles = out[..., self._turning]
        angles = angles - TURN * np.floor((angles + math.pi) / TURN)
        # Rounding may land on the open end, or a hair outside.
        out[..., self._turning] = np.where(np.abs(angles) >= math.pi, -math.pi, angles)
        return out

    def contains(self, states: Any, tolerance: float = 1e-6) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """(...,) whether states keep the limits and quaternions are of unit length, both to `tolerance`."""
        states = self._read(states)
        inside = np.isfinite(states).all(axis=-1)
        if self.is_bounded:
            lower, upper = np.array(self.lower) - tolerance, np.array(self.upper) + tolerance
            inside &= ((states >= lower) & (states <= upper)).all(axis=-1)
        if self.is_flat:
            return inside
        parts = states[..., self.quaternions]
        lengths = np.linalg.norm(np.where(np.abs(parts) < 10, parts, 10), axis=-1)
        return inside & (np.abs(lengths - 1) <= tolerance).all(axis=-1)

    def _read(self, states: Any) -> Array:
        try:
            array = np.asarray(states, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"States must be numbers (..., {self.n_dims}): {error}.") from None
        if array.ndim == 0 or array.shape[-1] != self.n_dims:
            raise InputError(f"Expected states (..., {self.n_dims}) of {self!r}, got shape {array.shape}.")
        return array

    def _together(self, a: Any, b: Any) -> tuple[Array, Array]:
        a, b = self._read(a), self._read(b)
        try:
            shape = np.broadcast_shapes(a.shape, b.shape)
        except ValueError:
            raise InputError(f"Shapes {a.shape} and {b.shape} do not broadcast.") from None
        return np.array(np.broadcast_to(a, shape)), np.broadcast_to(b, shape)

    def to_json(self) -> dict[str, Any]:
        """Plain dict of lists, None for a missing limit; `from_json` reads it back."""

        def plain(limits: tuple[float, ...]) -> list[float | None]:
            return [v if math.isfinite(v) else None for v in limits]

        return {"kinds": list(self.kinds), "lower": plain(self.lower), "upper": plain(self.upper)}

    @classmethod
    def from_json(cls, data: Any) -> Self:
        """Space from what `to_json` wrote.

        Raises:
            SkillFileError: anything else than that.
        """
        expected = {"kinds", "lower", "upper"}
        if not isinstance(data, dict) or set(data) != expected:
            raise SkillFileError(f"State space: expected a dict with {', '.join(sorted(expected))}.")
        lists = list(data.values())
        if not all(isinstance(v, list) for v in lists) or len({len(v) for v in lists}) > 1:
            raise SkillFileError("State space: kinds, lower and upper must be lists of one length.")
        lower = [-math.inf if v is None else v for v in data["lower"]]
        upper = [math.inf if v is None else v for v in data["upper"]]
        try:
            return cls(tuple(data["kinds"]), tuple(lower), tuple(upper))
        except InputError as error:
            raise SkillFileError(f"State space: {error}") from None


def _check_kinds(kinds: tuple[str, ...]) -> None:
    if not kinds:
        raise InputError("A state space needs at least one coordinate.")
    for i, kind in enumerate(kinds):
        if not isinstance(kind, str) or kind not in KINDS:
            raise InputError(f"Coordinate {i}: unknown kind {kind!r}; possible: {', '.join(KINDS)}.")
    for kind, run in groupby(kinds):
        if kind == "quaternion" and (n := len(list(run))) % 4:
            raise InputError(f"Quaternion coordinates come in fours (qw, qx, qy, qz); got {n} in a row.")


def _limit(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise InputError(f"{name}: limits must be numbers, got {value!r}.")
    try:
        number = float(value)
    except (OverflowError, TypeError):
        number = math.nan
    if math.isnan(number):
        raise InputError(f"{name}: a limit is not a usable number.")
    return number


def _count(n: Any) -> int:
    if isinstance(n, bool) or not isinstance(n, int | np.integer) or n < 1:
        raise InputError(f"A number of coordinates must be a whole number above 0, got {n!r}.")
    return int(n)


def _spread(limits: Any, n: int) -> tuple[Any, ...]:
    """One limit for each of `n` coordinates, from one for all, `n` of them, or none."""
    if limits is None:
        return ()
    values = tuple(np.ravel(limits).tolist())
    return values * n if len(values) == 1 else values
