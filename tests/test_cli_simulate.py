"""`skillfold simulate`: what it writes, what it says, and how it ends."""

import json

import numpy as np
import pytest

import skillfold as sf
from skillfold.cli import main, simulating
from skillfold.errors import InputError
from skillfold.experiments.reaching import grid
from skillfold.experiments.three_link import REACHING, optimal
from skillfold.io.video_files import write_video


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A skill over the planar arm, two of its states, and a scene."""
    made = tmp_path_factory.mktemp("simulate")
    poses = optimal(grid(), REACHING)
    poses = poses[np.random.default_rng(0).choice(len(poses), 100, replace=False)]
    skill = sf.SkillManifold.fit(poses, dim=2, kernels=10, ridge=1e-5, jobs=1)
    skill.save(made / "skill.npz")
    ends = skill.sample(2, 1)
    (made / "ends.csv").write_text(",".join(skill.names) + "\n" + "\n".join(",".join(map(str, q)) for q in ends))
    sf.Scene([sf.Sphere(center=(0, 0, 3.0), radius=0.1)]).save(made / "scene.json")
    return made


def run(capsys, folder, *arguments):
    ends = [f"--start={folder / 'ends.csv'}:first", f"--goal={folder / 'ends.csv'}:last"]
    code = main(["simulate", str(folder / "skill.npz"), "--robot", "planar_arm", *ends, *map(str, arguments)])
    out, err = capsys.readouterr()
    return code, out, err


def test_it_simulates_writes_and_reports(folder, tmp_path, capsys):
    out = tmp_path / "run.npz"
    push = "t=0.1 link=2 force=10,0,0 duration=0.1"
    code, text, _ = run(capsys, folder, "--push", push, "--out", out, "--json")
    told = json.loads(text)
    assert code == 0 and told["out"] == str(out) and told["contacts"] == []
    rollout = sf.Rollout.load(out)
    assert told["steps"] == len(rollout) and told["largest_distance"] == pytest.approx(rollout.distances.max())


def test_scenes_and_tables(folder, tmp_path, capsys):
    out = tmp_path / "run.csv"
    code, text, _ = run(capsys, folder, "--scene", folder / "scene.json", "--out", out)
    assert code == 0 and "least clearance" in text
    assert out.read_text().startswith("t,mode,joint1")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--push", "t=0.1 link=2"], "expected t=SECONDS"),
        (["--push", "t=x link=2 force=1,0,0 duration=1"], "expected t=SECONDS"),
        (["--push", "t=0.1 link=9 force=1,0,0 duration=1"], "no body 9"),
        (["--push", "t=0.1 link=2 force=1,0 duration=1"], "three numbers"),
        (["--video", "run.avi"], "possible: .gif, .mp4"),
        (["--scene", "missing.json"], "cannot be read"),
        (["--seed", "-1"], "--seed"),
        (["--out", "run.txt"], "possible: .npz, .csv"),
        (["--duration", "0.001"], "the limits of velocity"),
    ],
)
def test_bad_input_is_told_in_one_line(folder, capsys, arguments, told):
    code, out, err = run(capsys, folder, *arguments)
    assert code == 2 and out == ""
    assert told in err and err.count("\n") == 1


def test_pushes_are_read(folder):
    push = simulating.push("t=0.25 link=5 force=60,0,-1.5 duration=0.2")
    assert push == sf.Push(time=0.25, body=5, force=(60, 0, -1.5), duration=0.2)
    assert simulating.push("link=hand t=0 force=1,2,3 duration=1").body == "hand"


def test_pictures_become_a_file_or_a_folder(tmp_path):
    pictures = [np.full((8, 8, 3), 60 * i, np.uint8) for i in range(3)]
    assert write_video(tmp_path / "run.gif", pictures, 25) == 3
    assert (tmp_path / "run.gif").read_bytes().startswith(b"GIF")
    assert write_video(tmp_path / "frames", iter(pictures), 25) == 3
    assert sorted(file.name for file in (tmp_path / "frames").iterdir()) == ["00000.png", "00001.png", "00002.png"]
    with pytest.raises(InputError, match="cannot be written"):
        write_video(tmp_path / "missing" / "run.gif", pictures, 25)


def test_mp4_without_ffmpeg_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr("skillfold.io.video_files.which", lambda name: None)
    with pytest.raises(InputError, match="needs ffmpeg"):
        write_video(tmp_path / "run.mp4", [], 25)
