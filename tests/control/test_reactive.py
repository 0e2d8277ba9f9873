"""The controller: it follows, comes back, plans anew, keeps limits, and nothing it is told can break it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skillfold as sf
from control.loops import STEP, pulse, run
from skillfold.control.settings import Gains
from skillfold.errors import InputError
from skillfold.motion import Path

PUSH = pulse(0.3, 0.45, [60.0, -50.0, 60.0])  # against feedback of two times the limits, 15


def test_it_follows_the_plan_on_the_manifold(make, plan, skill):
    controller = make()
    trace = run(controller, plan.path.states[0], controller.reference.duration + 0.5)
    assert set(trace.modes) == {"tracking"}
    assert skill.distance(trace.states).max() < 2e-3
    assert np.linalg.norm(trace.states[-1] - controller.goal) < 5e-3
    assert controller.done and controller.replans == 0


def test_pushed_far_it_returns_plans_anew_and_arrives(make, plan, skill):
    controller = make(reaction=2.0)
    trace = run(controller, plan.path.states[0], 5.0, PUSH)
    assert skill.distance(trace.states).max() > 0.1
    assert list(dict.fromkeys(trace.modes)) == ["tracking", "returning", "replanned"]
    assert controller.replans >= 1
    assert np.linalg.norm(trace.states[-1] - controller.goal) < 1e-2
    assert skill.distance(trace.states[-1]) < 1e-3


def test_the_reference_never_jumps(make, plan):
    controller = make(reaction=2.0)
    trace = run(controller, plan.path.states[0], 4.0, PUSH)
    assert controller.replans >= 1
    x, v, a = trace.references.transpose(1, 0, 2)
    assert np.abs(np.diff(x, axis=0) - STEP * 0.5 * (v[1:] + v[:-1])).max() < 1e-5
    assert np.abs(np.diff(v, axis=0)).max() < 1.1 * STEP * 15.0
    followed = np.array([mode != "returning" for mode in trace.modes])
    smooth = followed[1:] & followed[:-1]  # while it gives way, accelerations may jump
    assert np.abs(np.diff(v, axis=0) - STEP * 0.5 * (a[1:] + a[:-1]))[smooth].max() < 2e-3
    assert np.abs(np.diff(a, axis=0))[smooth].max() < 2.0  # of limits of 15


def test_the_reference_keeps_the_limits(make, plan, planar):
    trace = run(make(reaction=2.0), plan.path.states[0], 4.0, PUSH)
    assert (np.abs(trace.references[:, 1]) <= 1.01 * planar.velocity_limits).all()
    assert (np.abs(trace.references[:, 2]) <= 1.05 * planar.acceleration_limits).all()


def test_torques_and_reactions_are_bounded(make, plan, planar):
    controller = make(reaction=3.0)
    q, trace = plan.path.states[0], []
    for i in range(400):
        trace.append(
            controller.command(i * STEP, q + 0.15 * np.sin(40 * i * STEP), 6.0 * np.cos(40 * i * STEP) + 0 * q)
        )
    assert (np.abs([c.torque for c in trace]) <= planar.torque_limits).all()
    assert (np.abs([c.acceleration for c in trace]) <= 3.0 * planar.acceleration_limits + 1e-9).all()


def test_velocities_come_back_within_their_limits(make, plan, planar):
    trace = run(make(), plan.path.states[0], 2.0, pulse(0.3, 0.4, [80.0, 80.0, 80.0]))
    fast = (np.abs(trace.velocities) > 1.02 * planar.velocity_limits).any(1)
    assert fast[300:450].any() and not fast[500:].any()


def test_along_the_manifold_it_yields_and_off_it_it_does_not(make, plan, skill):
    start = skill.project(plan.path.states[0])
    tangents = skill.tangent(start)
    normal = np.linalg.svd(tangents)[0][:, 2]
    # The path is made to rest, so that nothing but the push moves the arm.
    still = replace(plan, path=Path(np.repeat(start[None], 3, axis=0)))
    moved = []
    for direction in (tangents[:, 0], normal):
        controller = sf.ReactiveController(skill, still, latency=0.03, deviation=9.0, off=9.0)
        trace = run(controller, start, 1.0, pulse(0.1, 1.0, 4.0 * direction))
        moved.append(np.linalg.norm(trace.states[-1] - start))
    assert moved[0] > 0.015 and moved[1] < 0.004


def test_the_same_run_gives_the_same_bits(make, plan):
    one, two = (run(make(reaction=2.0), plan.path.states[0], 2.0, PUSH) for _ in range(2))
    assert np.array_equal(one.states, two.states) and one.modes == two.modes
    assert np.array_equal(one.accelerations, two.accelerations)


def test_plans_made_in_a_thread_are_taken_up(make, plan):
    controller = make(latency=None, reaction=2.0)
    q, qd, t = plan.path.states[0].copy(), np.zeros(3), 0.0
    while t < 4.0 and not (controller.replans and controller.done):
        command = controller.command(t, q, qd)
        qd = qd + STEP * (command.acceleration + PUSH(t))
        q, t = q + STEP * qd, t + STEP
        if controller._plans.pending:
            controller._plans._made.exception(10.0)  # waits
    controller.close()
    assert controller.replans >= 1
    assert controller.command(t, q, qd).mode == "replanned"


@pytest.mark.parametrize("reason", ["RuntimeError: out of luck", "No way."])
def test_without_a_new_plan_it_goes_back_to_what_is_left_of_the_old_one(make, plan, reason):
    def planner(start, goal, obstacles):
        if "Runtime" in reason:
            raise RuntimeError("out of luck")
        return replace(plan, success=False, reason=reason)

    controller = make(planner=planner, reaction=2.0)
    trace = run(controller, plan.path.states[0], 6.0, PUSH)
    assert controller.reason == reason and controller.replans == 0
    assert list(dict.fromkeys(trace.modes)) == ["tracking", "returning"] and trace.modes[-1] == "tracking"
    assert np.linalg.norm(trace.states[-1] - controller.goal) < 2e-2


def test_the_foot_is_on_the_sheet_of_the_path(make, plan, skill):
    """Where the surface has several sheets, one foot after the other would keep to any."""
    controller, start = make(), plan.path.states[0]
    controller._foot[:] = skill.project(start + np.array([2.0, -2.0, 2.0]))
    assert controller.command(0.0, start, np.zeros(3)).distance < 1e-6
    assert np.linalg.norm(controller._foot - start) < 1e-3


def test_from_a_foot_that_is_none_it_goes_straight_to_the_path(make, plan, skill):
    """The plan finds its start far off the manifold: it says so as long as it is on the way, and arrives."""
    first = skill.plan(plan.path.states[0], plan.path.states[-1])

    def planner(start, goal, obstacles):
        return replace(first, start_moved=float(np.linalg.norm(first.path.states[0] - start)))

    controller = make(planner=planner, reaction=2.0)
    trace = run(controller, plan.path.states[0], 6.0, PUSH)
    on_the_way = controller.replans and [c for c in trace.commands if c.mode == "returning"][-1]
    assert on_the_way.distance >= np.linalg.norm(
        first.path.states[0] - trace.states[trace.modes.index("replanned") - 1]
    )
    assert np.linalg.norm(trace.states[-1] - controller.goal) < 2e-2 and controller.replans == 1


def test_thrown_off_again_and_again_it_rests_longer_each_time(make, plan, skill):
    asked = []

    def planner(start, goal, obstacles):
        asked.append(start)
        return skill.plan(start, goal)

    controller = make(planner=planner, reaction=2.0)
    kick = np.array([60.0, -50.0, 60.0])

    def push(t):
        return kick if controller.mode == "replanned" or 0.3 <= t < 0.45 else np.zeros(3)

    run(controller, plan.path.states[0], 12.0, push)
    assert 4 <= len(asked) <= 8 and controller.reason.startswith("Thrown off")
    trace = run(controller, controller._sample[0].copy(), 20.0, rate=STEP)
    assert trace.modes[-1] == "replanned" and np.linalg.norm(trace.states[-1] - controller.goal) < 2e-2


def test_what_is_left_of_a_path_is_without_the_lead_over_to_it(make, plan):
    """Else a second push on the way back would leave nothing but that way."""
    asked = []

    def planner(start, goal, obstacles):
        asked.append(start)
        return replace(plan, success=False, reason="No way.")

    controller = make(planner=planner, reaction=2.0)
    run(controller, plan.path.states[0], 3.0, PUSH)
    whole = controller._path
    assert asked and np.abs(whole[:, None] - plan.path.states).sum(2).min(1).max() < 0.1


def test_planners_and_obstacles_that_fail_do_not_stop_it(make, plan):
    def planner(start, goal, obstacles):
        return replace(plan, path=Path(np.zeros((3, 2))))

    class Fading(Wall):
        def at(self, time):
            if time:
                raise RuntimeError("gone")
            return self

    controller = make(planner=planner, obstacles=Fading(plan.path.states[30], 0.12))
    trace = run(controller, plan.path.states[0], 1.5)
    assert np.isfinite([command.torque for command in trace.commands]).all()
    assert controller.reason == "The planner's path has 2 coordinates."


def test_closed_it_goes_on_without_new_plans(make, plan):
    controller = make(latency=None, reaction=2.0)
    controller.close()
    trace = run(controller, plan.path.states[0], 1.0, PUSH)
    assert controller.replans == 0 and "returning" in trace.modes


class Wall:
    """Obstacles in the space of states: a ball."""

    def __init__(self, center, radius, margin=0.05):
        self.ball, self.radius, self.margin = np.array(center), radius, margin
        self.bounds = np.full(3, -np.inf), np.full(3, np.inf)

    def clearance(self, q):
        return np.linalg.norm(np.asarray(q) - self.ball, axis=-1) - self.radius

    def nearest(self, q):
        return "ball"

    def compiled(self):
        return compiled_ball(self)


def compiled_ball(wall):
    from skillfold.clearance import Compiled
    from skillfold.jit import pointer

    def clearance(q, gradient, arguments):
        total = 0.0
        for c in range(3):
            total += (q[c] - 1e-9 * arguments[c]) ** 2
        return total**0.5 - 1e-9 * arguments[3]

    row = np.empty(0)
    arguments = np.round(1e9 * np.append(wall.ball, wall.radius)).astype(np.int64)
    return Compiled(pointer(clearance, 0.0, row, row, arguments), None, None, arguments, 1, False, wall)


def around(skill, wall):
    """A planner of the test's own: by way of states beside the ball, the first that is clear."""

    def planner(start, goal, obstacles):
        ways = [skill.plan(start, goal, via=[via]) for via in skill.sample(60, 3)]
        clear = [plan for plan in ways if plan.success and obstacles.clearance(plan.path.states).min() > 0.05]
        return min(clear, key=lambda plan: plan.length)

    return planner


def test_what_appears_on_the_path_is_seen_and_gone_around(make, plan, skill):
    wall = Wall(plan.path.states[30], 0.12)
    controller = make(planner=around(skill, wall))

    def appear(t):
        if controller.obstacles is None and t >= 0.1:
            controller.obstacles = wall

    trace = run(controller, plan.path.states[0], 6.0, change=appear)
    assert controller.replans >= 1 and "replanned" in trace.modes
    assert wall.clearance(trace.states).min() > 0.0
    assert np.linalg.norm(trace.states[-1] - controller.goal) < 1e-2
    assert min(command.clearance for command in trace.commands) == pytest.approx(
        wall.clearance(trace.states[101:]).min(), abs=1e-6
    )
    x, v, _ = trace.references.transpose(1, 0, 2)
    assert np.abs(np.diff(x, axis=0) - STEP * 0.5 * (v[1:] + v[:-1])).max() < 1e-5


def test_where_there_is_no_way_it_stops_before_the_obstacle(make, plan):
    wall = Wall(plan.path.states[30], 0.12)

    def planner(start, goal, obstacles):
        return replace(plan, success=False, reason="No way.")

    controller = make(obstacles=wall, planner=planner)
    trace = run(controller, plan.path.states[0], 3.0)
    assert wall.clearance(trace.states).min() > 0.0
    assert np.linalg.norm(trace.velocities[-1]) < 1e-3 and controller.replans == 0
    assert controller.reason == "No way."
    controller.update(None)  # and goes on once it is gone
    q, qd = trace.states[-1], np.zeros(3)
    for i in range(3000, 6000):
        command = controller.command(i * STEP, q, qd)
        q, qd = command.reference[:2]
    assert np.linalg.norm(q - controller.goal) < 1e-2


def test_obstacles_that_know_nothing_but_a_time_are_followed(make, plan):
    class Coming(Wall):
        def at(self, time):
            away = 0.0 if time and time >= 0.1 else 5.0
            return Wall(self.ball + away, self.radius)

    def planner(start, goal, obstacles):
        return replace(plan, success=False, reason="No way.")

    wall = Coming(plan.path.states[30], 0.12)
    trace = run(make(obstacles=wall, planner=planner, duration=2.0), plan.path.states[0], 2.5)
    assert trace.commands[50].clearance > 3.0
    assert wall.clearance(trace.states).min() > 0.0 and np.linalg.norm(trace.velocities[-1]) < 1e-3


def test_moving_obstacles_are_followed(make, plan, planar):
    tool = planar.forward(plan.path.states[30])[:3]
    high = tool + np.array([0.0, 0.0, 2.0])
    away = sf.Motion([0.0, 0.1, 0.3], [high, high, tool])
    ball = sf.Sphere(center=tool, radius=0.04, motion=away)
    asked = []

    def planner(start, goal, obstacles):
        asked.append(obstacles.time)
        return replace(plan, success=False, reason="No way.")

    controller = make(obstacles=planar.obstacles([ball], self_collision=False), planner=planner, duration=3.0)
    trace = run(controller, plan.path.states[0], 2.5)
    assert asked and min(asked) > 0.1
    assert trace.commands[100].clearance > 1.0
    still = planar.obstacles([ball], self_collision=False).at(2.5)
    assert trace.commands[-1].clearance == pytest.approx(still.clearance(trace.states[-1]))
    assert trace.commands[-1].clearance > 0.0


def test_without_a_robot_it_answers_accelerations(skill, plan):
    controller = sf.ReactiveController(skill, plan, latency=0.03)
    trace = run(controller, plan.path.states[0], controller.reference.duration + 1.0)
    assert trace.commands[0].torque is None
    assert np.linalg.norm(trace.states[-1] - controller.goal) < 5e-3


HOSTILE = st.one_of(
    st.none(),
    st.text(max_size=3),
    st.floats(allow_nan=True, allow_infinity=True),
    st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=0, max_size=4),
    st.just(np.full(3, np.nan)),
    st.just(np.full((3, 3), 0.1)),
    st.just(np.array([1 + 2j, 0, 0])),
    st.just(np.array(["a", "b", "c"])),
    st.just([10**400, 0, 0]),
    st.just(np.array([3.0, 3.0, 3.0])),
)
TIMES = st.one_of(st.none(), st.text(max_size=2), st.floats(allow_nan=True, allow_infinity=True), st.just(10**400))


@given(samples=st.lists(st.tuples(TIMES, HOSTILE, HOSTILE), min_size=1, max_size=12))
@settings(max_examples=60, deadline=None)
def test_no_sample_breaks_it_and_it_recovers(samples, controllers):
    controller, start, planar = controllers
    t = (controller._clock.time or 0.0) + 1.0
    for time, q, qd in samples:
        command = controller.command(time, q, qd)
        assert np.isfinite(command.torque).all() and np.isfinite(command.acceleration).all()
        assert (np.abs(command.torque) <= planar.torque_limits).all()
        assert command.mode in ("tracking", "returning", "replanned", "holding")
    for i in range(60):
        command = controller.command(t + i * STEP, start, np.zeros(3))
    assert command.mode != "holding"


@pytest.fixture(scope="module")
def controllers(skill, plan, planar):
    controller = sf.ReactiveController(skill, plan, robot=planar, latency=0.03)
    return controller, plan.path.states[0], planar


@pytest.mark.parametrize("spoil", ["nan", "jump", "gap", "backwards", "shape", "same"])
def test_bad_samples_hold_and_good_ones_go_on(make, plan, spoil):
    controller, start = make(), plan.path.states[0]
    q, qd, modes, t = start.copy(), np.zeros(3), [], 0.0
    for i in range(3000):
        t += STEP
        bad = 300 <= i < 320
        seen, time = q, t
        if bad and spoil == "nan":
            seen = np.full(3, np.nan)
        elif bad and spoil == "jump":
            seen = q + 3.0 * (-1) ** i
        elif bad and spoil == "shape":
            seen = q[:2]
        elif bad and spoil == "backwards":
            time = t - 0.1 * (i - 299)
        elif spoil == "gap" and i == 300:
            t = time = t + 0.3
        command = controller.command(time, seen, qd)
        modes.append(command.mode)
        qd = qd + STEP * command.acceleration
        q = q + STEP * qd
        if bad and spoil == "same":
            assert controller.command(time, seen, qd).mode == "tracking"
    if spoil != "same":
        assert modes[300] == "holding"
    assert modes[299] == "tracking" and "holding" not in modes[360:]
    assert np.linalg.norm(q - controller.goal) < 1e-2


def test_it_plans_anew_though_time_was_set_back(make, plan):
    controller = make(reaction=2.0)
    q, qd = plan.path.states[0].copy(), np.zeros(3)
    for i in range(4000):
        t = 1000.0 + i * STEP if i < 250 else i * STEP
        command = controller.command(t, q, qd)
        qd = qd + STEP * (command.acceleration + PUSH(i * STEP))
        q = q + STEP * qd
    assert controller.replans >= 1 and np.linalg.norm(q - controller.goal) < 1e-2


def test_held_long_the_arm_rests(make, plan, planar):
    controller = make()
    trace = run(controller, plan.path.states[0], 0.4)
    q, qd = trace.states[-1].copy(), trace.velocities[-1].copy()
    for _ in range(2000):
        command = controller.command(None, q, qd)
        assert command.mode == "holding"
        qd = qd + STEP * command.acceleration
        q = q + STEP * qd
    assert np.linalg.norm(qd) < 1e-3


def test_continuous_joints_may_be_told_a_turn_off(skill, plan, planar):
    class Turning:
        name, dof = planar.name, 3
        space = sf.StateSpace.continuous(3)
        limits, velocity_limits = planar.limits, planar.velocity_limits
        acceleration_limits, torque_limits = planar.acceleration_limits, planar.torque_limits
        dynamics = planar.dynamics

    start = plan.path.states[0]
    one = sf.ReactiveController(skill, plan, robot=Turning(), latency=0.03)
    two = sf.ReactiveController(skill, plan, robot=Turning(), latency=0.03)
    a = one.command(0.0, start, np.zeros(3))
    b = two.command(0.0, start + 2 * np.pi * np.array([1, -1, 2]), np.zeros(3))
    assert b.mode == "tracking" and np.allclose(a.torque, b.torque, atol=1e-6)


def test_what_cannot_be_controlled_is_told(skill, plan, planar):
    with pytest.raises(InputError, match="without success"):
        sf.ReactiveController(skill, replace(plan, success=False, reason="No way."))
    with pytest.raises(InputError, match="7 joints"):
        sf.ReactiveController(skill, plan, robot=sf.Robot.load("lwr4"))
    with pytest.raises(InputError, match="coordinates"):
        sf.ReactiveController(skill, replace(plan, path=Path(np.zeros((3, 2)))))
    with pytest.raises(InputError, match="positive"):
        sf.ReactiveController(skill, plan, gains=Gains(along=-1.0))


def test_paths_beyond_the_robots_limits_are_refused(make, skill, plan, planar):
    """Else the arm would stop short of the goal and say nothing."""

    class Narrow:
        def __getattr__(self, name):
            return getattr(planar, name)

        limits = planar.limits._replace(upper=plan.path.states.max(0) - [0.0, 0.1, 0.0])

    with pytest.raises(InputError, match=r"has coordinate 1 at .*outside the limits.*space=robot\.space"):
        sf.ReactiveController(skill, plan, robot=Narrow())
    lower, upper = planar.limits
    far = replace(plan, path=Path(plan.path.states + 2 * (upper - lower)))
    controller = make(planner=lambda start, goal, obstacles: far, reaction=2.0)
    trace = run(controller, plan.path.states[0], 6.0, PUSH)
    assert "outside the limits" in controller.reason and controller.replans == 0
    assert np.linalg.norm(trace.states[-1] - controller.goal) < 2e-2


@pytest.mark.parametrize(
    "wrong",
    [
        {"plan": None},
        {"skill": None},
        {"robot": "planar_arm"},
        {"obstacles": sf.Scene([])},
        {"duration": 1e9},
        {"gains": (1, 2)},
        {"gains": Gains(off="hard")},
        {"gains": Gains(off=np.nan)},
        {"deviation": np.nan},
        {"off": -1.0},
        {"reaction": -1.0},
        {"latency": "none"},
        {"planner": 3},
        {"load": None},
        {"load": ("heavy", (0, 0, 0))},
    ],
)
def test_settings_that_make_no_sense_are_told(skill, plan, planar, wrong):
    with pytest.raises(InputError):
        sf.ReactiveController(**{"skill": skill, "plan": plan, "robot": planar, "latency": 0.03} | wrong)


def test_obstacles_that_are_none_are_refused_under_way(make, plan):
    controller = make()
    with pytest.raises(InputError, match="obstacles"):
        controller.update("a box")
    assert controller.obstacles is None
    assert controller.command(0.0, plan.path.states[0], np.zeros(3)).mode == "tracking"
