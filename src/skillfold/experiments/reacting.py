"""How fast and how safely a controller answers: the tray arm among ten boxes, seven joints.

Times of single calls from Python in a process that does nothing else; first calls, which compile, are not counted.
"""

from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from skillfold.experiments import tray
from skillfold.experiments.rows import Row, Settings
from skillfold.experiments.tray_cases import SceneCase, past_boxes
from skillfold.motion import Array

if TYPE_CHECKING:
    from skillfold.robots.scene import Scene

POSES, BOXES = 400, 10
STEPS, PERIOD, DURATION = 20_000, 1e-3, 4.0
WARM = 50  # steps of a motion that are not timed
CASES, MOVES = 60, 3  # cases to plan anew in, and how often in each
MOVED = 0.02  # m by which boxes move
ROOM = 0.01  # m that start and goal then have, or there is nothing to plan
AT = 0.2  # of the path: where the arm is by then
EDGE = 0.06  # m, of boxes that only stand about
NOISE = 1e-4  # rad, of the positions that the controller sees


def measure(settings: Settings, steps: int = STEPS, cases: int = CASES) -> list[Row]:
    """The controller's step, planning anew, and what it does with samples that cannot be."""
    rng = np.random.default_rng(settings.seed)
    settings.progress("controller: learning", 0.0)
    skill = settings.learn(tray.tray_poses(POSES, rng, tray.LEVEL_WEIGHT))
    found = past_boxes(cases, rng)
    settings.progress("controller: steps", 0.2)
    rows = _step_rows(skill, found, steps, rng)
    settings.progress("controller: hostile samples", 0.4)
    rows.append(hostile_row(skill, found[0], rng))
    settings.progress("controller: planning anew", 0.5)
    return rows + replan_rows(skill, found, rng)


def crowded(scene: "Scene", path: Array, rng: np.random.Generator) -> "Scene":
    """The scene with small boxes added, well clear of a path, until there are ten."""
    from skillfold.robots.scene import Scene
    from skillfold.robots.shapes import Box

    boxes = list(scene)
    while len(boxes) < BOXES:
        box = Box(pose=tray.workspace(1, rng)[0], size=(EDGE,) * 3, name=f"about_{len(boxes)}")
        if tray.arm().obstacles([box]).clearance(path[::5]).min() > 0.05:
            boxes.append(box)
    return Scene(boxes)


def _controller(skill: Any, case: SceneCase, rng: np.random.Generator) -> tuple[Any, Any]:
    from skillfold.control.reactive import ReactiveController

    robot = tray.arm()
    plan = skill.plan(case.start, case.goal, obstacles=robot.obstacles(case.scene))
    scene = crowded(case.scene, plan.path.states, rng)
    controller = ReactiveController(skill, plan, robot=robot, obstacles=robot.obstacles(scene), duration=DURATION)
    return controller, plan


def _step_rows(skill: Any, cases: list[SceneCase], steps: int, rng: np.random.Generator) -> list[Row]:
    """Times of all steps of whole motions, one case after the other."""
    laps = [_lap(skill, cases[i % len(cases)], rng) for i in range(-(-steps // round(DURATION / PERIOD)))]
    taken = np.concatenate([lap[0] for lap in laps])
    tracking = float(np.mean(np.concatenate([lap[1] for lap in laps])))
    p50, late = (float(v) for v in np.percentile(1e6 * taken, [50, 99.9]))
    idle = np.percentile(1e6 * _idle(len(taken), 1e-6 * p50), 99.9)
    note = (
        f"{len(taken)} steps, {BOXES} boxes, {tracking:.0%} tracking, slowest {1e6 * taken.max():.0f} µs; a loop "
        f"that only counts for as long as the median takes {idle:.0f} µs at p99.9 here"
    )
    return [
        Row("controller step with clearance at D = 7, median", p50, "µs", 40.0, "<", "", note),
        Row("controller step with clearance at D = 7, p99.9", late, "µs", 200.0, "<", "", note),
    ]


def _idle(count: int, length: float) -> Array:
    """Seconds that a loop takes which needs about `length` and does nothing else; (count,)."""
    turns, taken = 100, np.empty(count)
    while _counting(turns) < length:
        turns *= 2
    turns = max(int(turns * length / _counting(turns)), 1)
    for i in range(count):
        taken[i] = _counting(turns)
    return taken


def _counting(turns: int) -> float:
    before = perf_counter()
    for _ in range(turns):
        pass
    return perf_counter() - before


def _lap(skill: Any, case: SceneCase, rng: np.random.Generator) -> tuple[Array, Array]:
    """Seconds of each step of one motion, the first few left out, and whether it was tracked."""
    controller, _ = _controller(skill, case, rng)
    count = round(DURATION / PERIOD)
    taken, tracking = np.empty(count), np.zeros(count, bool)
    for i in range(count):
        q, qd, _ = controller.reference.at(i * PERIOD)
        seen = q + NOISE * rng.standard_normal(len(q))
        before = perf_counter()
        command = controller.command(i * PERIOD, seen, qd)
        taken[i] = perf_counter() - before
        tracking[i] = command.mode == "tracking"
    controller.close()
    return taken[WARM:], tracking[WARM:]


def replan_rows(skill: Any, cases: list[SceneCase], rng: np.random.Generator) -> list[Row]:
    """Time to plan anew from under way, after all boxes moved a little, and afresh."""
    near, afresh, failed, tried = [], [], 0, 0
    for case in cases:
        plan = skill.plan(case.start, case.goal, obstacles=tray.arm().obstacles(case.scene))
        if not plan.success:
            continue
        here = plan.path.states[int(AT * len(plan.path))]
        for _ in range(MOVES):
            obstacles = _moved(case.scene, rng)
            if obstacles.clearance(np.stack([here, case.goal])).min() < ROOM:
                continue
            obstacles.clearance(here)  # the model is made now, not under way
            for options, taken in (({"near": plan.path.states}, near), ({}, afresh)):
                before = perf_counter()
                answer = skill.plan(here, case.goal, obstacles=obstacles, **options)
                taken.append(1e3 * (perf_counter() - before))
                failed += not answer.success
                tried += 1
    note = f"{tried} plans, {failed} without success"
    rows = []
    for name, taken, target in (("after boxes moved 2 cm", near, 8.0), ("afresh", afresh, 25.0)):
        p50, p99 = np.percentile(taken[2:], [50, 99])
        rows.append(Row(f"plan anew {name}, p99", float(p99), "ms", target, "<", "", f"median {p50:.1f} ms; {note}"))
    return rows


def hostile_row(skill: Any, case: SceneCase, rng: np.random.Generator) -> Row:
    """Share of impossible samples that are answered by a finite, bounded command in mode `holding`."""
    robot = tray.arm()
    told = []
    for name, disturb in HOSTILE.items():
        controller, _ = _controller(skill, case, rng)
        q, qd, _ = controller.reference.at(0.0)
        for i in range(100):
            controller.command(i * PERIOD, *controller.reference.at(i * PERIOD)[:2])
        q, qd, _ = controller.reference.at(0.1)
        command = controller.command(*disturb(0.1, q, qd))
        torque = np.asarray(command.torque)
        safe = np.isfinite(torque).all() and (np.abs(torque) <= robot.torque_limits + 1e-9).all()
        told.append((name, bool(safe and command.mode == "holding")))
        controller.close()
    failed = [name for name, good in told if not good]
    note = "; ".join(HOSTILE) + (f"; failed: {', '.join(failed)}" if failed else "")
    share = 1.0 - len(failed) / len(told)
    return Row("hostile samples answered by a bounded command, mode holding", share, "share", 1.0, ">=", "", note)


def _nan(t: float, q: Array, qd: Array) -> tuple[Any, Any, Any]:
    return t, np.where(np.arange(len(q)) == 2, np.nan, q), qd


HOSTILE = {
    "NaN position": _nan,
    "NaN velocity": lambda t, q, qd: (t, q, qd * np.nan),
    "infinite position": lambda t, q, qd: (t, q + np.inf, qd),
    "jump of 3 rad": lambda t, q, qd: (t, q + 3.0, qd),
    "half a second without samples": lambda t, q, qd: (t + 0.5, q, qd),
    "time running backwards": lambda t, q, qd: (t - 0.05, q, qd),
    "time that is no number": lambda t, q, qd: (np.nan, q, qd),
    "too few joints": lambda t, q, qd: (t, q[:3], qd),
    "no position at all": lambda t, q, qd: (t, None, qd),
    "text": lambda t, q, qd: (t, "here", qd),
}


def _moved(scene: "Scene", rng: np.random.Generator) -> Any:
    for name in scene.names:
        pose = np.array(scene[name].at(None), np.float64)
        step = rng.standard_normal(3)
        pose[:3] += MOVED * step / np.linalg.norm(step)
        scene = scene.moved(name, pose)
    return tray.arm().obstacles(scene)
