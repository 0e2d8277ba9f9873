"""What the README prints runs as it stands: its Python with data of such a kind, its commands by their help."""

import re
from pathlib import Path

import numpy as np
import pytest

import skillfold as sf
from skillfold.cli import main
from skillfold.experiments.keyframe_tasks import CRACKERS, tasks
from skillfold.experiments.tray import tray_poses

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
COMMANDS = re.findall(r"^\$ (skillfold .*(?:\\\n.*)*)", README, re.MULTILINE)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where the code runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(block: str, **given):
    """Names after a block of code was run with those given."""
    names = {"sf": sf, **given}
    exec(compile(block, "README.md", "exec"), names)
    return names


def test_a_skill_from_recordings(folder):
    (folder / "recordings").mkdir()
    t = np.linspace(0.0, 1.0, 60)
    ways = [np.column_stack([t, np.sin(2 * t) + 0.05 * i * (1 - t), t**2 + 0.02 * i * t]) for i in range(4)]
    for i, way in enumerate(ways):
        np.savetxt(folder / "recordings" / f"{i}.csv", way, delimiter=",", header="x,y,z", comments="")
    states = ways[1][10:50:5] + 0.01
    found = run(BLOCKS[0], start=ways[0][0] + 0.01, goal=ways[2][-1], disturbed_states=states)
    assert found["plan"].success, found["plan"].reason
    assert found["back"].shape == states.shape
    np.testing.assert_allclose(found["off"], np.linalg.norm(found["back"] - states, axis=1), atol=1e-9)
    assert (folder / "skill.npz").is_file()


def test_a_robot_around_a_table():
    poses = tray_poses(80, np.random.default_rng(0))
    table = sf.Scene([sf.Box(pose=[0.6, 0, 0.2], size=[0.4, 0.8, 0.4], name="table")])
    clear = poses[sf.Robot.load("lwr4").obstacles(table).clearance(poses) > 0.05]
    given = {"start": clear[0], "goal": clear[1], "t": 0.0, "q": clear[0], "qd": np.zeros(7)}
    found = run(BLOCKS[1], skill=sf.SkillManifold.fit(poses), **given)
    assert found["plan"].success, found["plan"].reason
    assert np.isfinite(found["command"].torque).all()
    assert np.isfinite(found["rollout"].states).all()


def test_keyframes_of_a_tool(folder):
    task = tasks()[0]
    rows = [(i, *pose) for i, poses in enumerate(task.demonstrations(0)) for pose in poses]
    np.savetxt(folder / "keyframes.csv", rows, delimiter=",", header="demo,x,y,z,qw,qx,qy,qz", comments="")
    start = task.start(1)
    moved = task.scene.moved("cracker box", np.add(CRACKERS.pose[:3], [0.0, 0.01, 0.0]))
    found = run(BLOCKS[2], q_start=start, scene=task.scene, moved_scene=moved, q=start)
    assert found["plan"].success, found["plan"].reason


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: " ".join(command.split()[:3]))
def test_commands_and_their_options_exist(command, capsys):
    words = command.replace("\\\n", " ").split("#")[0].split()
    assert main([words[1], "--help"]) == 0
    told = capsys.readouterr().out
    assert {word for word in words if word.startswith("--")} <= set(re.findall(r"--[a-z-]+", told))
