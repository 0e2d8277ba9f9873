"""`skillfold plan` with a robot and a scene."""

import csv
import json

import numpy as np
import pytest

import skillfold as sf
from skillfold.cli import files, main
from skillfold.experiments.reaching import inside_grid
from skillfold.experiments.three_link import REACHING, forward, optimal


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A skill of the planar arm, and a ball at the tool half-way between two poses."""
    made = tmp_path_factory.mktemp("around")
    rng = np.random.default_rng(5)
    skill = sf.SkillManifold.fit(optimal(inside_grid(120, rng), REACHING), dim=2, kernels=10, ridge=1e-5)
    skill.save(made / "skill.npz")
    ends = optimal(np.array([[0.6, -0.3], [0.6, 0.3]]), REACHING)
    middle = forward(ends.mean(0))
    sf.Scene([sf.Sphere(center=(*middle, 0.0), radius=0.05, name="ball")]).save(made / "ball.json")
    np.save(made / "ends.npy", ends)
    return made


def plan(folder, capsys, *options):
    ends = [",".join(map(repr, row.tolist())) for row in np.load(folder / "ends.npy")]
    code = main(["plan", str(folder / "skill.npz"), f"--start={ends[0]}", f"--goal={ends[1]}", *map(str, options)])
    return code, *capsys.readouterr()


def test_a_path_goes_around_the_ball(folder, tmp_path, capsys):
    out = tmp_path / "path.csv"
    scene = folder / "ball.json"
    code, text, _ = plan(folder, capsys, "--robot", "planar_arm", "--scene", scene, "--out", out, "--json")
    told = json.loads(text)
    assert code == 0
    assert told["success"] and "ball" in told["reason"]
    with out.open(newline="") as file:
        states = np.array([list(map(float, row.values())) for row in csv.DictReader(file)])
    robot = sf.Robot.load("planar_arm")
    clear = robot.obstacles(sf.Scene.load(scene)).clearance(states)
    assert clear.min() > 0
    assert told["clearance"] == pytest.approx(clear.min(), abs=1e-9)


def test_a_path_that_is_asked_for_as_it_is_fails(folder, tmp_path, capsys):
    out = tmp_path / "path.csv"
    scene = ("--robot", "planar_arm", "--scene", folder / "ball.json")
    code, text, err = plan(folder, capsys, *scene, "--method", "geodesic", "--out", out, "--json")
    assert code == 1
    assert "no path" in err and "ball" in err
    assert json.loads(text)["states"] is None and not out.exists()


def test_without_a_scene_the_robot_keeps_clear_of_itself(folder, capsys):
    code, text, _ = plan(folder, capsys, "--robot", "planar_arm", "--json")
    assert code == 0
    assert json.loads(text)["clearance"] > 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--scene", "ball.json"], "Name the robot"),
        (["--margin", "nan"], "Name the robot"),
        (["--robot", "lwr4"], "7 coordinates, the skill has 3"),
        (["--robot", "lwr5"], "lwr5"),
        (["--robot", "planar_arm", "--scene", "none.json"], "none.json"),
        (["--robot", "planar_arm", "--margin", "-1"], "margin"),
        (["--robot", "planar_arm", "--method", "leaf"], "springs"),
        (["--robot", "planar_arm", "--seed", "-2"], "--seed"),
        (["--method", "hinge"], "anchored, leaf"),
        (["--out", "path.npz"], "path.npz: ends in .npz; possible: .csv"),
    ],
)
def test_what_cannot_be_used_is_told_in_one_line(folder, capsys, options, message):
    code, _, err = plan(folder, capsys, *options)
    assert code == 2
    assert message in err
    assert len(err.strip().splitlines()) == 1


def test_what_was_made_up_of_a_robot_is_said(tmp_path, capsys):
    file = tmp_path / "arm.urdf"
    file.write_text(
        '<robot name="arm"><link name="base"/><link name="tip"/><joint name="a" type="revolute">'
        '<parent link="base"/><child link="tip"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    assert files.load_robot(str(file)).dof == 1
    told = capsys.readouterr().err
    assert told.startswith("skillfold: note:")
    assert "tip" in told
