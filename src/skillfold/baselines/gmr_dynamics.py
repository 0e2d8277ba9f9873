"""Learnt dynamics by Gaussian mixture regression, as in section VIII of paper 000, by the `gmr` package.

A mixture over (state, step), both scaled to unit spread; the motion follows the conditional mean step from the start
on. The number of Gaussians is given, or chosen by the Bayesian information criterion.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from skillfold.baselines.gmr_regression import mixture_of
from skillfold.motion import Array

CHOICES = range(3, 11)  # Gaussians
PATIENCE = 3  # times the recordings' steps until a motion is given up
REACHED = 0.01  # of the way from start to goal: near enough to stop


@dataclass(frozen=True)
class Dynamics:
    """A fitted mixture.

    Attributes:
        mixture: over (state, step), scaled.
        components: Gaussians in it.
        size, stride: what states and steps were divided by.
        steps: of a recording.
    """

    mixture: Any
    components: int
    size: float
    stride: float
    steps: int

    @classmethod
    def fit(cls, recordings: Sequence[Array], seed: int, components: int | None = None) -> Self:
        """From recordings that all have shape (n_points, D)."""
        states = np.concatenate([recording[:-1] for recording in recordings])
        steps = np.concatenate([np.diff(recording, axis=0) for recording in recordings])
        size, stride = float(states.std()), float(steps.std())
        samples = np.column_stack([states / size, steps / stride])
        choices = CHOICES if components is None else (components,)
        mixtures = [mixture_of(samples, count, seed) for count in choices]
        best = int(np.argmin([_criterion(mixture, samples) for mixture in mixtures]))
        return cls(mixtures[best], choices[best], size, stride, len(recordings[0]) - 1)

    def path(self, start: Array, goal: Array) -> Array:
        """The motion (n, D) from a start, until it is near the goal or was given up."""
        return self.paths(start[None], goal[None])[0]

    def paths(self, starts: Array, goals: Array) -> list[Array]:
        """The same from starts (m, D) to goals (m, D), all asked at once."""
        near = REACHED * np.linalg.norm(goals - starts, axis=1)
        way, last = [starts], np.full(len(starts), PATIENCE * self.steps)
        columns, going = np.arange(starts.shape[1]), np.ones(len(starts), dtype=bool)
        for i in range(1, PATIENCE * self.steps + 1):
            step = np.zeros_like(starts)
            step[going] = self.mixture.predict(columns, way[-1][going] / self.size)
            way.append(way[-1] + self.stride * step)
            done = going & ((np.linalg.norm(way[-1] - goals, axis=1) <= near) | ~np.isfinite(way[-1]).all(axis=1))
            last[done], going = i, going & ~done
            if not going.any():
                break
        return [np.array([states[k] for states in way[: last[k] + 1]]) for k in range(len(starts))]


def _criterion(mixture: Any, samples: Array) -> float:
    """The Bayesian information criterion; less is better."""
    count, dims = samples.shape
    density = np.maximum(mixture.to_probability_density(samples), 1e-300)
    parameters = len(mixture.priors) * (1 + dims + dims * (dims + 1) / 2) - 1
    return float(parameters * np.log(count) - 2.0 * np.log(density).sum())
