"""`simulate`: a controller in closed loop with MuJoCo."""

from collections.abc import Iterable
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from skillfold.control.pushes import Push
from skillfold.control.rollout import Contact, Rollout
from skillfold.errors import InputError
from skillfold.manifold.inputs import amount, seed_of
from skillfold.motion import Array
from skillfold.robots.engine import listening
from skillfold.robots.poses import read_numbers
from skillfold.robots.robot import Robot
from skillfold.robots.tray import Tray
from skillfold.robots.world import World

SETTLE = 0.5  # seconds that a run goes on after the reference has ended
LONGEST = 60.0  # seconds of a run whose end nobody told
LARGEST = 1e5  # seconds of any run
COARSEST = 0.1  # seconds of a step


class Controller(Protocol):
    """Anything that answers samples with torques."""

    def command(self, t: float, q: Any, qd: Any, /) -> Any:
        """Answer with `torque` (D,) and `mode`; `distance` where it knows a manifold."""
        ...


def simulate(
    robot: Robot,
    controller: Controller,
    scene: Any = None,
    pushes: Iterable[Push] = (),
    seed: int = 0,
    duration: float | None = None,
    *,
    start: Any = None,
    tray: Tray | None = None,
    noise: float = 0.0,
    step: float = 1e-3,
) -> Rollout:
    """Run a controller on a simulated robot, with torques held for a step each.

    Args:
        robot: with a fixed base.
        controller: such as `ReactiveController`; with `reference` and `done` it tells where to start and when to end.
        scene: shapes the robot can really touch; those with a motion follow it.
        pushes: forces on it.
        seed: of the noise; nothing else is random.
        duration: of the run [s]; left out, until half a second after the controller is done and the pushes are over,
            60 s at most.
        start: (D,) positions, at rest; left out, where the controller's reference begins.
        tray: carried by the tool.
        noise: standard deviation [rad, m] of the positions that the controller sees; velocities get ten times as
            much.
        step: of the controller [s]; the dynamics go on in steps of a millisecond at most.

    Raises:
        InputError: a floating base, an unknown body, no start, torques that are none, a run that becomes unstable, or
            what else cannot be used; of the scene a `SceneError`.
    """
    step, noise = amount("step", step, COARSEST), amount("noise", noise, zero=True)
    duration = None if duration is None else amount("duration", duration, LARGEST, zero=True)
    _check(robot, controller)
    world = World(robot, scene, tray, step)
    run = _Run(world, controller, _listed(pushes), np.random.default_rng(seed_of(seed)), noise)
    world.reset(_start(robot, controller, start))
    count = round((LONGEST if duration is None else duration) / step)
    with listening():
        for i in range(max(count, 1)):
            run.step(i * step)
            if duration is None and run.settled(i * step):
                break
    return run.rollout({"seed": seed, "noise": noise, "step": step})


def _start(robot: Robot, controller: Any, start: Any) -> Array:
    if start is None:
        reference = getattr(controller, "reference", None)
        if reference is None:
            raise InputError("start: the controller has no reference; expected positions to start from.")
        start = reference.at(0.0)[0]
    q = read_numbers(start, "start", f"{robot.dof} finite joint positions")
    if q.shape != (robot.dof,):
        raise InputError(f"start of shape {q.shape}; expected {robot.dof} finite joint positions.")
    return q


def _listed(pushes: Any) -> tuple[Push, ...]:
    pushes = tuple(pushes) if isinstance(pushes, Iterable) else (pushes,)
    for push in pushes:
        if not isinstance(push, Push):
            raise InputError(f"pushes: {push!r:.40}; expected a list of Push.")
    return pushes


def _check(robot: Any, controller: Any) -> None:
    if not isinstance(robot, Robot):
        raise InputError(f"robot: {type(robot).__name__}; expected a Robot, as Robot.load('lwr4') makes one.")
    if not hasattr(controller, "command"):
        raise InputError(f"controller: {type(controller).__name__}; expected one with command(t, q, qd).")


class _Run:
    """A run under way."""

    def __init__(
        self,
        world: World,
        controller: Controller,
        pushes: tuple[Push, ...],
        rng: np.random.Generator,
        noise: float,
    ) -> None:
        self.world, self.controller, self.rng, self.noise = world, controller, rng, noise
        self.pushes = [(world.body(push.body), push) for push in pushes]
        carrier = world.robot if world.tray is None else world.robot.with_tray(world.tray)
        self.obstacles = carrier.obstacles(world.scene).at(0.0)
        self.compiled = self.obstacles.compiled()
        self.limits = world.robot.torque_limits
        self.rows: list[tuple[Any, ...]] = []
        self.open: dict[tuple[str, str], float] = {}
        self.contacts: list[Contact] = []
        self.ended: float | None = None

    def step(self, time: float) -> None:
        """One sample, one answer, one step."""
        world = self.world
        world.move_obstacles(time)
        q, qd = world.data.qpos[world.places], world.data.qvel[world.dofs]
        seen = self._seen(q, qd)
        before = perf_counter()
        command = self.controller.command(time, *seen)
        taken = perf_counter() - before
        torque = self._torque(command)
        self._push(time)
        self._touch(time)
        distance = getattr(command, "distance", np.nan)
        self.rows.append((time, q, qd, torque, command.mode, distance, world.tumblers(), taken, self._clear(time, q)))
        world.advance(torque)
        if not world.stable:
            raise InputError(
                f"The simulation became unstable at {time:g} s: smaller pushes, torques or steps may do."
            )

    def _torque(self, command: Any) -> Array:
        try:
            torque = np.clip(np.asarray(command.torque, np.float64), -self.limits, self.limits)
        except (AttributeError, TypeError, ValueError):
            torque = np.full(1, np.nan)
        if torque.shape != self.limits.shape or not np.isfinite(torque).all():
            given = repr(getattr(command, "torque", command))
            raise InputError(
                f"The controller answers with torques {' '.join(given.split()):.60}; expected {self.limits.size} "
                "finite numbers. A ReactiveController tells torques if it is made with robot=..."
            )
        return torque

    def settled(self, time: float) -> bool:
        """Whether nothing more is to come."""
        if not getattr(self.controller, "done", False) or any(time < push.end for _, push in self.pushes):
            self.ended = None
        elif self.ended is None:
            self.ended = time
        return self.ended is not None and time - self.ended >= SETTLE

    def rollout(self, facts: dict[str, Any]) -> Rollout:
        """What happened."""
        times, q, qd, torques, modes, distances, tumblers, taken, clear = zip(*self.rows, strict=True)
        self.contacts += [Contact(*pair, since, times[-1]) for pair, since in self.open.items()]
        states, robot = np.array(q), self.world.robot
        return Rollout(
            np.array(times),
            states,
            np.array(qd),
            np.array(torques),
            np.array(modes),
            np.array(distances, np.float64),
            np.array(clear),
            robot.forward(states),
            np.array(tumblers),
            np.array(taken),
            tuple(self.contacts),
            robot.names,
            {"robot": robot.name, "replans": int(getattr(self.controller, "replans", 0)), **facts},
        )

    def _seen(self, q: Array, qd: Array) -> tuple[Array, Array]:
        if not self.noise:
            return q, qd
        return q + self.rng.normal(0, self.noise, q.shape), qd + self.rng.normal(0, 10 * self.noise, q.shape)

    def _push(self, time: float) -> None:
        if self.pushes:
            self.world.data.xfrc_applied[:] = 0.0
        for body, push in self.pushes:
            self.world.data.xfrc_applied[body, :3] += push.at(time)

    def _clear(self, time: float, q: Array) -> float:
        if self.obstacles.moves:
            self.obstacles.place(self.compiled, time)
        return float(self.obstacles.clearance(q))

    def _touch(self, time: float) -> None:
        """Keep when pairs begin and cease to touch."""
        now = self.world.contacts()
        for pair in [pair for pair in self.open if pair not in now]:
            self.contacts.append(Contact(*pair, self.open.pop(pair), time))
        for pair in now:
            self.open.setdefault(pair, time)
