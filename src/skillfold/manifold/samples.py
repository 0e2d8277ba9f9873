"""What was given to `fit`, made into samples: whole recordings at even steps, or a cloud without order."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from skillfold.demonstrations import Demonstrations
from skillfold.errors import InputError
from skillfold.recordings import plain
from skillfold.spaces import TURN, StateSpace

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

STEPS = 200  # at most, of each recording
TOTAL = 2000  # at most, of all recordings, while each keeps FEWEST
FEWEST = 50
SPARE = 3  # distinct states more than coordinates that are needed
STRAY = 1e3  # times as far from the middle as is usual: a slip, most likely
SAME = 1e-9  # of their extent: states that are nearer each other are one
REST = 0.1  # of a recording, relative to others: with less left than that, it is one of the others given again
MOST = 20_000  # states of a cloud among which crowds are looked for
LOOKED_AT, CROWD = 30, 200  # of them, and how many the largest crowd may have
APART = 30.0  # times as far as to the others of its crowd it is from a state to the next crowd
WITHIN = 3.0  # times that far the widest crowd reaches


@dataclass(frozen=True)
class Samples:
    """Samples to learn from.

    Attributes:
        states: (N, D), distinct.
        groups: (N,) recording of each, or crowd where they stand in crowds; None for a cloud without, and where only
            one recording has samples of its own.
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
    demos = plain(demos)
    if isinstance(demos, Demonstrations):
        if space is not None and space != demos.space:
            raise InputError("space: the Demonstrations have one already; build them with the space wanted.")
        return _of_recordings(demos)
    if isinstance(demos, np.ndarray) and demos.ndim == 2:
        return _of_cloud(Demonstrations(demos, space=space))
    return _of_recordings(Demonstrations(demos, space=space))


def _of_cloud(demos: Demonstrations) -> Samples:
    states, groups = told_apart(side_by_side(demos.states, demos.space), None)
    return Samples(states, groups, (), demos.space, demos.names, len(demos.states), _stray_notes(demos))


def side_by_side(states: Array, space: StateSpace) -> Array:
    """States (N, D) without order, written near each other: none follows the one before. The first stays as it is.

    Angles are cut where the widest gap is, quaternions across their mean.
    """
    out = states.copy()
    for i in (i for i, kind in enumerate(space.kinds) if kind == "continuous"):
        places = np.sort(states[:, i] % TURN)
        gaps = np.diff(places, append=places[0] + TURN)
        cut = places[gaps.argmax()] + 0.5 * gaps.max()
        turns = np.floor((states[:, i] - cut) / TURN)
        out[:, i] -= TURN * (turns - turns[0])
    for columns in space.quaternions:
        along = states[:, columns] @ np.linalg.eigh(states[:, columns].T @ states[:, columns])[1][:, -1]
        out[:, columns] *= np.where(along * along[0] < 0.0, -1.0, 1.0)[:, None]
    return out


def _of_recordings(demos: Demonstrations) -> Samples:
    steps = max(FEWEST, min(STEPS, TOTAL // len(demos)))
    even = demos.resample(steps)
    groups = np.repeat(np.arange(len(demos)), steps)
    states, groups = told_apart(even.states, groups)
    recordings = tuple(d.states for d in demos)
    notes = _shape_notes(demos) + _stray_notes(demos) + _crossing_notes(demos)
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
    """Distinct states, and what to leave out together: crowds, or recordings unless one is left.

    Of a recording given twice nothing is, the second time, or so little that it does not count.
    """
    rows = distinct(states)
    if groups is not None:
        share = np.bincount(groups[rows], minlength=groups.max() + 1) / np.maximum(np.bincount(groups), 1)
        rows = rows[share[groups[rows]] > REST * share.max()]
        groups = groups[rows] if groups[rows[0]] != groups[rows[-1]] else None
    crowd = crowds(states[rows])
    return states[rows], groups if crowd is None else crowd


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


def crowds(states: Array) -> Indices | None:
    """Which crowd each of (N, D) belongs to, where most stand in crowds about places far from each other; else None.

    A pose that was held while states were taken gives such crowds, and so does a motion that a robot repeats in the
    same steps. In a crowd states predict each other far better than anything is known from place to place.
    """
    k = min(CROWD, len(states) - 1)
    if k < 2 or len(states) > MOST:
        return None
    some = states[np.linspace(0, len(states) - 1, min(len(states), LOOKED_AT)).astype(int)]
    squares = np.partition(np.asarray(cdist(some, states, "sqeuclidean"), np.float64), k, axis=1)
    nearest = np.sqrt(np.sort(squares[:, : k + 1], axis=1)[:, 1:])
    steps = nearest[:, 1:] / nearest[:, :-1]
    if np.median(steps.max(1)) <= APART:
        return None
    reach = WITHIN * float(np.median(nearest[np.arange(len(some)), steps.argmax(1)]))
    pairs = KDTree(states).query_pairs(reach, output_type="ndarray")
    joined = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(states), len(states)))
    count, crowd = connected_components(joined, directed=False)
    return crowd.astype(np.int64) if count >= len(states) / count else None  # few large ones are parts of the data


def _shape_notes(demos: Demonstrations) -> tuple[str, ...]:
    """An array on its side is a motion of a few states in a space of very many coordinates."""
    longest = int(demos.lengths.max())
    if longest >= demos.n_dims:
        return ()
    return (
        f"Recordings of {longest} states at most have {demos.n_dims} coordinates: rows are states, columns are "
        "coordinates. Is x.T meant?",
    )


def _stray_notes(demos: Demonstrations) -> tuple[str, ...]:
    """One slip of a decimal point or a unit, and all the rest looks like a single place."""
    middle = np.median(demos.states, axis=0)
    away = [np.linalg.norm(demo.states - middle, axis=1) for demo in demos]
    usual = float(np.median(np.concatenate(away)))
    notes = []
    for demo, distances in zip(demos, away, strict=True):
        row = int(distances.argmax())
        if distances[row] > STRAY * usual > 0.0:
            notes.append(
                f"Demonstration {demo.label}, row {row}, lies {distances[row]:.3g} from the middle of all states, "
                f"{distances[row] / usual:.3g} times as far as is usual: a slip? What is learnt is of that size."
            )
    return tuple(notes)


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
