"""One recording: as it was given, the checks it must pass, and the demonstration it becomes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.errors import RecordingError

Array = np.ndarray[Any, np.dtype[np.float64]]

# Squares and products of anything larger would overflow in the distances.
LARGEST = 1e100
# A recording that moves less than this part of its own values stands still but for rounding.
_STILL = 1e-12


@dataclass(frozen=True)
class Recording:
    """What someone handed in as one recording, before any check.

    Attributes:
        states: anything that should be (n_steps, n_dims) numbers.
        times: anything that should be (n_steps,) seconds, or None.
        label: its name among the demonstrations.
        place: the file or demonstration it came from, for messages.
        rows: the row of each sample in the file, where it came from a file with rows.
        moving: whether it must have two samples at least, and move; keyframes need not.
    """

    states: Any
    times: Any
    label: str
    place: str
    rows: Sequence[int] | None = None
    moving: bool = True

    def at(self, row: int, column: str | int | None = None) -> str:
        """Where a value stands, in words."""
        where = f"row {self.rows[row]}" if self.rows is not None else f"row {row} (counted from 0)"
        return f"{self.place}, {where}" + ("" if column is None else f", column '{column}'")


@dataclass(frozen=True, eq=False)
class Demonstration:
    """One recording of a skill.

    Attributes:
        states: (n_steps, n_dims), quaternions of unit length, consistent along the recording; read-only.
        times: (n_steps,) seconds, increasing; or None.
        label: its name.
    """

    states: Array
    times: Array | None = None
    label: str = "0"

    def __post_init__(self) -> None:
        for name in ("states", "times"):
            if (values := getattr(self, name)) is not None:
                array = np.array(values, dtype=np.float64)
                array.flags.writeable = False
                object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.states)

    def __repr__(self) -> str:
        n, dims = self.states.shape
        timed = "" if self.times is None else f", {self.times[-1] - self.times[0]:.4g} s"
        return f"Demonstration({self.label!r}: {n} states of {dims} coordinates{timed})"


def as_numbers(values: Any, place: str, ndim: int, expected: str) -> Array:
    """`values` as a float array of `ndim` dimensions; `expected` says in words what its shape should be.

    Raises:
        RecordingError: text, objects, complex or masked values, ragged rows, another number of dimensions.
    """
    try:
        raw = np.asarray(values)
    except (TypeError, ValueError):
        raise RecordingError(f"{place}: {_ragged(values)}; expected {expected}.") from None
    if raw.ndim != ndim:
        raise RecordingError(f"{place}: got an array of shape {raw.shape}; expected {expected}.")
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise RecordingError(f"{place}: some values are masked; expected every value, or fewer rows.")
    if raw.dtype.kind in "iuf":
        with np.errstate(over="ignore"):  # wider floats may become infinite, which is caught as such
            return np.array(raw, dtype=np.float64)
    return np.array([_number(v, place, i) for i, v in np.ndenumerate(raw)]).reshape(raw.shape)


def _ragged(values: Any) -> str:
    """In words, the first row whose length is not that of row 0."""
    lengths = [len(row) if hasattr(row, "__len__") else 0 for row in values]
    row = next((i for i, n in enumerate(lengths) if n != lengths[0]), None)
    if row is None:
        return "no array of numbers"
    return f"row {row} (counted from 0) has {lengths[row]} values, row 0 has {lengths[0]}"


def _number(value: Any, place: str, index: tuple[int, ...]) -> float:
    value = value.item() if isinstance(value, np.generic) else value  # plainer in the message
    where = ", ".join(f"{axis} {i}" for axis, i in zip(("row", "column"), index, strict=False))
    try:
        if isinstance(value, int | float) and not isinstance(value, bool):
            return float(value)
    except (TypeError, ValueError, OverflowError):
        pass
    raise RecordingError(f"{place}, {where} (counted from 0): value {shortened(value)}; expected a number.")


def checked_states(recording: Recording, names: tuple[str, ...]) -> Array:
    """(n_steps, n_dims) states of a recording: finite, at least two of them, and moving where they must.

    Raises:
        RecordingError: names the place, row, column and value.
    """
    columns = f"(n_steps, {len(names)})" if names else "(n_steps, n_dims)"
    expected = f"{columns} numbers; one coordinate is a column too: x[:, None]"
    states = as_numbers(recording.states, recording.place, 2, expected)
    if names and states.shape[1] != len(names):
        raise RecordingError(
            f"{recording.place}: {states.shape[1]} columns; expected {len(names)}: {', '.join(names)}."
        )
    if states.shape[1] == 0:
        raise RecordingError(f"{recording.place}: no coordinates; expected {expected}.")
    if len(states) < 1 + recording.moving:
        least = "two" if recording.moving else "one"
        raise RecordingError(f"{recording.place}: {len(states)} samples; expected {least} at least.")
    check_finite(states, recording, names)
    if recording.moving:
        _check_moving(states, recording)
    return states


def check_finite(states: Array, recording: Recording, names: tuple[str, ...]) -> None:
    """Raise a `RecordingError` at the first value that is no usable number."""
    bad = np.argwhere(~(np.abs(states) < LARGEST))
    if not len(bad):
        return
    row, column = (int(i) for i in bad[0])
    raise RecordingError(
        f"{recording.at(row, names[column] if names else column)}: value {states[row, column]:g}; "
        f"expected a finite number below {LARGEST:g} in size ({len(bad)} such in this recording)."
    )


def _check_moving(states: Array, recording: Recording) -> None:
    moved, size = np.ptp(states, axis=0).max(), np.abs(states).max()
    if moved <= max(_STILL * size, 1 / LARGEST):
        raise RecordingError(
            f"{recording.place}: nothing moves; all {len(states)} samples are {states[0].tolist()}; "
            "expected a motion."
        )


def checked_times(recording: Recording, n_steps: int) -> Array | None:
    """(n_steps,) strictly increasing times, or None where the recording has none.

    Raises:
        RecordingError: names the place, row and value.
    """
    if recording.times is None:
        return None
    place = f"{recording.place}, times"
    times = as_numbers(recording.times, place, 1, f"({n_steps},) seconds")
    if len(times) != n_steps:
        raise RecordingError(f"{place}: {len(times)} times for {n_steps} states; expected one for each.")
    bad = np.flatnonzero(~(np.abs(times) < LARGEST))
    if len(bad):
        raise RecordingError(f"{recording.at(int(bad[0]), 'time')}: value {times[bad[0]]:g}; expected seconds.")
    late = np.flatnonzero(np.diff(times) <= 0)
    if len(late):
        row = int(late[0]) + 1
        raise RecordingError(
            f"{recording.at(row, 'time')}: value {times[row]:.12g} after {times[row - 1]:.12g}; "
            "expected times that increase from row to row."
        )
    return times


def check_words(words: Sequence[Any], what: str, place: str) -> tuple[str, ...]:
    """`words` (column names, labels) as printable, non-empty, distinct text.

    Raises:
        RecordingError: names the word.
    """
    seen: set[str] = set()
    for i, word in enumerate(words):
        if not isinstance(word, str) or not word.isprintable() or not word or word != word.strip():
            raise RecordingError(
                f"{place}: {what} {i + 1} is {word!r}; expected printable text without blanks around it."
            )
        if word in seen:
            raise RecordingError(f"{place}: {what} {word!r} appears twice; expected different ones.")
        seen.add(word)
    return tuple(str(word) for word in words)


def given(recordings: Any, times: Any, labels: Any) -> list[Recording]:
    """What the constructor of `Demonstrations` is handed, as one `Recording` each."""
    recordings = plain(recordings)
    parts = _parts(recordings)
    if not parts:
        raise RecordingError("No recordings; expected one at least.")
    clocks = _clocks(times, len(parts), isinstance(recordings, list | tuple) or np.ndim(recordings) == 3)
    labels = [str(i) for i in range(len(parts))] if labels is None else _one_each(labels, len(parts), "labels")
    return [
        Recording(states, clock, label, f"demonstration '{label}'")
        for states, clock, label in zip(parts, clocks, labels, strict=True)
    ]


def plain(recordings: Any) -> Any:
    """A table or tensor of another library as the NumPy array it gives; all else as it is."""
    foreign = hasattr(recordings, "__array__") and not isinstance(recordings, np.ndarray)
    return np.asarray(recordings) if foreign else recordings


def _parts(recordings: Any) -> list[Any]:
    if isinstance(recordings, list | tuple):
        return list(recordings)
    if getattr(recordings, "ndim", None) == 2:
        return [recordings]
    if getattr(recordings, "ndim", None) == 3:
        return list(recordings)
    raise RecordingError(
        f"Recordings: got {shortened(recordings)}; expected an array (n_steps, n_dims), a list of "
        "these, or an array (n_demos, n_steps, n_dims). Files are read by Demonstrations.load(path)."
    )


def _clocks(times: Any, n: int, several: bool) -> list[Any]:
    if times is None:
        return [None] * n
    if not hasattr(times, "__len__") or isinstance(times, str | bytes):
        raise RecordingError(f"times: got {shortened(times)}; expected seconds, one for each state.")
    shared = len(times) > 0 and not any(t is None or hasattr(t, "__len__") for t in times)
    return [times] * n if shared or not several else _one_each(times, n, "times")


def _one_each(values: Any, n: int, what: str) -> list[Any]:
    if isinstance(values, str) or not hasattr(values, "__len__") or len(values) != n:
        raise RecordingError(f"{what}: expected one for each of the {n} recordings, got {shortened(values)}.")
    return list(values)


def shortened(value: Any) -> str:
    """`repr` of what was given, in one line, cut where it is long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."
