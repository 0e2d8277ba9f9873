"""Position and orientation together, which section VIII of paper 000 left out: a manifold and primitives of poses."""

from typing import Any

import numpy as np

from skillfold.baselines.dmp import Primitive
from skillfold.demonstrations import Demonstrations
from skillfold.errors import MissingExtraError
from skillfold.experiments.pick_place import Method, at_rest, planned
from skillfold.experiments.pick_place_sets import LARGE, POINTS, START, MotionSet, cube, shape_distances
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array

NAMES = ("x", "y", "z", "qw", "qx", "qy", "qz")
PLACE, ANGLE = 0.01, 0.02  # of the way from start to goal, and radians: near enough to the goal
TURNED = 0.15  # radians, per axis, by which starts are turned besides


def pose_rows(sets: list[MotionSet], settings: Settings) -> list[Row]:
    """Poses from the places of the large cube, turned a little, to the goal, of every set with orientations."""
    settings.progress("pick and place: poses", 0.85)
    rng = np.random.default_rng([settings.seed, 1])
    return [row for motions in sets if motions.orientations for row in set_rows(motions, settings, rng)]


def set_rows(motions: MotionSet, settings: Settings, rng: np.random.Generator) -> list[Row]:
    """What is reached, and how far places' shapes and orientations are from the recordings'."""
    recordings = [np.hstack(pair) for pair in zip(motions.recordings, motions.orientations, strict=True)]
    scale = motions.reach / float(np.linalg.norm(START))
    starts = _starts(recordings[0][0], LARGE * scale, rng)
    skill = settings.learn(Demonstrations(recordings, names=NAMES))
    ours = _judged(motions, recordings, planned(skill), starts)
    notes, rivals = [""] * 3, [None] * 3
    try:
        primitive = Primitive.fit_poses(at_rest(motions, recordings))
        rivals = list(_judged(motions, recordings, primitive.paths, starts))
        notes = [f"DMP {value:.3g}" for value in rivals]
    except MissingExtraError as error:
        notes = [str(error)] * 3
    head, count = f"{motions.name}, poses", len(starts)
    return [
        Row(f"{head}: reached", ours[0], f"of {count}", count, ">=", "left out", notes[0]),
        Row(f"{head}: shape distance from the recordings", ours[1], "", rivals[1], "<", "left out", notes[1]),
        Row(f"{head}: orientation off the recordings", ours[2], "rad", rivals[2], "<", "left out", notes[2]),
    ]


def _judged(motions: MotionSet, recordings: list[Array], method: Method, starts: Array) -> tuple[int, float, float]:
    """How many poses are reached; mean shape distance of places; mean angle from the recordings [rad]."""
    goal = recordings[0][-1]
    paths = method(starts, np.broadcast_to(goal, starts.shape))
    near = [np.linalg.norm(path[-1, :3] - goal[:3]) <= PLACE * motions.reach for path in paths]
    turned = [angles(path[-1:, 3:], goal[None, 3:])[0] <= ANGLE for path in paths]
    shape = np.mean([shape_distances(path[:, :3], motions.recordings)[0] for path in paths])
    off = np.mean([_off(path, recordings) for path in paths])
    return int(np.sum(np.logical_and(near, turned))), float(shape), float(off)


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
    mine = _orientations(path)
    return float(np.mean([angles(mine, _orientations(recording)) for recording in recordings]))


def _orientations(path: Array) -> Array:
    """(POINTS, 4) at even lengths of the places' way."""
    steps = np.linalg.norm(np.diff(path[:, :3], axis=0), axis=1)
    share = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    wanted = np.linspace(0.0, 1.0, POINTS)
    found = np.column_stack([np.interp(wanted, share, column) for column in path[:, 3:].T])
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def angles(a: Array, b: Array) -> Any:
    """Angles (n,) between rotations (n, 4) and (n, 4)."""
    return 2.0 * np.arccos(np.clip(np.abs((a * b).sum(1)), 0.0, 1.0))
