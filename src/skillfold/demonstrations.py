"""Recordings of a skill, checked and in one state space."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any, Self

import numpy as np

from skillfold import alignment
from skillfold.consistency import in_one_form
from skillfold.crossings import Crossing, crossings
from skillfold.errors import InputError
from skillfold.recordings import LARGEST, Demonstration, Recording, checked_times, given
from skillfold.spaces import StateSpace

Array = np.ndarray[Any, np.dtype[np.float64]]

# Progress along the path, as a multiple of the samples' rms radius: measured to part crossing strokes
# without drowning the other coordinates.
PHASE_SCALE = 3.0


@dataclass(frozen=True, eq=False, init=False)
class Demonstrations:
    """Recordings of one skill, of any lengths, in one state space.

    Quaternions are brought to unit length and to consistent signs, continuous angles are unwrapped, along
    each recording and across them: all arithmetic on `states` may then treat them as plain numbers.

    Attributes:
        items: the demonstrations.
        names: of the coordinates.
        space: kinds and limits of the coordinates.
    """

    items: tuple[Demonstration, ...]
    names: tuple[str, ...]
    space: StateSpace

    def __init__(
        self,
        recordings: Any,
        times: Any = None,
        names: Sequence[str] | None = None,
        space: StateSpace | None = None,
        labels: Sequence[str] | None = None,
    ) -> None:
        """Check recordings and bring them into one form.

        Args:
            recordings: one (n_steps, n_dims) array, a list of these, or one (n_demos, n_steps, n_dims) array.
            times: seconds, (n_steps,) for one array or for all of equal length, or one such for each
                recording (None for those that have none).
            names: of the coordinates; x0, x1, … when left out.
            space: what the coordinates are. Left out, names qw, qx, qy, qz in a row (with any prefix and
                suffix) make a quaternion and everything else is linear.
            labels: names of the recordings; 0, 1, … when left out.

        Raises:
            RecordingError: a recording cannot be used; the message names the demonstration, row, column,
                value and what was expected.
        """
        self._fill(given(recordings, times, labels), names, space)

    @classmethod
    def of(
        cls, recordings: Sequence[Recording], names: Sequence[str] | None, space: StateSpace | None = None
    ) -> Self:
        """From raw recordings that know the file and rows they came from; the same checks."""
        made = cls.__new__(cls)
        made._fill(recordings, names, space)
        return made

    def _fill(self, recordings: Sequence[Recording], names: Sequence[str] | None, space: StateSpace | None) -> None:
        arrays, names, space = in_one_form(recordings, names, space)
        items = [
            Demonstration(states, checked_times(r, len(states)), r.label)
            for states, r in zip(arrays, recordings, strict=True)
        ]
        self._keep(tuple(items), names, space)

    @classmethod
    def load(
        cls,
        path: str | PathLike[str] | Sequence[str | PathLike[str]],
        space: StateSpace | None = None,
        *,
        moving: bool = True,
    ) -> Self:
        """Read recordings from a CSV or NPZ file, a folder of them (in order of name), or a list of these.

        CSV files have a header. A column `t` or `time` holds seconds, a column `demo` tells several
        recordings in one file apart; all others are coordinates. A quaternion whose names are qw, qx, qy and
        qz in another order, such as scalar last, is reordered to scalar first; `names` tells the new order.
        NPZ files hold `states`, (n_demos, n_steps, n_dims), or `states_0`, `states_1`, …, and optionally
        `times` or `times_0`, …, and `names`.

        Args:
            path: file, folder, or list of them.
            space: what the coordinates are, instead of what the names or the file tell.
            moving: whether each must have two samples at least, and move. Keyframes need not.

        Raises:
            RecordingError: names the file, row, column and value.
        """
        # Readers of files stand above this module, which knows no format: imported only when asked for.
        from skillfold.io.recording_files import read

        return cls.of(*read(path, space, moving))

    def save(self, path: str | PathLike[str]) -> None:
        """Write one file: `.npz` (every bit, and the space) or `.csv` with a `demo` column.

        Raises:
            RecordingError: unknown suffix, a folder that is not there, names a CSV cannot keep apart.
        """
        from skillfold.io.recording_files import write

        write(path, [(d.label, d.states, d.times) for d in self.items], self.names, self.space)

    def __len__(self) -> int:
        return len(self.items)

    def __iter__(self) -> Iterator[Demonstration]:
        return iter(self.items)

    def __getitem__(self, i: int) -> Demonstration:
        return self.items[i]

    def __repr__(self) -> str:
        steps = "–".join(str(n) for n in sorted({self.lengths.min(), self.lengths.max()}))
        timed = "no times" if any(d.times is None for d in self) else "timed"
        return f"Demonstrations({len(self)} of {steps} states, {', '.join(self.names)}; {self.space!r}, {timed})"

    @property
    def n_dims(self) -> int:
        """Number of coordinates D."""
        return self.space.n_dims

    @property
    def states(self) -> Array:
        """(N, D) samples of all demonstrations, one after the other."""
        return np.concatenate([d.states for d in self.items])

    @property
    def lengths(self) -> np.ndarray[Any, np.dtype[np.intp]]:
        """(n_demos,) number of samples of each."""
        return np.array([len(d) for d in self.items])

    @property
    def ends(self) -> Array:
        """(n_demos, 2, D) first and last state of each."""
        return np.array([d.states[[0, -1]] for d in self.items])

    @property
    def radius(self) -> float:
        """Root mean square distance of all samples from their mean: the size of the skill."""
        states = self.states
        return float(np.sqrt(((states - states.mean(axis=0)) ** 2).sum(axis=1).mean()))

    def resample(self, n_steps: int, by: str = "arc length") -> Self:
        """The same paths at `n_steps` samples each, evenly spaced in length or in time; ends exactly kept.

        States are interpolated linearly, quaternions then brought back to unit length.

        Args:
            n_steps: two at least.
            by: "arc length" or "time".

        Raises:
            InputError: `by="time"` without times; another `by`.
        """
        if by not in ("arc length", "time"):
            raise InputError(f"by={by!r}; possible: 'arc length', 'time'.")
        if isinstance(n_steps, bool) or not isinstance(n_steps, int | np.integer) or n_steps < 2:
            raise InputError(f"n_steps={n_steps!r}; expected a whole number, two at least.")
        along = [self._times(d, "by='time'") if by == "time" else alignment.progress(d.states) for d in self]
        pairs = [alignment.resampled(d.states, d.times, s, n_steps) for d, s in zip(self, along, strict=True)]
        return self._derived([s for s, _ in pairs], [t for _, t in pairs], self.names, self.space)

    def align(self, reference: int = 0) -> Self:
        """All demonstrations at the pace of one of them, by dynamic time warping: as many steps, its times.

        Raises:
            InputError: no such demonstration.
            MissingExtraError: the extra `dtw` is not installed.
        """
        target = self.items[self._index(reference)]
        states = [d.states if d is target else alignment.warped(d.states, target.states) for d in self]
        return self._derived(states, [target.times] * len(self), self.names, self.space)

    def with_velocity(self) -> Self:
        """States with their velocities appended: coordinates `<name>_velocity`, per second, linear.

        Raises:
            InputError: a demonstration without times.
        """
        rates = [alignment.velocities(d.states, self._times(d, "with_velocity()")) for d in self]
        states = [np.hstack([d.states, v]) for d, v in zip(self, rates, strict=True)]
        names = self.names + tuple(f"{name}_velocity" for name in self.names)
        space = self.space + StateSpace.linear(self.n_dims)
        return self._derived(states, [d.times for d in self], names, space)

    def with_phase(self, scale: float | None = None) -> Self:
        """States with their progress appended: coordinate `phase`, 0 to `scale` along the path's length.

        Strokes that cross each other lie apart then.

        Args:
            scale: phase at the end, in units of the states; three times `radius` when left out.

        Raises:
            InputError: a scale that is not a positive number.
        """
        scale = PHASE_SCALE * self.radius if scale is None else scale
        scale = float(scale) if isinstance(scale, np.floating) else scale
        if not isinstance(scale, int | float | np.integer) or not 0 < scale < LARGEST:
            raise InputError(f"scale={scale!r}; expected a positive number.")
        states = [np.column_stack([d.states, scale * alignment.progress(d.states)]) for d in self]
        space = self.space + StateSpace.linear(1)
        return self._derived(states, [d.times for d in self], (*self.names, "phase"), space)

    def crossings(self) -> list[Crossing]:
        """Where demonstrations cross their own path, with two passes in clearly different directions.

        There the positions alone are no manifold; `with_phase()` or `with_velocity()` parts the strokes.
        """
        return [crossing for i, d in enumerate(self) for crossing in crossings(d.states, i)]

    def select(self, columns: Sequence[str | int]) -> Self:
        """Only some coordinates, by name or index, in the order given; quaternions only as a whole.

        Raises:
            InputError: unknown column, a part of a quaternion.
        """
        chosen = [self._column(c) for c in ([columns] if isinstance(columns, str) else columns)]
        names = tuple(self.names[i] for i in chosen)
        states = [d.states[:, chosen] for d in self]
        return self._derived(states, [d.times for d in self], names, self.space.select(chosen))

    def leave_out(self, i: int) -> Self:
        """All demonstrations but the `i`th.

        Raises:
            InputError: no such demonstration, or the only one.
        """
        i = self._index(i)
        if len(self) == 1:
            raise InputError("leave_out: there is only one demonstration.")
        made = type(self).__new__(type(self))
        made._keep(self.items[:i] + self.items[i + 1 :], self.names, self.space)
        return made

    def _keep(self, items: tuple[Demonstration, ...], names: tuple[str, ...], space: StateSpace) -> None:
        for name, value in (("items", items), ("names", names), ("space", space)):
            object.__setattr__(self, name, value)

    def _derived(
        self, states: list[Array], times: Sequence[Array | None], names: tuple[str, ...], space: StateSpace
    ) -> Self:
        parts = [
            Recording(space.normalize(s) if np.isfinite(s).all() else s, t, d.label, f"demonstration '{d.label}'")
            for d, s, t in zip(self, states, times, strict=True)
        ]
        return self.of(parts, names, space)

    def _times(self, d: Demonstration, user: str) -> Array:
        if d.times is None:
            raise InputError(
                f"{user} needs times, and demonstration '{d.label}' has none: give times=... (seconds), "
                "such as np.arange(n_steps) / rate."
            )
        return d.times

    def _index(self, i: Any) -> int:
        if isinstance(i, bool) or not isinstance(i, int | np.integer) or not -len(self) <= i < len(self):
            raise InputError(f"No demonstration {i!r}; there are {len(self)}, counted from 0.")
        return int(i) % len(self)

    def _column(self, column: Any) -> int:
        if isinstance(column, str) and column in self.names:
            return self.names.index(column)
        if isinstance(column, int | np.integer) and 0 <= column < self.n_dims:
            return int(column)
        raise InputError(f"No column {column!r}; possible: {', '.join(self.names)}.")
