"""What the pictures of sections V-A to V-C show: skills of the three-link arm, paths on them, states brought back."""

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.experiments.reaching import (
    GRID_CENTRE,
    GRID_HALF,
    Positions,
    grid,
    inside_grid,
    outside_grid,
    timed_plans,
    upper_half_disc,
)
from skillfold.experiments.rows import Row, Settings
from skillfold.experiments.three_link import REACHING, WEIGHTED_REACHING, Redundancy, followed, forward, optimal
from skillfold.motion import Array
from skillfold.tables import Indices

SAMPLES = 100
PAIRS = 50  # of ends, as in the paper
RANDOM = 200  # states drawn in joint space


@dataclass(frozen=True)
class Learnt:
    """A skill and what it was learnt from.

    Attributes:
        skill: with the defaults that a user gets.
        redundancy: that its samples resolve.
        samples: (N, 3) optimal poses.
    """

    skill: Any
    redundancy: Redundancy
    samples: Array

    @property
    def graph(self) -> tuple[Array, Indices]:
        """Denoised samples (N, 3) and their neighbours (E, 2)."""
        return self._states(self.skill.model.anchors), self.skill.model.edges

    @property
    def centres(self) -> Array:
        """(K, 3) centres of the radial basis functions."""
        return self._states(self.skill.model.field.centres.T)

    def _states(self, inner: Array) -> Array:
        model = self.skill.model
        return model.centre + model.scale * inner @ model.kept.T


@dataclass(frozen=True)
class Paths:
    """Plans between random pairs of optimal poses.

    Attributes:
        states: of each, (n, 3).
        errors: of each, (n - 2,) rad per joint of interior states against the optimum where their tool is.
        seconds: that each took, by the clock of its thread.
    """

    states: list[Array]
    errors: list[Array]
    seconds: Array

    @property
    def rmse(self) -> float:
        """Of all interior states, as the paper has it [rad]."""
        return float(np.sqrt(np.mean(np.concatenate(self.errors) ** 2)))


@dataclass(frozen=True)
class Shown:
    """All that is drawn.

    Attributes:
        grid: the skill of section V-A; `inside` and `outside` of the grid that it was shown, paths on it.
        half_disc: the skill of section V-B; `geodesics` on it.
        random, projected: (n, 3) states drawn in joint space, and where they are brought (section V-C).
    """

    grid: Learnt
    inside: Paths
    outside: Paths
    half_disc: Learnt
    geodesics: Paths
    random: Array
    projected: Array


def run(settings: Settings, pairs: int = PAIRS, random: int = RANDOM) -> Shown:
    """Learn both skills, plan on them, bring random states onto the second."""
    rng = np.random.default_rng([settings.seed, 5])
    poses = optimal(grid(), REACHING)
    first = _learn(settings, REACHING, poses[rng.choice(len(poses), SAMPLES, replace=False)])
    second = _learn(settings, WEIGHTED_REACHING, optimal(upper_half_disc(SAMPLES, rng), WEIGHTED_REACHING))
    inside, outside = (_plan(first, ends, pairs, rng) for ends in (inside_grid, outside_grid))
    geodesics = _plan(second, upper_half_disc, pairs, rng)
    states = rng.uniform(second.samples.min(axis=0), second.samples.max(axis=0), (random, 3))
    return Shown(first, inside, outside, second, geodesics, states, second.skill.project(states))


def beyond(positions: Array) -> Array:
    """Distance (n,) of tool positions (n, 2) from the edge of the grid, negative inside [m]."""
    over = np.abs(positions - GRID_CENTRE) - GRID_HALF
    return np.linalg.norm(np.maximum(over, 0.0), axis=1) + np.minimum(over.max(axis=1), 0.0)


def state_errors(states: Array, redundancy: Redundancy) -> Array:
    """Joint RMSE (n,) of states (n, 3) against the optimum at their own tool positions; NaN where there is none."""
    # The optimum of section V-B jumps to its mirror image below the x axis, outside the set that is learnt.
    truth = followed if redundancy == WEIGHTED_REACHING else optimal
    best = truth(forward(states), redundancy)
    return np.sqrt(np.mean((states - best) ** 2, axis=1))


def rows(shown: Shown) -> list[Row]:
    """How far from the optimum random states are, and how far those that were brought back."""
    before, after = (state_errors(states, WEIGHTED_REACHING) for states in (shown.random, shown.projected))
    known = np.isfinite(after)
    note = (
        f"of {len(after)} states drawn in the samples' bounding box; p95 {np.quantile(after[known], 0.95):.1e}; "
        f"before {np.nanmedian(before):.2g}; {int((~known).sum())} where no optimum is known"
    )
    name = "V-C random states brought onto the manifold: joint error against the optimum, median"
    return [Row(name, float(np.median(after[known])), "rad", None, "<=", "", note)]


def _learn(settings: Settings, redundancy: Redundancy, samples: Array) -> Learnt:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the skill keeps its notes
        return Learnt(settings.learn(samples), redundancy, samples)


def _plan(learnt: Learnt, ends: Positions, pairs: int, rng: np.random.Generator) -> Paths:
    starts, goals = (optimal(ends(pairs, rng), learnt.redundancy) for _ in range(2))
    timed_plans(learnt.skill, starts, goals)  # these do not count: the first compile
    plans, seconds = timed_plans(learnt.skill, starts, goals)
    states = [np.asarray(plan.path.states) for plan in plans]
    errors = [state_errors(path[1:-1], learnt.redundancy) for path in states]
    return Paths(states, errors, np.array(seconds))
