"""Random skills and what happens to their keyframes when all is moved."""

import numpy as np
from scipy.spatial.transform import Rotation

from skillfold.experiments.keyframe_learning import demonstrate, random_truth


def demonstrations(seed, demos=7, missing=0.0, extra=0.0, count=4):
    """A random skill and keyframes of it."""
    rng = np.random.default_rng(seed)
    truth = random_truth(rng, count)
    return truth, demonstrate(truth, demos, missing, extra, rng)


def moved(poses, turn, shift):
    """Poses (n, 7) with the whole world turned and shifted."""
    poses = np.array(poses)  # SciPy takes no read-only arrays
    rotations = turn * Rotation.from_quat(poses[:, 3:], scalar_first=True)
    return np.hstack([turn.apply(poses[:, :3]) + shift, rotations.as_quat(scalar_first=True)])


def any_motion(seed):
    rng = np.random.default_rng(seed)
    return Rotation.from_rotvec(rng.normal(0, 1.5, 3)), rng.normal(0, 2, 3)


def pose(x, angle=0.0):
    """A pose on a line, turned about z."""
    return np.array([x, 0.0, 0.0, np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])


def row(places, demos=5, spread=0.01, seed=0, angles=None):
    """Demonstrations of keyframes on a line, turned about z."""
    rng = np.random.default_rng(seed)
    poses = np.array([pose(x, a) for x, a in zip(places, angles or np.zeros(len(places)), strict=True)])
    noise = rng.normal(0, spread, (demos, len(places), 3))
    return [poses + np.hstack([part, np.zeros((len(places), 4))]) for part in noise]
