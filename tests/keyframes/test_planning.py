"""Plans of keyframe skills: laws by independent checks, what cannot be, hostile input."""

import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from keyframes.asked import arm, gaussian
from skillfold import Box, Robot, Scene, SkillfoldError
from skillfold.errors import InputError
from skillfold.keyframes.answers import told
from skillfold.keyframes.legs import KEPT
from skillfold.keyframes.pairs import Outcome
from skillfold.keyframes.planning import VARIANTS
from skillfold.keyframes.skill import KeyframeSkill

DOWN = [0.0, 1.0, 0.0, 0.0]
SCENE = Scene(
    [
        Box(pose=(0.225, 0.0, -0.365), size=(0.61, 1.22, 0.73), name="table"),
        Box(pose=(0.40, 0.0, 0.08), size=(0.07, 0.12, 0.16), name="box"),
    ]
)


def skill_of(*places, metres=(0.03, 0.02, 0.025), radians=0.12):
    gaussians = tuple(gaussian([*place, *DOWN], metres, radians) for place in places)
    return KeyframeSkill(gaussians, (), (), ())


@pytest.fixture(scope="module")
def robot():
    return arm()


@pytest.fixture(scope="module")
def skill():
    return skill_of((0.40, -0.24, 0.13), (0.40, 0.24, 0.15))


@pytest.fixture(scope="module")
def long_skill():
    return skill_of((0.40, -0.24, 0.13), (0.35, 0.0, 0.30), (0.40, 0.24, 0.15))


@pytest.fixture(scope="module")
def start(robot, skill):
    """Joint positions at the first mean, by damped Newton steps of this test's own."""
    wanted, obstacles = skill.gaussians[0].mean, robot.obstacles(SCENE)
    for q in robot.sample(200, 1):
        for _ in range(200):
            pose, J = robot.forward(q), robot.jacobian(q)
            turn = (
                Rotation.from_quat(wanted[3:], scalar_first=True)
                * Rotation.from_quat(pose[3:], scalar_first=True).inv()
            )
            off = np.concatenate([wanted[:3] - pose[:3], turn.as_rotvec()])
            step = J.T @ np.linalg.solve(J @ J.T + 1e-4 * np.eye(6), off)
            q = np.clip(q + step * min(1.0, 0.5 / np.linalg.norm(step)), *robot.limits)
        if np.linalg.norm(off) < 1e-4 and obstacles.clearance(q) > 0.03:
            return q
    raise AssertionError


def judged(plan, robot, envelope, obstacles, begin=0):
    """Poses inside and clear at .002 rad, by what the planner did not use."""
    states = plan.path.states
    counts = [int(np.linalg.norm(b - a) / 0.002) + 1 for a, b in pairwise(states)]
    fine = [
        a + share * (b - a)
        for a, b, n in zip(states[begin:-1], states[begin + 1 :], counts[begin:], strict=True)
        for share in np.arange(n) / n
    ]
    fine = np.array([*fine, states[-1]])
    squares, _ = envelope.membership(robot.forward(fine))
    assert squares.max() <= 1.0 + 1e-9
    assert obstacles.clearance(fine).min() > 0.0
    lower, upper = robot.limits
    assert (fine >= lower).all() and (fine <= upper).all()


@pytest.mark.parametrize("alpha", [100.0, 85.0, 50.0])
@pytest.mark.parametrize("seed", range(3))
def test_paths_are_inside_and_clear(robot, skill, start, alpha, seed):
    plan = skill.plan(robot, start, SCENE, alpha=alpha, seed=seed, time_limit=20.0)
    assert plan.success, plan.reason
    np.testing.assert_array_equal(plan.path.states[0], start)
    envelope = skill.envelope(0).widened(plan.stats["gate_factor"])
    obstacles = robot.obstacles(SCENE)
    judged(plan, robot, envelope, obstacles)
    judged(plan, robot, envelope.reduced(alpha), obstacles, plan.stats["entered"])
    assert envelope.child.contains(robot.forward(plan.path.states[-1]))
    assert plan.length == pytest.approx(plan.stats["costs"][-1][1], rel=1e-6) or plan.stats["entered"]
    assert np.abs(np.diff(plan.path.states, axis=0)).max() < 0.011


def test_same_seed_same_bits(robot, skill, start):
    first, again = (skill.plan(robot, start, SCENE, seed=4, time_limit=30.0).path.states for _ in range(2))
    np.testing.assert_array_equal(first, again)
    assert len(first) != len(skill.plan(robot, start, SCENE, seed=5, time_limit=30.0).path.states)


def test_time_makes_paths_no_longer(robot, skill, start):
    first = skill.plan(robot, start, SCENE, seed=1, time_limit=30.0)
    plan = skill.plan(robot, start, SCENE, seed=1, stop="time", time_limit=0.6)
    assert plan.success
    seconds, costs = np.array(plan.stats["costs"]).T
    assert (np.diff(costs) < 0.0).all() and (np.diff(seconds) > 0.0).all()
    assert plan.length == pytest.approx(costs[-1], rel=1e-6)
    assert costs[-1] <= first.length + 1e-9
    judged(plan, robot, skill.envelope(0).widened(plan.stats["gate_factor"]), robot.obstacles(SCENE))


def test_several_pairs_are_one_path(robot, long_skill, start):
    plan = long_skill.plan(robot, start, SCENE, seed=0, time_limit=30.0)
    assert plan.success, plan.reason
    rows = plan.stats["pairs"]
    assert [row["pair"] for row in rows] == [0, 1] and rows[0]["from"] == 0
    middle = robot.forward(plan.path.states[rows[1]["from"]])
    assert long_skill.gaussians[1].contains(middle) or rows[0]["gate_factor"] > 1
    assert long_skill.gaussians[2].contains(robot.forward(plan.path.states[-1])) or rows[1]["gate_factor"] > 1
    assert np.abs(np.diff(plan.path.states, axis=0)).max() < 0.011


def test_a_path_nearer_than_it_should_be_says_so(robot, start):
    for kept, factor, words in (
        (KEPT, 1.0, []),
        (0.1 * KEPT, 1.0, ["nearer"]),
        (0.1 * KEPT, 2.0, ["nearer", "2 times"]),
    ):
        outcome = Outcome(np.stack([start, start]), factor=factor, kept=kept)
        reason = told(robot, start, [outcome], 0.0, 0).reason
        assert [word for word in ("nearer", "2 times") if word in reason] == words, reason


def test_entered_counts_along_the_whole_path(robot, long_skill, start):
    """The second pair's path begins outside its reduced envelope, and is inside from the state told on."""
    plan = long_skill.plan(robot, start, SCENE, alpha=50.0, seed=0, time_limit=30.0)
    assert plan.success, plan.reason
    last, entered = plan.stats["pairs"][-1], plan.stats["entered"]
    assert entered == last["entered"] >= last["from"] > 0
    reduced = long_skill.envelope(1).widened(last["gate_factor"]).reduced(50.0)
    assert reduced.contains(robot.forward(plan.path.states[entered:])).all()


def test_until_and_start_at(robot, long_skill, start):
    plan = long_skill.plan(robot, start, SCENE, until=1, time_limit=20.0)
    assert plan.success and [row["pair"] for row in plan.stats["pairs"]] == [0]
    onward = long_skill.plan(robot, plan.path.states[-1], SCENE, start_at=1, time_limit=20.0)
    assert onward.success and onward.stats["pair"] == 1
    for wrong in (0, 3, -1, 1.0, True, "1"):
        with pytest.raises(InputError, match="until"):
            long_skill.plan(robot, start, SCENE, until=wrong)


def test_pairs_left_out_because_another_is_nearer_are_told(robot, start):
    """Nobody asked for the second pair: the start is merely nearer to it, outside both."""
    x, y, z = robot.forward(start)[:3]
    skill = skill_of((x + 0.11, y - 0.6, z), (x + 0.11, y - 0.1, z), (x + 0.11, y + 0.35, z))
    plan = skill.plan(robot, start, SCENE, time_limit=0.2)
    assert plan.stats["pair"] == 1
    assert "Pairs before 1 are left out: the start lies" in plan.reason
    assert "left out" not in skill.plan(robot, start, SCENE, time_limit=0.2, start_at=1).reason


def test_at_the_end_nothing_is_left_to_do(robot, skill, start):
    end = skill.plan(robot, start, SCENE, time_limit=20.0).path.states[-1]
    plan = skill.plan(robot, end, SCENE)
    assert plan.success and plan.length == 0.0 and "nothing is left" in plan.reason


@pytest.mark.parametrize("variant", sorted(VARIANTS))
def test_what_cannot_be_is_told_at_once(robot, skill, start, variant):
    """However long the time: none of these waits for it."""
    told = {
        "in collision: .* to post": (start, [Box(pose=(0.4, -0.24, 0.1), size=(0.3, 0.3, 0.3), name="post")]),
        "breaks the limits of joint2": (start + 9.0 * np.eye(6)[1], SCENE),
        "m outside the envelope": (robot.home, None),
    }
    for words, (q, scene) in told.items():
        plan = skill.plan(robot, q, scene, variant=variant, time_limit=1000.0)
        assert not plan.success and plan.iterations == 0
        assert re.search(words, plan.reason), plan.reason


def test_a_goal_out_of_reach_or_blocked_is_told_at_once(robot, start):
    away = skill_of((0.40, -0.24, 0.13), (2.0, 0.3, 0.2))
    plan = away.plan(robot, start, SCENE, time_limit=1000.0)
    assert not plan.success and "out of reach" in plan.reason and plan.stats["gate_factor"] == 4.0
    skill = skill_of((0.40, -0.24, 0.13), (0.40, 0.24, 0.15))
    wall = Box(pose=(0.40, 0.28, 0.15), size=(0.35, 0.36, 0.35), name="crate")
    plan = skill.plan(robot, start, [*SCENE, wall], time_limit=1000.0)
    assert not plan.success and "blocked" in plan.reason and "crate" in plan.reason


def test_gates_are_widened_and_it_is_told(robot, start):
    """A start just outside the gates, inside those of twice the square."""
    skill = skill_of((0.40, -0.24, 0.13), (0.40, 0.24, 0.15))
    pose = robot.forward(start)
    moved = skill.gaussians[0].mean[:3] - pose[:3] + np.array([0.0, -0.08, 0.0])
    near = skill_of(pose[:3] - moved, (0.40, 0.24, 0.15))
    assert 1.0 < near.envelope(0).membership(pose)[0] < 2.0
    plan = near.plan(robot, start, SCENE, time_limit=20.0)
    assert plan.success and plan.stats["gate_factor"] == 2.0 and "2 times" in plan.reason


def test_held_and_made_obstacles(robot, skill, start):
    """Obstacles made by hand give the same path; those of another robot are refused."""
    obstacles = robot.obstacles(SCENE)
    a, b = (skill.plan(robot, start, scene, time_limit=20.0) for scene in (SCENE, obstacles))
    np.testing.assert_array_equal(a.path.states, b.path.states)
    with pytest.raises(InputError, match="another robot"):
        skill.plan(Robot.load("jaco"), start, obstacles)


def test_printed_variant(robot, skill, start):
    """It runs, and what it finds is judged like any other path."""
    plan = skill.plan(robot, start, SCENE, variant="paper", time_limit=2.0, seed=1)
    assert plan.stats["nodes"] > 1 and plan.stats["gate_factor"] == 1.0
    inside = skill.envelope(0).contains(robot.forward(plan.path.states), 1e-6).all()
    assert plan.success <= inside


@pytest.mark.parametrize("variant", ["mended", "paper"])
def test_a_start_in_the_goal_is_a_path(robot, variant):
    pose = robot.forward(robot.home)
    shifts = np.linspace(-0.02, 0.02, 5)[:, None, None] * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    skill = KeyframeSkill.fit(pose + shifts + np.array([[0.0], [0.001]]) * np.eye(7)[0], 2)
    plan = skill.plan(robot, variant=variant, start_at=0, time_limit=5.0)
    assert plan.success and plan.length == 0.0, plan.reason
    np.testing.assert_array_equal(plan.path.states, [robot.home, robot.home])


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"alpha": 0.0}, "alpha"),
        ({"alpha": 0.85}, "85 is 85 %"),
        ({"alpha": 101}, "alpha"),
        ({"alpha": float("nan")}, "alpha"),
        ({"alpha": True}, "alpha"),
        ({"time_limit": 0.0}, "time_limit"),
        ({"time_limit": float("inf")}, "time_limit"),
        ({"time_limit": None}, "time_limit"),
        ({"stop": "never"}, "stop"),
        ({"seed": -1}, "seed"),
        ({"seed": 1.0}, "seed"),
        ({"variant": "mine"}, "mended, paper"),
        ({"variant": 3}, "variant"),
        ({"start_at": 1}, "start_at"),
        ({"start_at": -1}, "start_at"),
        ({"q_start": [0.0] * 5}, "joint positions"),
        ({"q_start": [[0.0] * 6]}, "q_start"),
        ({"q_start": [np.nan] * 6}, "finite"),
        ({"q_start": "here"}, "numbers"),
        ({"scene": 3}, "Scene"),
        ({"robot": "jaco"}, "expected a Robot"),
    ],
)
def test_bad_input(robot, skill, start, asked, words):
    given = {"robot": robot, "q_start": start, "scene": SCENE} | asked
    with pytest.raises(SkillfoldError, match=words):
        skill.plan(**given)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(-1e300, 1e300), min_size=6, max_size=6), st.integers(0, 2**32 - 1))
def test_any_start_is_answered(q, seed):
    """Whatever finite numbers: a plan, or a failed one with a reason."""
    plan = skill_of((0.40, -0.24, 0.13), (0.40, 0.24, 0.15)).plan(arm(), q, SCENE, seed=seed, time_limit=0.05)
    assert plan.success or plan.reason
    assert np.isfinite(plan.path.states).all()


@pytest.mark.parametrize("variant", sorted(VARIANTS))
def test_plans_keep_their_tree(robot, skill, start, variant):
    """Nodes with their parents: the first is the start, all others hang on earlier or rewired ones, in no circle."""
    states, parents = skill.plan(robot, start, SCENE, variant=variant, time_limit=2.0, seed=1).stats["tree"]
    np.testing.assert_array_equal(states[0], start)
    assert states.shape == (len(parents), 6) and np.isfinite(states).all() and parents[0] == -1
    at = np.arange(len(parents))
    for _ in range(len(parents)):
        at = np.where(at > 0, parents[at], at)
    assert (at == 0).all()
