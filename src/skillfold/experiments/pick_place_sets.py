"""Recordings like those of section VIII of paper 000: pick-and-place, and other motions with one goal.

The paper's recordings could not be found. `made` draws a set of the same shape: five motions of 100 states from about
(1.8, 1.8, −1.1) to the origin, with orientations. Recordings of one's own take its place: CSV or NPZ files in the
folder `pick_place/` of the data.
"""

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from skillfold.errors import InputError, MissingExtraError
from skillfold.experiments.leave_one_out import resample
from skillfold.experiments.loaders import lasa, robot_poses, same_sign
from skillfold.motion import Array

START = np.array([1.8, 1.8, -1.1])
DEMOS, POINTS = 5, 100
SPREAD = 0.05  # of the starts, per axis
LIFT = np.array([[0.1, -0.25, 0.8], [-0.15, 0.2, 0.25]])  # heights of the first two half-waves off the straight line
VARIATION = 0.04  # of those heights from motion to motion
TURN = np.array([0.3, -0.9, 1.2])  # rotation vector from first to last orientation, radians
TURN_SPREAD = 0.1  # radians, per axis
SMALL, LARGE = 0.01, 0.05  # half the edge of the cubes (equations 26 and 27), for a set of the paper's size
SHAPES = ("Angle", "GShape", "Sshape", "Zshape")
OWN = "pick_place"  # folder of the data
FEWEST = 3  # recordings of a set: one is left out, and two make a skill of recordings
PLACES, POSES = (2, 3), 7  # coordinates that a state may have


@dataclass(frozen=True)
class MotionSet:
    """Recordings that lead to one goal.

    Attributes:
        name: of the set.
        recordings: each (POINTS, D) positions.
        orientations: each (POINTS, 4) unit quaternions, scalar first; or none.
        timed: whether states are those of instants, from rest to rest; else they lie at even lengths.
    """

    name: str
    recordings: tuple[Array, ...]
    orientations: tuple[Array, ...] = ()
    timed: bool = False

    @property
    def start(self) -> Array:
        """(D,) where the first recording begins."""
        return self.recordings[0][0]

    @property
    def goal(self) -> Array:
        """(D,) where all end, on average."""
        return np.mean([recording[-1] for recording in self.recordings], axis=0)

    @property
    def reach(self) -> float:
        """Distance from start to goal."""
        return float(np.linalg.norm(self.goal - self.start))


def made(rng: np.random.Generator, name: str = "pick and place (made)") -> MotionSet:
    """A set that stands for the paper's."""
    from scipy.spatial.transform import Rotation, Slerp

    share = _unhurried(np.linspace(0.0, 1.0, POINTS))[:, None]
    waves = np.sin(np.pi * share * np.arange(1, len(LIFT) + 1))
    base = Rotation.from_rotvec(rng.normal(0.0, 1.0, 3))
    positions, orientations = [], []
    for _ in range(DEMOS):
        start = START + SPREAD * rng.standard_normal(3)
        heights = LIFT + VARIATION * rng.standard_normal(LIFT.shape)
        positions.append((1.0 - share) * start + waves @ heights)
        ends = base * Rotation.from_rotvec([TURN_SPREAD * rng.standard_normal(3), TURN])
        turned = Slerp([0.0, 1.0], ends)(share[:, 0])
        orientations.append(turned.as_quat(scalar_first=True))
    return MotionSet(name, tuple(positions), tuple(orientations), timed=True)


def own(data: Path | None) -> MotionSet | None:
    """Recordings of one's own, moved so that they end at the origin on average; None where there are none.

    Raises:
        InputError: they are too few, or states are neither places (x, y) or (x, y, z) nor poses.
    """
    from skillfold.demonstrations import Demonstrations

    if data is None or not (data / OWN).is_dir():
        return None
    states = [np.asarray(demo.states, np.float64) for demo in Demonstrations.load(data / OWN)]
    dims = states[0].shape[1]
    if len(states) < FEWEST or dims not in (*PLACES, POSES):
        raise InputError(
            f"{data / OWN}: expected {FEWEST} recordings or more of 2 or 3 coordinates, or 7 (x, y, z and a unit "
            f"quaternion, scalar first); found {len(states)} of {dims}."
        )
    if dims == POSES:
        return _of_poses("own recordings", states)
    return MotionSet("own recordings", _to_origin(tuple(resample(recording, POINTS) for recording in states)))


def recorded(data: Path | None, shapes: tuple[str, ...] = SHAPES) -> list[MotionSet]:
    """Handwriting where it is installed, and five recordings of a bottle put on a shelf where the folder has them."""
    sets = [MotionSet(task.name, task.recordings[:DEMOS]) for task in _handwriting() if task.name in shapes]
    if data is not None and (data / "robotasks" / "bottle2shelf.npy").is_file():
        sets.insert(0, _of_poses("bottle2shelf", list(robot_poses(data, "bottle2shelf")[:DEMOS])))
    return sets


def cube(centre: Array, half: float) -> Array:
    """Corners, edges' and sides' middles and centre of a cube (3^D, D) about a place."""
    return centre + half * np.array(list(product((-1.0, 0.0, 1.0), repeat=len(centre))))


def shape_distances(path: Array, recordings: tuple[Array, ...]) -> tuple[float, float]:
    """How far the shape of a path is from those of all recordings (rms), and from the one it is most like.

    Shape is what is left of a path, read at even lengths, without the straight line between its own ends: where a
    path begins and ends does not count. Both are rms of the difference over the rms of the recordings' shapes: 0 is
    the same, 1 a straight line.
    """
    shapes = np.array([_shape(recording) for recording in recordings])
    size = float(np.sqrt((shapes**2).sum(2).mean()))
    gaps = ((shapes - _shape(path)) ** 2).sum(2).mean(1)
    return float(np.sqrt(gaps.mean())) / size, float(np.sqrt(gaps.min())) / size


def shape_distance(path: Array, recording: Array, recordings: tuple[Array, ...]) -> float:
    """How far the shape of a path is from that of one recording, in the same measure."""
    shapes = np.array([_shape(each) for each in recordings])
    gap = ((_shape(path) - _shape(recording)) ** 2).sum(1).mean()
    return float(np.sqrt(gap / (shapes**2).sum(2).mean()))


def turns_along(path: Array) -> Array:
    """Unit quaternions (POINTS, 4) of poses (n, 7) at even lengths of the places' way."""
    steps = np.linalg.norm(np.diff(path[:, :3], axis=0), axis=1)
    share = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    wanted = np.linspace(0.0, 1.0, POINTS)
    found = np.column_stack([np.interp(wanted, share, column) for column in path[:, 3:].T])
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def _shape(path: Array) -> Array:
    states = resample(path, POINTS)
    share = np.linspace(0.0, 1.0, POINTS)[:, None]
    return states - (1.0 - share) * states[0] - share * states[-1]


def _of_poses(name: str, recordings: list[Array]) -> MotionSet:
    """A set of recorded poses (n, 7) each: orientations belong to the places that they were recorded at."""
    places = tuple(resample(recording[:, :3], POINTS) for recording in recordings)
    turns = same_sign(np.array([turns_along(recording) for recording in recordings]))
    return MotionSet(name, _to_origin(places), tuple(turns))


def _to_origin(recordings: tuple[Array, ...]) -> tuple[Array, ...]:
    goal = np.mean([recording[-1] for recording in recordings], axis=0)
    return tuple(recording - goal for recording in recordings)


def _handwriting() -> list[Any]:
    try:
        return lasa(False)
    except MissingExtraError:
        return []


def _unhurried(share: Array) -> Array:
    """The minimum jerk profile."""
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
