"""Closed loops in MuJoCo: a push, an obstacle, tumblers, and what is kept of it."""

import numpy as np
import pytest

import skillfold as sf
from skillfold.control.timing import time_path
from skillfold.control.tracking import JointTracker
from skillfold.errors import InputError, SkillFileError

SHOVE = sf.Push(time=0.3, body="link2", force=(25.0, 25.0, 0.0), duration=0.2)


@pytest.fixture(scope="module")
def pushed(skill, plan, planar):
    controller = sf.ReactiveController(skill, plan, robot=planar, latency=0.03, deviation=0.02)
    return sf.simulate(planar, controller, pushes=[SHOVE])


def test_pushed_it_recovers_and_reaches_the_goal(pushed, plan, skill, planar):
    assert pushed.distances.max() > 0.01
    assert {"tracking", "returning", "replanned"} <= set(pushed.modes.tolist())
    assert np.linalg.norm(pushed.states[-1] - plan.path.states[-1]) < 0.05
    assert skill.distance(pushed.states[-1]) < 5e-3
    assert (np.abs(pushed.torques) <= planar.torque_limits).all()
    assert np.allclose(pushed.distances, skill.distance(pushed.states), atol=1e-4)
    assert pushed.facts["replans"] >= 1 and pushed.contacts == ()
    assert len(pushed) == len(pushed.trajectory.times)


@pytest.mark.parametrize("rate", [200.0, 50.0, 20.0])
def test_at_slow_rates_it_recovers_too(rate, skill, plan, planar):
    """Gains are eased to what so many samples a second allow."""
    controller = sf.ReactiveController(skill, plan, robot=planar, latency=0.03)
    rollout = sf.simulate(planar, controller, pushes=[SHOVE], step=1.0 / rate)
    assert rollout.count("holding") == 0
    assert np.linalg.norm(rollout.states[-1] - plan.path.states[-1]) < 0.06
    assert np.abs(rollout.velocities[-1]).max() < 0.1
    assert skill.distance(rollout.states[-1]) < 5e-3


def test_samples_too_far_apart_are_held_still(skill, plan, planar):
    """At ten a second, with a push: it does not go on, and does not swing either."""
    controller = sf.ReactiveController(skill, plan, robot=planar, latency=0.03)
    rollout = sf.simulate(planar, controller, pushes=[SHOVE], step=0.1, duration=10.0)
    assert rollout.count("holding") >= len(rollout) - 1
    assert np.abs(rollout.velocities[-1]).max() < 0.01


def test_the_same_seed_gives_the_same_bits(skill, plan, planar):
    def once(seed):
        controller = sf.ReactiveController(skill, plan, robot=planar, latency=0.03)
        return sf.simulate(planar, controller, pushes=[SHOVE], seed=seed, duration=0.6, noise=1e-4)

    one, two, three = once(1), once(1), once(2)
    assert np.array_equal(one.states, two.states) and np.array_equal(one.torques, two.torques)
    assert not np.array_equal(one.states, three.states)


def test_obstacles_are_real_and_contacts_are_told(skill, plan, planar):
    tool = planar.forward(plan.path.states[25])[:3]
    controller = sf.ReactiveController(skill, plan, robot=planar, latency=0.03)  # knows of no obstacle
    block = sf.Sphere(center=tool, radius=0.05, name="block")
    rollout = sf.simulate(planar, controller, [block], duration=2.0)
    assert any("block" in contact[:2] and contact.end > contact.start for contact in rollout.contacts)
    assert rollout.clearances.min() < 0.0


def test_moving_obstacles_move(skill, plan, planar):
    up = np.array([0.0, 0.0, 0.5])
    far = planar.forward(plan.path.states[0])[:3] + up
    ball = sf.Sphere(center=far, radius=0.05, motion=sf.Motion([0.0, 1.0], [far, far + 2 * up]))
    rollout = sf.simulate(
        planar, sf.ReactiveController(skill, plan, robot=planar, latency=0.03), [ball], duration=0.5
    )
    expected = planar.obstacles([ball]).at(rollout.times[-1]).clearance(rollout.states[-1])
    assert rollout.clearances[-1] == pytest.approx(expected)


def test_tumblers_stand_on_a_tray_held_level_and_fall_off_one_that_tips():
    robot = sf.Robot.load("lwr4")
    tray = sf.Tray()
    up = np.array([0.0, 0.5, 0.0, 1.2, 0.0, 0.7, 0.0])
    tool = robot.forward(up)
    assert abs(tool[4]) + abs(tool[5]) > 0  # level enough or not, the tracker goes where it is told
    level = _level(robot, up)
    held = sf.simulate(
        robot, JointTracker(time_path([level, level]), robot, load=tray.load), tray=tray, start=level, duration=0.6
    )
    assert held.standing == 3 and held.tilts.max() < 0.05
    assert held.tumblers.shape[1:] == (3, 7)
    over = level + 1.2 * np.eye(7)[5]
    tipped = sf.simulate(
        robot,
        JointTracker(
            time_path([level, over], robot.velocity_limits, robot.acceleration_limits), robot, load=tray.load
        ),
        tray=tray,
        duration=1.4,
    )
    assert tipped.standing == 0


def _level(robot, q):
    """Joint 6 turned until the tool points straight up."""
    angles = np.linspace(-2, 2, 4001)
    poses = np.repeat(q[None], len(angles), axis=0)
    poses[:, 5] = angles
    turned = robot.forward(poses)
    upright = 1 - 2 * (turned[:, 4] ** 2 + turned[:, 5] ** 2)
    return poses[np.argmax(upright)]


def test_a_joint_tracker_follows(plan, planar):
    reference = time_path(plan.path.states, planar.velocity_limits, planar.acceleration_limits)
    rollout = sf.simulate(planar, JointTracker(reference, planar))
    assert np.linalg.norm(rollout.states[-1] - plan.path.states[-1]) < 0.01
    assert np.isnan(rollout.distances).all()


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_rollouts_are_saved(pushed, tmp_path, suffix):
    path = tmp_path / f"run{suffix}"
    pushed.save(path)
    if suffix == ".csv":
        lines = path.read_text().splitlines()
        assert lines[0].startswith("t,mode,joint1,joint2,joint3,velocity_joint1")
        assert len(lines) == len(pushed) + 1
        return
    again = sf.Rollout.load(path)
    for name in ("times", "states", "velocities", "torques", "modes", "tool_poses", "clearances", "step_times"):
        assert np.array_equal(getattr(again, name), getattr(pushed, name), equal_nan=name != "modes")
    assert again.contacts == pushed.contacts and again.facts == pushed.facts and again.names == pushed.names


def test_files_that_are_no_rollouts_are_refused(pushed, skill, tmp_path):
    with pytest.raises(SkillFileError, match=r"possible: \.npz, \.csv"):
        pushed.save(tmp_path / "run.txt")
    skill.save(tmp_path / "skill.npz")
    with pytest.raises(SkillFileError, match="skillfold rollout"):
        sf.Rollout.load(tmp_path / "skill.npz")
    with pytest.raises(SkillFileError):
        sf.Rollout.load(tmp_path / "missing.npz")


@pytest.mark.parametrize(
    "arguments",
    [
        {"time": -1.0, "body": 1, "force": (1, 0, 0), "duration": 1.0},
        {"time": 0.0, "body": 1, "force": (1, 0), "duration": 1.0},
        {"time": 0.0, "body": 1, "force": (np.nan, 0, 0), "duration": 1.0},
        {"time": 0.0, "body": 1, "force": (1, 0, 0), "duration": 0.0},
        {"time": "now", "body": 1, "force": (1, 0, 0), "duration": 1.0},
        {"time": 0.0, "body": 1, "force": "hard", "duration": 1.0},
    ],
)
def test_pushes_that_make_no_sense_are_told(arguments):
    with pytest.raises(InputError, match="Push"):
        sf.Push(**arguments)


def test_what_cannot_be_simulated_is_told(skill, plan, planar):
    controller = sf.ReactiveController(skill, plan, robot=planar, latency=0.03)
    with pytest.raises(InputError, match="no body 'elbow'; possible: 1 to 3"):
        sf.simulate(planar, controller, pushes=[sf.Push(0.1, "elbow", (1, 0, 0), 0.1)])
    with pytest.raises(InputError, match="start"):
        sf.simulate(planar, controller, start=[1.0])
    with pytest.raises(InputError, match="base is free"):
        sf.simulate(sf.Robot.load("nao"), controller)
    with pytest.raises(InputError, match="tumblers"):
        sf.Tray(tumblers=-1)


class Constant:
    """A controller that answers with the same torque."""

    def __init__(self, torque):
        self.torque, self.mode = torque, "constant"

    def command(self, t, q, qd):
        return self


@pytest.mark.parametrize("torque", [None, [np.nan] * 3, [0.0] * 2, "much"])
def test_torques_that_are_none_are_told(planar, torque):
    with pytest.raises(InputError, match="expected 3 finite numbers"):
        sf.simulate(planar, Constant(torque), duration=0.01, start=planar.home)


def test_a_run_that_becomes_unstable_is_told_and_leaves_no_file(planar, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="unstable at 0 s"):
        sf.simulate(planar, Constant(0.0), None, [sf.Push(0.0, 3, (1e300, 0, 0), 1.0)], 0, 0.1, start=planar.home)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "wrong",
    [
        {"step": 0},
        {"step": np.nan},
        {"step": 100.0},
        {"noise": -1},
        {"noise": "some"},
        {"seed": -1},
        {"duration": np.inf},
        {"duration": "long"},
        {"start": "home"},
        {"pushes": None},
        {"pushes": ["hard"]},
        {"tray": "large"},
        {"controller": None},
        {"robot": "planar_arm"},
    ],
)
def test_settings_that_make_no_sense_are_told(planar, wrong):
    given = {"robot": planar, "controller": Constant(0.0), "duration": 0.01, "start": planar.home} | wrong
    with pytest.raises(InputError):
        sf.simulate(**given)


@pytest.mark.parametrize("path", [None, 3, "\0.npz", "\0.csv"])
def test_what_is_no_path_of_a_run_is_told(pushed, path):
    with pytest.raises(SkillFileError):
        pushed.save(path)
    with pytest.raises(SkillFileError):
        sf.Rollout.load(path)
