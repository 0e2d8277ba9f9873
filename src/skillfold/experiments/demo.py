"""What `skillfold demo` shows: skills learnt from real handwriting and from two arms, put to use.

Each chapter learns one skill, plans motions between ends that were not demonstrated, disturbs states and brings
them back, and measures all of it; the last one carries a tray past a box (`tray_demo`). Nothing is drawn or printed
here.
"""

import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np

from skillfold import ahead
from skillfold.errors import MissingExtraError
from skillfold.experiments import demo_ahead, tray_demo
from skillfold.experiments.leave_one_out import resample
from skillfold.experiments.loaders import RecordedTask, lasa
from skillfold.experiments.reaching import grid, inside_grid, path_rmse
from skillfold.experiments.rows import Progress, Settings
from skillfold.experiments.three_link import REACHING, optimal
from skillfold.experiments.tray_demo import Carrying
from skillfold.manifold.geodesic import geodesic
from skillfold.motion import Array, Plan

SHAPES = ("Sshape", "GShape", "Zshape", "Multi_Models_3")
TITLES = {"Sshape": "S", "GShape": "G", "Zshape": "Z", "Multi_Models_3": "S and W, one skill"}
PLANS = 4
PATHS = 50  # of the arm
ASIDE = 1.0  # tolerances, per axis: how far new ends lie from demonstrated ones
DISTURBED = 28
PUSH = 0.06  # of the side of the field, per axis
JOINT_PUSH = 0.2  # rad, per joint
MARGIN = 0.16  # of the longer side, around the demonstrations
COARSE = 40  # rows and columns of the distance field
FINE = 5  # times finer: the cheaper field of how far outside a state is
PAPER_RMSE = 1.9e-4  # of the paper's section V-A, rad


@dataclass(frozen=True)
class Field:
    """How far the states of a plane are from a skill.

    Attributes:
        x, y: of the grid, (n,) each.
        distance: (n, n), from the modelled surface.
        inside: on a grid `FINE` times finer over the same rectangle; 1 is the edge of the demonstrations.
    """

    x: Array
    y: Array
    distance: Array
    inside: Array


@dataclass(frozen=True)
class Chapter:
    """One skill and what was done with it.

    Attributes:
        name: of what was learnt.
        unit: of the coordinates.
        skill: the learnt skill.
        demonstrations: what it was learnt from, each (n_steps, D).
        plans: between new ends.
        disturbed, projected: (n, D) states pushed off, and brought back.
        field: of a skill in the plane, else None.
        errors: (n_plans,) RMSE of each path against the optimum, where that is known.
        seconds: of the fit, of one plan (median) and of one projection.
    """

    name: str
    unit: str
    skill: Any
    demonstrations: tuple[Array, ...]
    plans: tuple[Plan, ...]
    disturbed: Array
    projected: Array
    field: Field | None
    errors: Array
    seconds: dict[str, float]

    @property
    def paths(self) -> list[Array]:
        """States (n, D) of the plans that passed their check."""
        return [plan.path.states for plan in self.plans if plan.success]

    def facts(self) -> dict[str, Any]:
        """What was measured, as plain values; lengths and distances in `unit`, times in seconds."""
        made = [plan for plan in self.plans if plan.success]
        dense = [resample(states, 400) for states in self.demonstrations if len(self.demonstrations) > 1]
        samples = np.concatenate(dense or list(self.demonstrations))
        return {
            "name": self.name,
            "unit": self.unit,
            "dim": self.skill.dim,
            "n_dims": self.skill.n_dims,
            "demonstrations": len(dense) or None,
            "samples": int(self.skill.n_samples),
            "fit_seconds": self.seconds["fit"],
            "plan_seconds": self.seconds["plan"],
            "project_seconds": self.seconds["project"],
            "plans": len(self.plans),
            "successful": len(made),
            "mean_length": float(np.mean([plan.length for plan in made])) if made else None,
            "largest_residual": max((plan.residual for plan in made), default=None),
            "to_demonstrations": _mean_gap(self.paths, samples),
            "between_demonstrations": _apart(dense),
            "paper_rmse": PAPER_RMSE if len(self.errors) else None,
            "rmse": float(np.sqrt(np.mean(self.errors**2))) if len(self.errors) else None,
            "disturbed_off": float(np.median(self.skill.distance(self.disturbed))),
            "projected_off": float(np.median(self.skill.distance(self.projected))),
        }


@dataclass(frozen=True)
class Story:
    """All chapters, what a user should know about those that are missing, and the tray that is carried."""

    chapters: tuple[Chapter, ...]
    notes: tuple[str, ...]
    carrying: Carrying | None = None


def run(seed: int = 0, progress: Progress | None = None, shapes: Sequence[str] = SHAPES) -> Story:
    """Learn, plan, disturb and project.

    Args:
        seed: of everything random.
        progress: called with what is being done and the share of all that is done.
        shapes: of the handwriting set; left out with a note where it is not installed.
    """
    progress = progress or Settings(0).progress
    tasks, notes = _recordings(shapes)
    with _compiled(progress):
        chapters = []
        for index, task in enumerate(tasks):
            progress(f"handwriting: {TITLES.get(task.name, task.name)}", 0.4 + 0.3 * index / len(tasks))
            chapters.append(handwriting(task, np.random.default_rng([seed, index])))
        progress("three-link arm", 0.7)
        chapters.append(three_link_arm(np.random.default_rng(seed)))
    progress("tray with tumblers", 0.9)
    carrying = tray_demo.run(np.random.default_rng(seed))
    progress("tray with tumblers", 1.0)
    return Story(tuple(chapters), notes, carrying)


def handwriting(task: RecordedTask, rng: np.random.Generator) -> Chapter:
    """A skill of the plane from whole recordings; plans follow the way these take."""
    demos = task.recordings
    skill, fit = _learn(list(demos))
    chosen = rng.choice(len(demos), min(PLANS, len(demos)), replace=False)
    ends = np.array([demos[i][[0, -1]] for i in chosen])
    plans, seconds = _plans(skill, ends + ASIDE * skill.tolerance * rng.standard_normal(ends.shape))
    low, high = square(np.concatenate(demos))
    push = PUSH * (high - low) * rng.standard_normal((DISTURBED, 2))
    disturbed = np.clip(skill.sample(DISTURBED, int(rng.integers(2**31))) + push, low, high)
    projected, each = _projected(skill, disturbed)
    times = {"fit": fit, "plan": seconds, "project": each}
    name = TITLES.get(task.name, task.name)
    field = distance_field(skill, low, high)
    return Chapter(name, "mm", skill, demos, plans, disturbed, projected, field, np.empty(0), times)


def three_link_arm(rng: np.random.Generator, samples: int = 100, paths: int = PATHS) -> Chapter:
    """Section V-A of paper 000: optimal poses of a redundant arm, without order; plans are geodesics."""
    poses = optimal(grid(), REACHING)
    given = poses[rng.choice(len(poses), samples, replace=False)]
    skill, fit = _learn(given)
    ends = optimal(inside_grid(2 * paths, rng), REACHING).reshape(paths, 2, 3)
    plans, seconds = _plans(skill, ends)
    errors = np.array([path_rmse(plan.path.states[1:-1], REACHING) for plan in plans])
    undisturbed = optimal(inside_grid(2 * DISTURBED, rng), REACHING)
    disturbed = undisturbed + JOINT_PUSH * rng.standard_normal(undisturbed.shape)
    projected, each = _projected(skill, disturbed)
    times = {"fit": fit, "plan": seconds, "project": each}
    return Chapter("three-link arm", "rad", skill, (given,), plans, disturbed, projected, None, errors, times)


def distance_field(skill: Any, low: Array, high: Array) -> Field:
    """The field over the rectangle between two corners of the plane."""
    x, y = np.linspace(low, high, COARSE).T
    fine = _grid(*np.linspace(low, high, FINE * COARSE).T)
    with ThreadPoolExecutor(2) as workers:  # compiled loops leave the interpreter to each other
        distance = np.stack(list(workers.map(skill.distance, _grid(x, y))))
    return Field(x, y, distance, skill.inside(fine))


def _recordings(shapes: Sequence[str]) -> tuple[list[RecordedTask], tuple[str, ...]]:
    try:
        tasks = {task.name: task for multi_mode in (False, True) for task in lasa(multi_mode)}
    except MissingExtraError as error:
        return [], (f"{error} Only the three-link arm is shown.",)
    return [tasks[name] for name in shapes], ()


@contextmanager
def _compiled(progress: Progress) -> Iterator[None]:
    """Everything below once on very little, so that the times that are told are those of the work.

    What needs no skill is compiled beside the learning of one, and what the tray needs beside what is done here.
    """
    with TemporaryDirectory() as folder, ExitStack() as beside:
        with ahead.running("skillfold.experiments.demo_ahead"):
            progress("compiling (once on each machine): learning", 0.0)
            poses = optimal(inside_grid(40, np.random.default_rng(0)), REACHING)
            reaching, _ = _learn(poses, dim=2, kernels=5)
            progress("compiling (once on each machine): planning", 0.2)
            geodesic(reaching.model, poses[:2], len(poses))
            file = Path(folder) / "reaching.npz"
            reaching.save(file)
            beside.enter_context(ahead.running("skillfold.experiments.demo_ahead", str(file)))
            progress("compiling (once on each machine): projecting", 0.35)
        _compile_queries(reaching, poses)
        yield
        progress("compiling (once on each machine): the tray", 0.8)
        demo_ahead.carried(reaching)
    demo_ahead.ways(reaching)  # compiled by now, or there is one core


def _compile_queries(reaching: Any, poses: Array) -> None:
    reaching.plan(poses[0], poses[1])
    reaching.project(reaching.sample(4))
    reaching.inside(poses)
    wave = np.linspace(0.0, 3.0, 40)
    skill, _ = _learn([np.column_stack([wave, np.sin(wave) + shift]) for shift in (0.0, 0.05)], dim=1, kernels=5)
    skill.plan(np.zeros(2), np.array([3.0, 0.1]))


def _learn(demos: Any, **options: Any) -> tuple[Any, float]:
    from skillfold.manifold.skill import SkillManifold

    start = perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the skill keeps its notes
        skill = SkillManifold.fit(demos, **options)
    return skill, perf_counter() - start


def _plans(skill: Any, ends: Array) -> tuple[tuple[Plan, ...], float]:
    """Plans between the ends (n, 2, D), and the median of their seconds."""
    plans, times = [], []
    for start, goal in ends:
        begun = perf_counter()
        plans.append(skill.plan(start, goal))
        times.append(perf_counter() - begun)
    return tuple(plans), float(np.median(times))


def _projected(skill: Any, states: Array) -> tuple[Array, float]:
    start = perf_counter()
    onto = skill.project(states)
    return onto, (perf_counter() - start) / len(states)


def square(states: Array) -> tuple[Array, Array]:
    """Lowest and highest corner of a square with the states in its middle."""
    low, high = states.min(axis=0), states.max(axis=0)
    half = (0.5 + MARGIN) * float((high - low).max())
    return (low + high) / 2 - half, (low + high) / 2 + half


def _grid(x: Array, y: Array) -> Array:
    """(ny, nx, 2) states of the plane."""
    return np.stack(np.meshgrid(x, y), axis=-1)


def _mean_gap(paths: Sequence[Array], states: Array) -> float | None:
    """Mean distance of the paths' states from the nearest of `states`."""
    if not paths:
        return None
    from scipy.spatial import KDTree

    return float(KDTree(states).query(np.concatenate(paths))[0].mean())


def _apart(demos: Sequence[Array]) -> float | None:
    """Mean distance of a demonstration from the nearest states of all others: what may be expected of a plan."""
    if len(demos) < 2:
        return None
    gaps = [_mean_gap([d], np.concatenate([*demos[:i], *demos[i + 1 :]])) for i, d in enumerate(demos)]
    return float(np.mean([gap for gap in gaps if gap is not None]))
