"""Scenes that leave little of an envelope free: a wall across its middle with a slot that the hand fits through.

The free share is measured where the wall stands: of poses drawn uniformly from the envelope's middle (s = 1/2), in
position within the wall's plane and in rotation, the share at which the arm is clear in some posture. The slot is as
wide as makes that share the one asked for.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.experiments.keyframe_runs import Answer, Learnt, ask, judged
from skillfold.experiments.keyframe_tasks import Task
from skillfold.experiments.rows import Row, Settings
from skillfold.motion import Array
from skillfold.robots.reaching import reach
from skillfold.robots.scene import Scene
from skillfold.robots.shapes import Box
from skillfold.robots.world import World
from skillfold.tables import Indices

FREE = 0.05  # share of the mid-slice
POSES = 200  # that the share is measured by
THICK = 0.03  # metres, of the wall
ABOVE = 0.10  # metres that the wall is higher than the slice
SIDES = (0.20, 0.45)  # metres that it reaches from the middle: toward the base, and away from it
PLACES = 0.5  # of the slice's half width: how far from the middle a slot may be
WIDEST = 0.5  # metres
HALVINGS = 10


@dataclass(frozen=True, eq=False)
class Slice:
    """The middle of an envelope.

    Attributes:
        task: whose arm it is.
        middle: (3,) of the slice [m].
        across: (3,) horizontal, along the wall.
        half: (2,) half width along the wall and half height [m].
        postures: (m, dof) that reach its poses.
        owners: (m,) which pose each reaches.
        poses: how many there are.
    """

    task: Task
    middle: Array
    across: Array
    half: Array
    postures: Array
    owners: Indices
    poses: int

    def free(self, scene: Any) -> float:
        """Share of the poses at which some posture is clear of a scene."""
        clear = self.task.robot.obstacles(scene).clearance(self.postures) > 0.0
        return len(np.unique(self.owners[clear])) / self.poses


@dataclass(frozen=True, eq=False)
class Narrow:
    """A wall with a slot.

    Attributes:
        scene: what the task shows, and the wall.
        width: of the slot [m].
        free: share of the mid-slice.
    """

    scene: Scene
    width: float
    free: float


def middle_of(task: Task, envelope: Any, rng: np.random.Generator, count: int | None = None) -> Slice:
    """The middle of an envelope, and every posture that reaches some poses drawn from it, `POSES` if not told."""
    count = count or POSES
    position, rotation = envelope.covariances_at(0.5)
    y = np.tile(envelope.means_at(0.5), (count, 1))
    away = envelope.ends[1, :3] - envelope.ends[0, :3]
    along = np.array([away[0], away[1], 0.0]) / np.hypot(away[0], away[1])
    plane = np.column_stack([np.cross(along, [0.0, 0.0, 1.0]), [0.0, 0.0, 1.0]])
    if plane[:, 0] @ envelope.means_at(0.5)[:3] < 0.0:  # it shall go away from the base
        plane[:, 0] *= -1.0
    section = np.linalg.inv(plane.T @ np.linalg.inv(position) @ plane)
    y[:, :3] += _ball(count, 2, rng) @ np.linalg.cholesky(section).T @ plane.T
    y[:, 3:] += _ball(count, 3, rng) @ np.linalg.cholesky(rotation).T
    poses = envelope.chart.to_pose(y)
    found = [reach(task.robot, pose, task.clear[0], i) for i, pose in enumerate(poses)]
    owners = np.repeat(np.arange(count), [len(q) for q in found])
    half = np.sqrt(np.diag(section))
    return Slice(task, envelope.means_at(0.5)[:3], plane[:, 0], half, np.concatenate(found), owners, count)


def narrow(at: Slice, rng: np.random.Generator, free: float = FREE) -> Narrow:
    """A wall whose slot, at a random place, leaves about that share free."""
    place = PLACES * at.half[0] * rng.uniform(-1.0, 1.0)
    low, high = 0.0, WIDEST
    for _ in range(HALVINGS):
        width = 0.5 * (low + high)
        low, high = (low, width) if at.free(walled(at, place, width)) >= free else (width, high)
    scene = walled(at, place, high)
    return Narrow(scene, high, at.free(scene))


def walled(at: Slice, place: float, width: float) -> Scene:
    """What the task shows and a wall with a slot of some width [m], its middle that far along the wall."""
    height = at.middle[2] + at.half[1] + ABOVE
    yaw = 0.5 * np.arctan2(at.across[1], at.across[0])
    turned = [np.cos(yaw), 0.0, 0.0, np.sin(yaw)]
    spans = {"near": (-SIDES[0], place - width / 2), "far": (place + width / 2, SIDES[1])}
    walls = []
    for name, (low, high) in spans.items():
        if high > low:
            foot = at.middle + 0.5 * (low + high) * at.across
            size = (high - low, THICK, height)
            walls.append(Box([foot[0], foot[1], height / 2, *turned], size, name=f"{name} wall"))
    return Scene([*at.task.shown, *walls])


def _ball(count: int, dims: int, rng: np.random.Generator) -> Array:
    """Points (count, dims), uniform in the unit ball."""
    points = rng.standard_normal((count, dims))
    return points * rng.uniform(size=(count, 1)) ** (1 / dims) / np.linalg.norm(points, axis=1, keepdims=True)


def rows(skills: Sequence[Learnt], walls: int, settings: Settings) -> list[Row]:
    """Plans through walls: solved in time within the gates as learnt, and with gates widened."""
    found, shares = [], []
    for number, learnt in enumerate(skills):
        settings.progress("keyframes: walls with slots", 0.6 + 0.1 * number / len(skills))
        rng = np.random.default_rng([settings.seed, 4, learnt.draw])
        at = middle_of(learnt.task, learnt.envelope, rng)
        for wall in range(walls):
            made = narrow(at, rng)
            start = _start(learnt, made.scene, [settings.seed, 5, learnt.draw, wall])
            world = World(learnt.task.robot, made.scene)
            found.append(judged(ask(learnt, start, 100.0, wall, made.scene), learnt, world))
            shares.append(made.free)
    return _rows(found, np.array(shares))


def _start(learnt: Learnt, scene: Scene, seed: Any) -> Array:
    """Where to set out from, clear of the wall too."""
    obstacles = learnt.task.robot.obstacles(scene)
    starts = (learnt.start([*seed, i]) for i in itertools.count())
    return next(start for start in starts if obstacles.clearance(start) > 0.0)


def _rows(found: Sequence[Answer], shares: Array) -> list[Row]:
    solved = float(np.mean([answer.solved for answer in found]))
    widened = float(np.mean([answer.plan.success for answer in found]))
    times = 1e3 * np.array([answer.seconds for answer in found if answer.solved] or [np.nan])
    wrong = [a for a in found if a.verdict is not None and (a.verdict.outside or a.verdict.touching)]
    note = (
        f"{len(found)} walls, {shares.mean():.3f} ± {shares.std():.3f} free ({POSES} poses in its plane, "
        f"clear in some posture); median {np.median(times):.3g} ms, p95 {np.quantile(times, 0.95):.3g} ms"
    )
    factors = [answer.plan.stats["gate_factor"] for answer in found if answer.plan.success]
    counts = "gates " + ", ".join(f"× {factor:g}: {factors.count(factor)}" for factor in sorted(set(factors)))
    return [
        Row("narrow scenes: solved in 1 s, gates as learnt", solved, "share", 0.95, ">=", "", note),
        Row("narrow scenes: solved, gates widened where need be", widened, "share", 0.99, ">=", "", counts),
        Row("narrow scenes: paths outside or in touch", float(len(wrong)), "", 0, "=="),
    ]
