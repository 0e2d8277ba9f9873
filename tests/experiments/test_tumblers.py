"""Tumblers on a carried tray: they stand unpushed, a shove tips those of the naive arm, and boxes are passed."""

from dataclasses import replace

import numpy as np
import pytest

import skillfold as sf
from skillfold.experiments import tray, tumblers
from skillfold.experiments.tray_cases import CLEAR
from skillfold.experiments.tumbler_boxes import Passing, box_trial, carrier, carry_past
from skillfold.experiments.tumbler_runs import CALM, TRAY, Outcome, calm_duration, carry, quintic, run, trials


@pytest.fixture(scope="module")
def skill():
    poses = tray.tray_poses(200, np.random.default_rng(0), tray.LEVEL_WEIGHT)
    return sf.SkillManifold.fit(poses, dim=3, kernels=40, ridge=1e-5, jobs=1)


@pytest.fixture(scope="module")
def trial(skill):
    return trials(skill, 1, np.random.default_rng(1))[0]


def test_left_alone_all_stand_and_the_skill_holds_the_tray_level(skill, trial):
    mine, naive = (run(method, skill, trial) for method in ("skill", "naive"))
    assert mine.stood and naive.stood
    assert mine.tilt < 0.02 and mine.tilt < naive.tilt
    assert mine.missed < 0.03 and mine.gives == naive.gives == 0.0


def test_a_shove_tips_tumblers_of_the_naive_arm_and_not_those_of_the_skill(skill, trial):
    shove = sf.Push(0.4, "link7", (0.0, 70.0, 0.0), 0.25)
    shoved = replace(trial, push=shove)
    found = {method: run(method, skill, shoved) for method in ("skill", "critical")}
    assert found["skill"].stood and not found["critical"].stood
    assert found["skill"].tilt < found["critical"].tilt / 3
    assert 0.0 < found["skill"].gives < found["critical"].gives
    again = run("skill", skill, shoved)
    assert again == found["skill"]


def test_a_motion_takes_as_long_as_tumblers_ask_for(skill, trial):
    way = np.asarray(skill.plan(trial.start, trial.goal).path.states)
    assert trial.duration == pytest.approx(calm_duration(way))
    rollout = carry("skill", skill, trial)
    accelerated = np.diff(rollout.tool_poses[::20, :3], 2, axis=0) / 0.02**2
    assert np.linalg.norm(accelerated, axis=1).max() < 1.2 * CALM
    naive = quintic(trial)
    assert np.allclose(naive.at(naive.duration)[0], trial.goal) and naive.duration == pytest.approx(trial.duration)


def test_trials_are_those_that_were_asked_for(skill):
    for asked in trials(skill, 3, np.random.default_rng(2), "forearm", "slow"):
        assert np.linalg.norm(np.subtract(*tray.positions(np.stack([asked.start, asked.goal])))) >= 0.5
        assert asked.push.body == "link5" and asked.push.duration == 1.5
        assert 20.0 <= np.linalg.norm(asked.push.force) <= 60.0


def test_past_a_box_that_moves_into_the_way(skill):
    asked = box_trial(skill, np.random.default_rng(3))
    box = asked.scene.shapes[0]
    moved = np.linalg.norm(box.motion.poses[-1][:3] - box.motion.poses[0][:3])
    assert 0.05 <= moved <= 0.10
    after = carrier().obstacles(asked.scene).at(box.motion.times[-1])
    assert after.clearance(asked.trial.goal) >= 2 * CLEAR
    assert after.clearance(np.asarray(asked.plan.path.states)).min() < 0.0
    rollout, found = carry_past(skill, asked)
    assert found.safe and found.arrived and found.replans >= 1 and found.jump < 1.0
    assert rollout.contacts == () and rollout.clearances.min() > 0.0 and rollout.standing == TRAY.tumblers


def test_rows_stand_beside_their_targets(skill, monkeypatch):
    monkeypatch.setattr(tumblers, "in_parallel", lambda function, cases, *_: (function(*case) for case in cases))
    monkeypatch.setattr(
        tumblers, "run", lambda method, skill, trial: Outcome(3, 0.1 + (method != "skill"), 0.01, 0, 0.0)
    )
    monkeypatch.setattr(tumblers, "passing", lambda skill, seed: Passing(3, 0, 0.01, 0.3, 1, 0.0, 0.01))
    monkeypatch.setattr(tumblers, "skill_of", lambda settings, rng: skill)
    rows = tumblers.measure(tumblers.Settings(0), 2)
    assert len(rows) == 11 and all(row.met for row in rows)
    assert {row.target for row in rows if row.name.endswith("all three standing") and "pushes" in row.name} == {
        0.9,
        0.95,
    }
