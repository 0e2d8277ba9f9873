"""Position and orientation together, which section VIII of paper 000 left out: a manifold and primitives of poses."""

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from skillfold.baselines.dmp import Primitive
from skillfold.demonstrations import Demonstrations
from skillfold.errors import MissingExtraError
from skillfold.experiments.pick_place_sets import (
    LARGE,
    POINTS,
    START,
    MotionSet,
    cube,
    made,
    recorded,
    shape_distances,
)
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array

NAMES = ("x", "y", "z", "qw", "qx", "qy", "qz")
PLACE, ANGLE = 0.01, 0.02  # of the way from start to goal, and radians: near enough to the goal
TURNED = 0.15  # radians, per axis, by which starts are turned besides


def measure(settings: Settings) -> list[Row]:
    """Poses from the places of the large cube, turned a little, to the goal."""
    settings.progress("pick and place: poses", 0.9)
    rng = np.random.default_rng(settings.seed)
    sets = [motions for motions in (made(rng), *recorded(settings.data)) if motions.orientations]
    return [row for motions in sets for row in pose_rows(motions, settings, rng)]


def pose_rows(motions: MotionSet, settings: Settings, rng: np.random.Generator) -> list[Row]:
    """What is reached, and how far places' shapes and orientations are from the recordings'."""
    recordings = [np.hstack(pair) for pair in zip(motions.recordings, motions.orientations, strict=True)]
    skill = settings.learn(Demonstrations(recordings, names=NAMES))
    scale = motions.reach / float(np.linalg.norm(START))
    starts = _starts(recordings[0][0], LARGE * scale, rng)
    found = {"manifold": _judged(motions, recordings, lambda a, b: skill.plan(a, b).path.states, starts)}
    with suppress(MissingExtraError):
        found["DMP"] = _judged(motions, recordings, Primitive.fit_poses(recordings).path, starts)
    reached, shape, angle = found.pop("manifold")
    notes = ["; ".join(f"{name} {other[i]:.3g}" for name, other in found.items()) for i in range(3)]
    rivals = [min((other[i] for other in found.values()), default=None) for i in range(3)]
    head = f"{motions.name}, poses"
    return [
        Row(f"{head}: reached", reached, "of 27", 27, ">=", "left out", notes[0]),
        Row(f"{head}: shape distance from the recordings", shape, "", rivals[1], "<", "left out", notes[1]),
        Row(f"{head}: orientation off the recordings", angle, "rad", None, "<", "left out", notes[2]),
    ]


def _judged(
    motions: MotionSet, recordings: list[Array], method: Callable[[Array, Array], Array], starts: Array
) -> tuple[int, float, float]:
    """How many of 27 poses are reached; mean shape distance of places; mean angle from the recordings [rad]."""
    goal = recordings[0][-1]
    paths = [np.asarray(method(start, goal)) for start in starts]
    near = [np.linalg.norm(path[-1, :3] - goal[:3]) <= PLACE * motions.reach for path in paths]
    turned = [angles(path[-1:, 3:], goal[None, 3:])[0] <= ANGLE for path in paths]
    shape = np.mean([shape_distances(path[:, :3], motions.recordings)[0] for path in paths])
    return (
        int(np.sum(np.logical_and(near, turned))),
        float(shape),
        float(np.mean([_off(p, recordings) for p in paths])),
    )


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
