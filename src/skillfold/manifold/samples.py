"""What was given to `fit`, made into samples: whole recordings at even steps, or a cloud without order."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from skillfold.demonstrations import Demonstrations
from skillfold.errors import InputError
from skillfold.spaces import StateSpace

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

STEPS = 200  # at most, of each recording
TOTAL = 2000  # at most, of all recordings, while each keeps FEWEST
FEWEST = 50
SPARE = 3  # distinct states more than coordinates that are needed
SAME = 1e-9  # of their extent: states that are nearer each other are one


@dataclass(frozen=True)
class Samples:
    """Samples to learn from.

    Attributes:
        states: (N, D), distinct.
        groups: (N,) recording of each; None for a cloud, and where only one recording has samples of its own.
        recordings: as given, each (n_steps, D); empty for a cloud.
        space, names: of the coordinates.
        count: samples before resampling.
        notes: what the user should know.
    """

    states: Array
    groups: Indices | None
    recordings: tuple[Array, ...]
    space: StateSpace
    names: tuple[str, ...]
    count: int
    notes: tuple[str, ...]


def read_samples(demos: Demonstrations | Array | Sequence[Array], space: StateSpace | None) -> Samples:
    """Check what was given and make samples of it."""
    if isinstance(demos, Demonstrations):
        if space is not None and space != demos.space:
            raise InputError("space: the Demonstrations have one already; build them with the space wanted.")
        return _of_recordings(demos)
    if isinstance(demos, np.ndarray) and demos.ndim == 2:
        return _of_cloud(Demonstrations(demos, space=space))
    return _of_recordings(Demonstrations(demos, space=space))


def _of_cloud(demos: Demonstrations) -> Samples:
    return Samples(demos.states[distinct(demos.states)], None, (), demos.space, demos.names, len(demos.states), ())


def _of_recordings(demos: Demonstrations) -> Samples:
    steps = max(FEWEST, min(STEPS, TOTAL // len(demos)))
    even = demos.resample(steps)
    groups = np.repeat(np.arange(len(demos)), steps)
    states, groups = told_apart(even.states, groups)
    recordings = tuple(d.states for d in demos)
    notes = _crossing_notes(demos)
    return Samples(
        states,
        groups,
        recordings,
        demos.space,
        demos.names,
        len(demos.states),
        notes,
    )


def told_apart(states: Array, groups: Indices | None) -> tuple[Array, Indices | None]:
    """Distinct states, and their recordings unless one is left: of one given twice nothing is, the second time."""
    rows = distinct(states)
    left = groups[rows] if groups is not None else None
    return states[rows], left if left is not None and left[0] != left[-1] else None


def distinct(states: Array) -> Indices:
    """Rows that appear for the first time, in their order; what rounding has moved apart is the same.

    Sorted by value they would come in another order in another frame, and the same seed choose others among them.
    """
    offsets = states - states[0]
    cells = np.round(offsets / max(SAME * float(np.abs(offsets).max()), 1e-300))
    rows = np.sort(np.unique(cells, axis=0, return_index=True)[1])
    return np.delete(rows, _side_by_side(cells[rows])[:, 1])  # between two cells rounding decides for either


def _side_by_side(cells: Array) -> Indices:
    """Pairs of rows of whole numbers (n, D) that differ by one at most in each, the earlier first; (m, 2)."""
    weights = np.sqrt(np.arange(2.0, 2.0 + cells.shape[1]))  # a sum by which hardly any others come near each other
    along = cells @ weights
    order = np.argsort(along)
    near = np.diff(along[order]) <= weights.sum()
    some = np.sort(order[np.append(near, False) | np.append(False, near)])
    return some[KDTree(cells[some]).query_pairs(1.0, np.inf, output_type="ndarray")]


def _crossing_notes(demos: Demonstrations) -> tuple[str, ...]:
    crossings = demos.crossings()
    if not crossings:
        return ()
    first = crossings[0]
    label = demos[first.demonstration].label
    return (
        f"Demonstration {label} crosses its own path near row {first.rows[0]} and again near row {first.rows[1]} "
        f"({len(crossings)} crossings in all): there, positions alone are no manifold. "
        "Demonstrations.with_phase() or with_velocity() parts the strokes.",
    )
