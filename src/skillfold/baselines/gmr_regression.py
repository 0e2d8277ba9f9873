"""Gaussian mixture regression by the `gmr` package: the usual first choice for few recordings.

Two settings, both on recordings resampled to equally many states at equal arc length, k-means++ starts:

- over phase: a mixture of (phase, state), phase scaled to the spread of the states so that neither dominates
  the distances; the path is the conditional mean given phase. It knows no start or goal, and mixes modes.
- as dynamics (Section VIII of paper 000): a mixture of (state, step), both scaled to unit spread; the path
  follows the conditional mean step from the start and is cut where it comes nearest to the goal.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skillfold.errors import MissingExtraError
from skillfold.motion import Array

COMPONENTS = 10
DYNAMICS_COMPONENTS = 6


def gmr_path(recordings: Sequence[Array], seed: int, components: int = COMPONENTS) -> Array:
    """Mean path (n_points, D) over phase, of recordings that all have shape (n_points, D)."""
    states = np.concatenate(recordings)
    width = 2.0 * float(states.std()) * 3**0.5  # a uniform variable so wide has the spread of the states
    phase = np.linspace(0.0, width, len(recordings[0]))
    mixture = mixture_of(np.column_stack([np.tile(phase, len(recordings)), states]), components, seed)
    return np.asarray(mixture.predict(np.array([0]), phase[:, None]), float)


def gmr_rollout(
    recordings: Sequence[Array], start: Array, goal: Array, seed: int, components: int = DYNAMICS_COMPONENTS
) -> Array:
    """Path (n, D) of the learnt dynamics from `start`, cut at its closest approach to `goal`."""
    states = np.concatenate([recording[:-1] for recording in recordings])
    steps = np.concatenate([np.diff(recording, axis=0) for recording in recordings])
    size, stride = float(states.std()), float(steps.std())
    mixture = mixture_of(np.column_stack([states / size, steps / stride]), components, seed)
    path = [start]
    for _ in range(2 * len(recordings[0])):
        step = mixture.predict(np.arange(len(start)), path[-1][None] / size)[0]
        path.append(path[-1] + stride * step)
    nearest = int(np.argmin(np.linalg.norm(np.array(path) - goal, axis=1)))
    return np.array(path[: max(nearest, 1) + 1])


def mixture_of(samples: Array, components: int, seed: int) -> Any:
    """A mixture of that many Gaussians over samples (n, m)."""
    try:
        from gmr import GMM
    except ImportError as error:
        raise MissingExtraError("gmr is not installed: pip install 'skillfold[bench]'.") from error
    # gmr takes generators of NumPy's older kind only.
    mixture = GMM(components, random_state=np.random.RandomState(seed))
    return mixture.from_samples(samples, init_params="kmeans++")
