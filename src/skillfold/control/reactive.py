"""`ReactiveController`: holds a robot to its skill, brings it back when pushed, plans anew (sections IV-C, IV-D)."""

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from skillfold.control import layout
from skillfold.control.commands import Command
from skillfold.control.kernels import step as at
from skillfold.control.kernels.reference import splice
from skillfold.control.replanning import Inline, Planner, Question, Renewal, Worker, planner_of, timed
from skillfold.control.samples import Clock, read_sample
from skillfold.control.settings import Bounds, Gains, check, check_obstacles, thresholds, turning
from skillfold.control.timing import Reference
from skillfold.manifold.inputs import amount
from skillfold.motion import Array, Plan

if TYPE_CHECKING:
    from skillfold.clearance import Clearance
    from skillfold.robots.robot import Robot

LATENCY = 0.03  # seconds that a plan is expected to take
SPLICE = 0.15  # seconds, shortest, in which one reference leads over to the next
AGAIN = 0.2  # seconds until a plan is asked for again; twice as many each time that its path is left at once
MOST = 6  # times that these are doubled
PATIENCE = 1.0  # seconds off the manifold until a plan is asked for all the same
LOOK_AHEAD, STOP, SLOW = 1.5, 0.1, 0.5  # seconds of phase: how far to look, room to keep, room to slow down in
CALM = 0.1  # of the velocity limits: slower is nearly at rest
FOLLOW = 0.01  # seconds between looks at where moving obstacles are


class ReactiveController:
    """Follows a plan with feedback along and off the manifold of its own; `command` at every sample.

    One thread at a time. `command` does not raise, answers in bounded time with finite, bounded numbers, and never
    makes a plan itself: that is for a thread of its own (or, with `latency`, counts after so many seconds).

    Attributes:
        mode: of the last command.
        replans: plans taken up so far.
        reason: of the last plan, in words.
        goal: (D,) where it all ends.
        reference: the motion in time that is followed, see `control.timing.Reference`.
    """

    def __init__(
        self,
        skill: Any,
        plan: Plan,
        *,
        robot: "Robot | None" = None,
        obstacles: "Clearance | None" = None,
        duration: float | None = None,
        gains: Gains | None = None,
        deviation: float | None = None,
        off: float | None = None,
        reaction: float = 10.0,
        latency: float | None = None,
        planner: Planner | None = None,
        load: tuple[float, Any] = (0.0, (0.0, 0.0, 0.0)),
    ) -> None:
        """Get ready to follow a plan.

        Args:
            skill: the `SkillManifold` it was made with; coordinates must be joint positions, or at least subtract.
            plan: with success, within the limits of skill and robot.
            robot: whose limits are kept and whose dynamics turn accelerations into torques; None for accelerations.
            obstacles: what to look out for, `robot.obstacles(scene)`; those with a motion are where they are at the
                time of each sample.
            duration: of the motion [s]; left out, about the shortest within limits.
            gains: left out, those of `Gains`.
            deviation: from the reference along the manifold that calls for a new plan; left out, 0.15 times the
                demonstrations' radius.
            off: distance from the manifold that does; left out, 0.05 of it, at least three times the skill's
                tolerance.
            reaction: times the limits of acceleration that feedback may use: pushes exceed them too.
            latency: seconds of the samples' time after which a plan counts that is made at once, so that runs can be
                repeated bit by bit; None plans in a thread.
            planner: called with start, goal and obstacles instead of the skill's `plan`, which plans geodesics.
            load: mass [kg] at the tool and its centre (3,) [m] in the tool frame.

        Raises:
            InputError: a plan without success or beyond the limits, a robot of other joints, coordinates that do not
                subtract, a duration too short for the limits, or what else cannot be used.
        """
        check(skill, plan, robot, gains, planner, load)
        model = skill.model
        self.goal: Array = plan.path.states[-1].copy()
        self.mode, self.replans, self.reason = "tracking", 0, plan.reason
        self._bounds = Bounds.of(skill, robot)
        numbers = (gains or Gains()).numbers(model.scale)
        reaction = amount("reaction", reaction, np.inf)
        self._table = layout.table_for(model, self._bounds, reaction, numbers, turning(skill, robot))
        self._memory, self._entries = self._table.arrays[at.MEMORY], self._table.entries
        self._sample = self._table.arrays[at.Q], self._table.arrays[at.QD]
        self._answer = self._table.arrays[at.ACCELERATION], self._table.arrays[at.TORQUE]
        self._wanted, self._foot = self._table.arrays[at.REFERENCE], self._table.arrays[at.FOOT]
        self._deviation, self._off = thresholds(skill, deviation, off)
        self._skill, self._planner = skill, planner
        self._plans = Worker(LATENCY) if latency is None else Inline(amount("latency", latency, zero=True))
        self._work = np.zeros((2, 3, model.n_dims))
        self._base, self._clock, self._since = "tracking", Clock(), 0.0
        self._away = self._stale = False  # the reference has left its path; a plan under way is of no use
        self._again = self._followed = self._taken = self._led = self._lost = -np.inf  # seconds
        self._vain, self._found = 0, True  # paths left at once, in a row; whether the last plan was found
        self._begin(plan, duration, obstacles, robot, load)

    def _begin(self, plan: Plan, duration: float | None, obstacles: Any, robot: Any, load: Any) -> None:
        memory = self._memory
        still = np.zeros(len(self.goal))
        self.update(obstacles)
        self.reference, memory[at.KEEP] = timed(plan.path.states, still, self._obstacles, self._bounds, duration)
        layout.put_reference(self._table, self.reference)
        self._unhurried = self._bounds.slower(self.reference.pace)
        np.multiply(self._table.arrays[at.EASE], self.reference.pace, out=self._table.arrays[at.EASE])
        memory[at.BRAKE] = self._bounds.brake
        memory[at.HORIZON], memory[at.LEAP], memory[at.FASTEST] = LOOK_AHEAD, 0.2, self._bounds.fastest
        for slot in (at.Q, at.GOOD, at.LAST, at.SEEN, at.FOOT):
            self._table.arrays[slot][:] = plan.path.states[0]
        self._wanted[0] = plan.path.states[0]
        self._torque = robot is not None
        if robot is not None:
            self._dynamics = robot.dynamics(*load).compiled()
            layout.put_dynamics(self._table, self._dynamics)
        # Compiled here, not under way.
        at.find_foot(self._entries)
        at.answer(self._entries, 0.0, 1.0, at.sort(self._entries, 0.0, True, False))
        self._splice(self.reference, self.reference.knots.copy())

    @property
    def obstacles(self) -> "Clearance | None":
        """What is looked out for; may be replaced under way."""
        return self._obstacles

    @obstacles.setter
    def obstacles(self, obstacles: "Clearance | None") -> None:
        self.update(obstacles)

    def update(self, obstacles: "Clearance | None") -> None:
        """Look out for other obstacles from now on; what are none are refused, and change nothing."""
        check_obstacles(obstacles)
        self._obstacles = obstacles
        self._moves = hasattr(obstacles, "at") and bool(getattr(obstacles, "moves", True))
        self._follow(self._clock.time, obstacles)
        layout.look_anew(self._table)

    def command(self, t: Any, q: Any, qd: Any) -> Command:
        """What to do, for a sample of time t [s], positions q (D,) and velocities qd (D,).

        A sample that cannot be used (of another shape, not finite, far from the last one, too long after or before
        it) is answered by holding still.
        """
        elapsed, hold = self._clock.tick(t)
        self._memory[at.INTERVAL], now = self._clock.interval, self._clock.now
        given = read_sample((q, qd), self._sample)  # looked at more closely by the step
        if self._moves and now - self._followed >= FOLLOW:
            self._move(now)
        renewal = self._plans.take(now)
        if renewal is not None:
            self._take(renewal, now)
        kind = at.sort(self._entries, elapsed, hold, given)
        if kind == at.USED:
            self._find_foot(now)
        at.answer(self._entries, elapsed, self._target(), kind)
        self._judge(kind, now)
        memory, (acceleration, torque) = self._memory, self._answer
        return Command(
            torque.copy() if self._torque else None,
            self.mode,
            acceleration.copy(),
            self._wanted.copy(),
            max(float(memory[at.DISTANCE]), self._way_back(now)),
            float(memory[at.DEVIATION]),
            float(memory[at.CLEARANCE]),
        )

    def close(self) -> None:
        """End the thread that plans, if there is one."""
        self._plans.close()

    @property
    def done(self) -> bool:
        """Whether the reference has come to its end."""
        return bool(not self._away and self._memory[at.PHASE] >= self._memory[at.DURATION])

    def _find_foot(self, now: float) -> None:
        """The foot of the sample: of several sheets of the surface, on the path's, or else where it was."""
        if now <= self._lost:
            self._foot[:] = self._wanted[0]
            return
        if not self._away and now > self._led:
            self._foot[:] = self._wanted[0]
        at.find_foot(self._entries)

    def _way_back(self, now: float) -> float:
        """How far it is to the path where that is gone to straight, off the manifold; else nothing."""
        return float(np.linalg.norm(self._path[0] - self._sample[0])) if now <= self._lost else 0.0

    def _target(self) -> float:
        """Rate that the reference should go on at; below zero it gives way."""
        if self._away:
            return -1.0
        blocked = self._memory[at.BLOCKED]
        if blocked == np.inf:
            return 1.0
        room = blocked - self._memory[at.PHASE] - STOP - 3.0 / self._memory[at.BRAKE]
        return min(max(room / SLOW, 0.0), 1.0)

    def _judge(self, kind: int, now: float) -> None:
        """Mode of this step; asks for a plan where one is needed."""
        if kind != at.USED:
            self.mode = "holding"
            return
        distance, deviation = self._memory[at.DISTANCE], self._memory[at.DEVIATION]
        # While the reference is led over to a new path that begins at the arm, it is the reference that is away.
        most = self._off if now > self._lost else max(self._off, self._deviation)
        pushed = distance > most or (deviation > self._deviation and now > self._led)
        if pushed and not self._away:
            self._leave(now)
        self.mode = "returning" if self._away or now <= self._lost else self._base
        if self._plans.pending or now < self._again:
            return
        back = distance < 0.5 * self._off and deviation < 0.5 * self._deviation
        if self._away and (back or now - self._since > PATIENCE) and self._calm():
            self._ask(self._foot.copy(), now)
        elif not self._away and self._memory[at.BLOCKED] < np.inf:
            ahead = self._memory[at.PHASE] + self._memory[at.RATE] * self._plans.latency
            self._ask(self.reference.at(ahead)[0], now)

    def _leave(self, now: float) -> None:
        """Pushed off the path: the reference gives way."""
        self._vain = min(self._vain + 1, MOST) if now - self._taken < PATIENCE else 0
        self._again = now + AGAIN * 2**self._vain
        if self._vain > 1:
            self.reason = f"Thrown off path after path at once; rests before the next. ({self.reason})"
        self._away, self._stale, self._since, self._lost = True, self._plans.pending, now, -np.inf

    def _calm(self) -> bool:
        """Whether the reference has come near to rest: the push has ceased, or goes nowhere."""
        return bool((np.abs(self._wanted[1]) < CALM * self._table.arrays[at.VELOCITY]).all())

    def _ask(self, start: Array, now: float) -> None:
        obstacles: Any = self._obstacles
        if self._moves:
            with suppress(Exception):
                obstacles = obstacles.at(self._clock.time)
        done = int((self._memory[at.PHASE] - self._delay) / self.reference.step)
        rest = self._path[min(max(done, 0), len(self._path) - 2) :].copy()
        # Back from a push the new motion begins at rest, and can wait until the arm is there.
        velocity = np.zeros(len(start)) if self._away else self._wanted[1].copy()
        planner, back = self._planner or planner_of(self._skill, rest), rest if self._away else None
        self._plans.ask(Question(start, velocity, self.goal, obstacles, self._unhurried, planner, back), now)

    def _take(self, renewal: Renewal, now: float) -> None:
        """Follow a new plan, led over to smoothly."""
        self.reason, self._again = renewal.reason, now + AGAIN
        if self._stale:
            self._stale, self._again = False, now
            return
        if renewal.reference is None:
            return
        # Where no plan leads on from the foot, or it belongs to no part that is sure, the path is gone to straight.
        lost = self._away and (renewal.moved > self._off or not (renewal.planned or self._found))
        self._found, self._taken = renewal.planned, now
        taken, delay = self._splice(renewal.reference, renewal.reference.knots)
        self._led = now + taken
        self._lost = self._led if lost else -np.inf
        self.reference = replace(renewal.reference, duration=renewal.reference.duration + delay)
        layout.put_reference(self._table, self.reference)
        self._memory[at.KEEP] = renewal.keep
        self._away = False
        if renewal.planned:
            self.replans += 1
            self._base = "replanned"

    def _splice(self, reference: Reference, knots: Array) -> tuple[float, float]:
        """Lead over to the knots of a reference, in place; seconds that takes, and by which it begins later."""
        limits, count = self._unhurried, round(reference.duration / reference.step)
        spare, self._path = len(knots) - 1 - count, knots[: count + 2, 0].copy()
        speed, rise = limits.velocity, limits.acceleration
        taken, delay = splice(knots, reference.step, self._wanted, SPLICE, spare, speed, rise, self._work)
        self._delay = delay * reference.step
        return taken, self._delay

    def _move(self, now: float) -> None:
        self._followed = now
        if hasattr(self._here, "place"):
            self._here.place(self._compiled, self._clock.time or 0.0)
            return
        with suppress(Exception):  # obstacles of the user's may fail in any way, and then are where they were
            self._follow(self._clock.time, self._obstacles)

    def _follow(self, time: float | None, obstacles: Any) -> None:
        """Put moving obstacles where they are at a time [s]."""
        self._here = obstacles.at(time) if self._moves else obstacles
        self._compiled = None if obstacles is None else self._here.compiled()
        layout.put_obstacles(self._table, self._compiled)
