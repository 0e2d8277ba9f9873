"""Position and orientation together, which section VIII of paper 000 left out: a manifold and primitives of poses."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skillfold.baselines.dmp import Primitive
from skillfold.demonstrations import Demonstrations
from skillfold.errors import MissingExtraError
from skillfold.experiments.pick_place import Make, Method, at_rest, planned
from skillfold.experiments.pick_place_sets import (
    LARGE,
    POINTS,
    START,
    MotionSet,
    cube,
    shape_distance,
    shape_distances,
    turns_along,
)
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array

NAMES = ("x", "y", "z", "qw", "qx", "qy", "qz")
PLACE, ANGLE = 0.01, 0.02  # of the way from start to goal, and radians: near enough to the goal
TURNED = 0.15  # radians, per axis, by which starts are turned besides

Judged = tuple[int, float, float, float, float, float]
"""Poses reached; shapes of places and turns; places and turns of what was left out; orientations [rad]."""


def pose_rows(sets: list[MotionSet], settings: Settings) -> list[Row]:
    """Poses from the places of the large cube, turned a little, to the goal, of every set with orientations."""
    settings.progress("pick and place: poses", 0.85)
    rng = np.random.default_rng([settings.seed, 1])
    return [row for motions in sets if motions.orientations for row in set_rows(motions, settings, rng)]


def set_rows(motions: MotionSet, settings: Settings, rng: np.random.Generator) -> list[Row]:
    """What is reached, and how far places and turns are from the recordings', and from one that was not shown."""
    recordings = [np.hstack(pair) for pair in zip(motions.recordings, motions.orientations, strict=True)]
    scale = motions.reach / float(np.linalg.norm(START))
    starts = _starts(recordings[0][0], LARGE * scale, rng)

    def skill(shown: Sequence[Array]) -> Method:
        return planned(settings.learn(Demonstrations(list(shown), names=NAMES)))

    def primitive(shown: Sequence[Array]) -> Method:
        return Primitive.fit_poses(at_rest(motions, shown)).paths

    ours, rivals, missing = _judged(motions, recordings, skill, starts), None, ""
    try:
        rivals = _judged(motions, recordings, primitive, starts)
    except MissingExtraError as error:
        missing = str(error)
    return _rows(f"{motions.name}, poses", ours, rivals, missing, len(starts))


def _rows(head: str, ours: Judged, rivals: Judged | None, missing: str, count: int) -> list[Row]:
    words = (
        ("shape distance from the recordings", "", True),
        ("turn's shape off the recordings", "rad", True),
        ("shape distance from a recording left out", "", True),
        ("orientation off a recording left out", "rad", True),
        ("orientation off the recordings", "rad", False),  # offsets count: the demonstrators' own are no less off
    )
    notes = [f"DMP {value:.3g}" for value in rivals] if rivals else [missing] * len(ours)
    rows = [Row(f"{head}: reached", ours[0], f"of {count}", count, ">=", "left out", notes[0])]
    for k, (name, unit, judged) in enumerate(words, 1):
        target = rivals[k] if rivals and judged else None
        rows.append(Row(f"{head}: {name}", ours[k], unit, target, "<", "left out", notes[k]))
    return rows


def _judged(motions: MotionSet, recordings: list[Array], make: Make, starts: Array) -> Judged:
    """How many poses are reached, and what stands in the rows, in their order."""
    goal = recordings[0][-1]
    paths = make(recordings)(starts, np.broadcast_to(goal, starts.shape))
    near = [np.linalg.norm(path[-1, :3] - goal[:3]) <= PLACE * motions.reach for path in paths]
    turned = [angles(path[-1:, 3:], goal[None, 3:])[0] <= ANGLE for path in paths]
    shape = np.mean([shape_distances(path[:, :3], motions.recordings)[0] for path in paths])
    turn = np.mean([turn_distance(path, recordings) for path in paths])
    off = np.mean([_off(path, recordings) for path in paths])
    unseen = np.mean(_unseen(motions, recordings, make), axis=0)
    return int(np.sum(np.logical_and(near, turned))), float(shape), float(turn), *unseen.tolist(), float(off)


def _unseen(motions: MotionSet, recordings: list[Array], make: Make) -> Array:
    """How far a motion learnt from the other recordings is from each: shapes of places, and orientations; (n, 2)."""
    found = []
    for i, recording in enumerate(recordings):
        method = make([other for j, other in enumerate(recordings) if j != i])
        path = method(recording[:1], recording[-1:])[0]
        found.append((shape_distance(path[:, :3], recording[:, :3], motions.recordings), _off(path, [recording])))
    return np.array(found)


def turn_distance(path: Array, recordings: list[Array]) -> float:
    """How far the shape of a path's turn is from those of all recordings [rad, rms].

    As for places, shape is what is left without the even turn between its own ends: how a path is turned where it
    begins and ends does not count. An even turn has none, so there is no size to measure it by.
    """
    gaps = [((_turn_shape(recording) - _turn_shape(path)) ** 2).sum(1).mean() for recording in recordings]
    return float(np.sqrt(np.mean(gaps)))


def _turn_shape(path: Array) -> Array:
    """Rotation vectors (POINTS, 3) from the even turn between a path's ends to its orientations."""
    from scipy.spatial.transform import Rotation, Slerp

    found = turns_along(path)
    turns, ends = (Rotation.from_quat(q, scalar_first=True) for q in (found, found[[0, -1]]))
    even = Slerp([0.0, 1.0], ends)(np.linspace(0.0, 1.0, POINTS))
    return (turns * even.inv()).as_rotvec()


def _starts(pose: Array, half: float, rng: np.random.Generator) -> Array:
    """Poses (27, 7) about one: the places of a cube, each turned a little."""
    from scipy.spatial.transform import Rotation

    places = cube(pose[:3], half)
    turns = Rotation.from_quat(pose[3:], scalar_first=True) * Rotation.from_rotvec(
        TURNED * rng.standard_normal((len(places), 3))
    )
    quaternions = turns.as_quat(scalar_first=True)
    return np.hstack([places, quaternions * np.sign(quaternions @ pose[3:])[:, None]])


def _off(path: Array, recordings: list[Array]) -> float:
    """Mean angle between a path's orientations and those of all recordings at equal shares of the way [rad]."""
    mine = turns_along(path)
    return float(np.mean([angles(mine, turns_along(recording)) for recording in recordings]))


def angles(a: Array, b: Array) -> Any:
    """Angles (n,) between rotations (n, 4) and (n, 4)."""
    return 2.0 * np.arccos(np.clip(np.abs((a * b).sum(1)), 0.0, 1.0))
