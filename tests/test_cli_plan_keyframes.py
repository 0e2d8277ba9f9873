"""`skillfold plan` with a skill of keyframes, and `skillfold demo keyframes`."""

import csv
import json

import numpy as np
import pytest

import skillfold as sf
from skillfold.cli import main
from skillfold.experiments.keyframe_tasks import tasks
from skillfold.keyframes.skill import KeyframeSkill


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A skill of task 2, and its scene."""
    made = tmp_path_factory.mktemp("keyframes")
    task = tasks()[1]
    KeyframeSkill.fit(list(task.demonstrations(0)), n_keyframes=2).save(made / "skill.npz")
    task.scene.save(made / "scene.json")
    return made


def plan(folder, capsys, *options):
    code = main(["plan", str(folder / "skill.npz"), *map(str, options)])
    return code, *capsys.readouterr()


def test_a_path_from_a_start_that_is_found(folder, tmp_path, capsys):
    out = tmp_path / "path.csv"
    among = ("--robot", "jaco", "--scene", folder / "scene.json")
    code, text, _ = plan(folder, capsys, *among, "--alpha", 85, "--time", 5, "--out", out, "--json")
    told = json.loads(text)
    assert code == 0 and told["success"] and told["start_found"]
    with out.open(newline="") as file:
        states = np.array([list(map(float, row.values())) for row in csv.DictReader(file)])
    robot, skill = sf.Robot.load("jaco"), KeyframeSkill.load(folder / "skill.npz")
    assert np.allclose(states[0], told["start"]) and np.allclose(states, told["states"])
    assert skill.gaussians[0].contains(robot.forward(states[0]))
    assert skill.gaussians[1].contains(robot.forward(states[-1]))
    assert robot.obstacles(sf.Scene.load(folder / "scene.json")).clearance(states).min() > 0


def test_a_path_from_a_start_that_is_given(folder, capsys):
    q = tasks()[1].start(1, lambda pose: KeyframeSkill.load(folder / "skill.npz").gaussians[0].contains(pose))
    code, text, err = plan(
        folder, capsys, "--robot", "jaco", f"--start={','.join(map(repr, q.tolist()))}", "--time", 5
    )
    assert code == 0, err
    assert "found by inverse kinematics" not in err and "success" in text


def test_a_start_in_the_way_of_something_has_no_path(folder, tmp_path, capsys):
    skill, robot = KeyframeSkill.load(folder / "skill.npz"), sf.Robot.load("jaco")
    q = tasks()[1].start(1, lambda pose: skill.gaussians[0].contains(pose))
    sf.Scene([sf.Sphere(robot.forward(q)[:3], 0.05, name="ball")]).save(tmp_path / "ball.json")
    given = f"--start={','.join(map(repr, q.tolist()))}"
    code, _, err = plan(folder, capsys, "--robot", "jaco", "--scene", tmp_path / "ball.json", given)
    assert code == 1 and "no path" in err and "ball" in err


def test_a_first_keyframe_that_is_blocked_is_told(folder, tmp_path, capsys):
    mean = KeyframeSkill.load(folder / "skill.npz").gaussians[0].mean[:3]
    sf.Scene([sf.Sphere(mean, 0.4, name="ball")]).save(tmp_path / "ball.json")
    code, _, err = plan(folder, capsys, "--robot", "jaco", "--scene", tmp_path / "ball.json")
    assert code == 2 and "first keyframe's gate" in " ".join(err.split())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((), "--robot jaco"),
        (("--robot", "jaco", "--goal", "1,2"), "--goal"),
        (("--robot", "jaco", "--route", "geodesic", "--points", "7"), "--points, --route"),
        (("--robot", "jaco", "--start", "1,2"), "6 joint positions"),
        (("--robot", "jaco", "--start", "a,b,c,d,e,f"), "6 joint positions"),
        (("--robot", "jaco", "--alpha", "0"), "alpha"),
        (("--robot", "jaco", "--time", "-1"), "time_limit"),
        (("--robot", "jaco", "--seed", "-1"), "--seed"),
        (("--robot", "nobody"), "Unknown robot"),
    ],
)
def test_what_makes_no_sense_is_told_in_one_sentence(folder, capsys, options, said):
    code, text, err = plan(folder, capsys, *options)
    assert code == 2 and text == "" and "Traceback" not in err
    assert said in " ".join(err.split())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--start", "0,0"), "--goal"),
        ((), "--start"),
        (("--start", "0,0", "--goal", "1,1", "--alpha", "85"), "--alpha"),
    ],
)
def test_manifolds_need_both_ends_and_know_no_alpha(tmp_path, capsys, options, said):
    wave = np.linspace(0.0, 3.0, 40)
    skill = sf.SkillManifold.fit([np.column_stack([wave, np.sin(wave) + s]) for s in (0.0, 0.05)], dim=1, kernels=5)
    skill.save(tmp_path / "skill.npz")
    code, _, err = plan(tmp_path, capsys, *options)
    assert code == 2 and said in " ".join(err.split())


def test_the_demo_draws_and_tells(tmp_path, capsys, monkeypatch):
    from skillfold.experiments import keyframe_demo

    monkeypatch.setattr(keyframe_demo, "PLANS", 1)
    code = main(["demo", "keyframes", "--out", str(tmp_path / "pictures"), "--json"])
    told = json.loads(capsys.readouterr().out)
    assert code == 0 and len(told["tasks"]) == 4
    assert (tmp_path / "pictures" / "keyframes.png").stat().st_size > 10_000
    assert all(task["outside"] == task["touching"] == 0 for task in told["tasks"])
