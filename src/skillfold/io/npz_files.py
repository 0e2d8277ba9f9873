"""NPZ files of recordings: `states` or `states_0`, `states_1`, …, with times, names, labels and the space."""

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from skillfold.errors import RecordingError, SkillFileError
from skillfold.recordings import Recording
from skillfold.spaces import StateSpace

_ENTRY = re.compile(r"(states|times)(?:_(\d{1,9}))?|names|labels|space")
_ENTRIES = "states or states_0, states_1, …; times or times_0, times_1, …; names; labels; space"


def read_npz(path: Path) -> tuple[list[Recording], tuple[str, ...] | None, StateSpace | None]:
    """Recordings of one file, the names of the coordinates and the space, where it tells them.

    Raises:
        RecordingError: names the file and what is wrong with it.
    """
    entries = _entries(path)
    unknown = [name for name in entries if not _ENTRY.fullmatch(name)]
    if unknown:
        raise RecordingError(f"{path}: unknown entry {unknown[0]!r}; possible: {_ENTRIES}.")
    states, keys = _series(entries, path)
    times = _times(entries, keys, states, path)
    labels = _words(entries, "labels", path) or _labels(path, len(states))
    if len(labels) != len(states):
        raise RecordingError(f"{path}: {len(labels)} labels for {len(states)} recordings.")
    recordings = [
        Recording(s, t, label, str(path) if len(states) == 1 else f"{path}, {_title(keys, i)}")
        for i, (s, t, label) in enumerate(zip(states, times, labels, strict=True))
    ]
    return recordings, _words(entries, "names", path), _space(entries, path)


def _entries(path: Path) -> dict[str, Any]:
    try:
        # Never a pickle: it could run anything.
        with path.open("rb") as stream:
            file = np.load(stream, allow_pickle=False)
            if not isinstance(file, np.lib.npyio.NpzFile):
                raise RecordingError(f"{path}: a single array; expected an NPZ with {_ENTRIES}.")
            return {name: np.asarray(file[name]) for name in file.files}
    except RecordingError:
        raise
    except Exception as error:  # zip, zlib and the header's parser raise a dozen kinds on damaged files
        raise RecordingError(
            f"{path}: no NPZ of plain numbers, or damaged or truncated ({type(error).__name__}: {error})."
        ) from None


def _series(entries: dict[str, Any], path: Path) -> tuple[list[Any], list[str]]:
    """The states of each recording and the keys they came under ('' for the one array of all)."""
    numbered = sorted((k for k in entries if k.startswith("states_")), key=lambda k: int(k[7:]))
    if numbered and "states" in entries:
        raise RecordingError(f"{path}: both 'states' and '{numbered[0]}'; expected one or the other.")
    if numbered:
        return [entries[key] for key in numbered], [key[7:] for key in numbered]
    if "states" not in entries:
        raise RecordingError(f"{path}: no states (entries: {', '.join(entries) or 'none'}); expected {_ENTRIES}.")
    states = entries["states"]
    if states.ndim not in (2, 3) or (states.ndim == 3 and len(states) == 0):
        raise RecordingError(
            f"{path}: states of shape {states.shape}; expected (n_demos, n_steps, n_dims) or one (n_steps, n_dims)."
        )
    parts = [states] if states.ndim == 2 else list(states)
    return parts, [""] * len(parts)


def _times(entries: dict[str, Any], keys: list[str], states: list[Any], path: Path) -> list[Any]:
    numbered = {k for k in entries if k.startswith("times_")}
    stray = numbered - {f"times_{key}" for key in keys if key}
    if stray or (numbered and "times" in entries):
        raise RecordingError(f"{path}: '{min(numbered)}' does not belong to any states_….")
    if "times" not in entries:
        return [entries.get(f"times_{key}") for key in keys]
    times = entries["times"]
    if times.ndim == 1:
        return [times] * len(states)
    if times.ndim == 0 or len(times) != len(states):
        raise RecordingError(f"{path}: times of shape {times.shape} for {len(states)} recordings.")
    return list(times)


def _words(entries: dict[str, Any], key: str, path: Path) -> tuple[str, ...] | None:
    if key not in entries:
        return None
    words = entries[key]
    if words.ndim != 1 or words.dtype.kind != "U":
        raise RecordingError(f"{path}: {key} of shape {words.shape}, {words.dtype}; expected a list of text.")
    return tuple(words.tolist())


def _labels(path: Path, n: int) -> tuple[str, ...]:
    return (path.stem,) if n == 1 else tuple(f"{path.stem}:{i}" for i in range(n))


def _title(keys: list[str], i: int) -> str:
    return f"states_{keys[i]}" if keys[i] else f"states[{i}]"


def _space(entries: dict[str, Any], path: Path) -> StateSpace | None:
    if "space" not in entries:
        return None
    try:
        return StateSpace.from_json(json.loads(str(entries["space"])))
    except (ValueError, RecursionError, SkillFileError) as error:
        raise RecordingError(f"{path}, space: {error}") from None


def write_npz(
    path: Path, recordings: Sequence[tuple[str, Any, Any]], names: tuple[str, ...], space: StateSpace
) -> None:
    """Write (label, states, times) of each recording, to be read back bit by bit."""
    entries = {f"states_{i}": states for i, (_, states, _) in enumerate(recordings)}
    entries |= {f"times_{i}": times for i, (_, _, times) in enumerate(recordings) if times is not None}
    labels = np.array([label for label, _, _ in recordings])
    text = np.array(json.dumps(space.to_json()))
    with path.open("wb") as stream:  # given a name, NumPy would add a suffix to .NPZ
        np.savez_compressed(stream, **entries, names=np.array(names), labels=labels, space=text)  # type: ignore[arg-type]
