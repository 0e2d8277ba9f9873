"""The command line on keyframes: what it writes, what it says, and how it ends."""

import json

import numpy as np
import pytest

from keyframes.skills import demonstrations
from skillfold.cli import files, main
from skillfold.demonstrations import Demonstrations
from skillfold.errors import SkillFileError
from skillfold.keyframes.skill import KeyframeSkill
from skillfold.manifold.skill import SkillManifold

POSE = ["x", "y", "z", "qw", "qx", "qy", "qz"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Keyframes, full recordings with a gripper, a skill of each kind."""
    made = tmp_path_factory.mktemp("keyframes")
    demos = Demonstrations(demonstrations(11)[1], names=POSE)
    demos.save(made / "keyframes.csv")
    KeyframeSkill.fit(demos).save(made / "skill.npz")
    phase = np.linspace(0, 1, 40)[:, None]
    paths = [
        np.vstack([d[i] + phase * (d[i + 1] - d[i]) for i in range(2)])[:, :3] for d in (x.states for x in demos)
    ]
    turns = np.tile([1.0, 0, 0, 0], (80, 1))
    gripper = np.where(np.arange(80) < 39, 0.0, 1.0)
    recordings = [np.column_stack([path, turns, gripper]) for path in paths]
    Demonstrations(recordings, times=0.1 * np.arange(80), names=[*POSE, "gripper"]).save(made / "full.csv")
    line = [np.column_stack([np.linspace(0, 1, 20), np.full(20, y) + 0.01 * np.arange(20)]) for y in (0.0, 0.02)]
    SkillManifold.fit(line, dim=1, kernels=3, ridge=1e-4).save(made / "manifold.npz")
    return made


def run(capsys, *arguments):
    code = main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return code, out, err


def test_fit_keyframes_saves_a_skill_and_reports_it(folder, tmp_path, capsys):
    out = tmp_path / "new.npz"
    code, text, err = run(capsys, "fit-keyframes", folder / "keyframes.csv", "--out", out)
    assert (code, err) == (0, "")
    assert "demonstrations   7" in text and "log evidence" in text and "spread [mm]" in text
    assert out.read_bytes() == (folder / "skill.npz").read_bytes()


def test_fit_keyframes_as_json(folder, tmp_path, capsys):
    arguments = ("--keyframes", 2, "--coverage", 0.9, "--interpolation", "bures", "--json")
    code, text, _ = run(capsys, "fit-keyframes", folder / "keyframes.csv", "--out", tmp_path / "new.npz", *arguments)
    told = json.loads(text)
    assert code == 0 and told["keyframes"] == 2 and told["coverage"] == 0.9 and told["interpolation"] == "bures"
    assert told["extra_keyframes"] == 14 and len(told["gaussians"]) == 2
    assert told["gaussians"][0]["count"] == 7 and len(told["gaussians"][0]["mean"]) == 7
    assert [row["keyframes"] for row in told["selection"]] == [2]


@pytest.mark.parametrize("option", [("--extract",), ("--gripper", "gripper")])
def test_full_recordings(folder, tmp_path, capsys, option):
    out = tmp_path / "new.npz"
    code, text, _ = run(capsys, "fit-keyframes", folder / "full.csv", "--out", out, *option, "--json")
    assert code == 0 and json.loads(text)["keyframes"] == 3


def test_info_tells_keyframes_from_manifolds(folder, capsys):
    code, text, _ = run(capsys, "info", folder / "skill.npz", "--json")
    told = json.loads(text)
    assert code == 0 and told["keyframes"] == 4 and told["notes"] == []
    code, text, _ = run(capsys, "info", folder / "skill.npz")
    assert code == 0 and "Keyframes, with how many" in text
    code, text, _ = run(capsys, "info", folder / "manifold.npz", "--json")
    assert code == 0 and json.loads(text)["dim"] == 1


def test_notes_are_told(folder, tmp_path, capsys):
    few = tmp_path / "few.csv"
    few.write_text("demo,x,y,z,qw,qx,qy,qz\n" + "".join(f"{d},{x},0,0,1,0,0,0\n" for d in "ab" for x in (0, 0.4)))
    out = tmp_path / "new.npz"
    code, text, err = run(capsys, "fit-keyframes", few, "--out", out)
    assert code == 0 and "note: Gaussian 0" in err and "note:" not in text
    code, text, _ = run(capsys, "info", out)
    assert "Note: Gaussian 0 was learnt from 2 keyframes" in text


def test_kinds_of_files(folder, tmp_path):
    assert files.kind(folder / "skill.npz") == "keyframes"
    assert files.kind(folder / "manifold.npz") == "manifold"
    assert isinstance(files.load_keyframes(folder / "skill.npz"), KeyframeSkill)
    from skillfold import archive

    archive.write(tmp_path / "odd.npz", {"kind": "rollout"}, {})
    with pytest.raises(SkillFileError, match=r"holds 'rollout'; expected a skill"):
        files.kind(tmp_path / "odd.npz")


HOSTILE = {
    "no such file": ("fit-keyframes nowhere.csv --out new.npz", "nowhere.csv"),
    "missing folder": ("fit-keyframes keyframes.csv --out nowhere/new.npz", "no folder nowhere"),
    "too many": ("fit-keyframes keyframes.csv --out new.npz --keyframes 9", "n_keyframes=9"),
    "no share": ("fit-keyframes keyframes.csv --out new.npz --coverage 97.5", "coverage=97.5"),
    "no such column": ("fit-keyframes full.csv --out new.npz --gripper hand", "possible: gripper"),
    "other columns": ("fit-keyframes joints.csv --out new.npz", "expected x, y, z, qw, qx, qy, qz"),
    "one demonstration": ("fit-keyframes one.csv --out new.npz", "two at least"),
    "negative seed": ("fit-keyframes keyframes.csv --out new.npz --seed -1", "--seed -1"),
    "keyframes as recordings": ("project skill.npz keyframes.csv --out onto.csv", "holds 'keyframes'"),
    "damaged": ("info damaged.npz", "checksum"),
}


@pytest.mark.parametrize(("command", "said"), HOSTILE.values(), ids=HOSTILE)
def test_bad_input_is_told_in_one_line(folder, capsys, monkeypatch, command, said):
    (folder / "damaged.npz").write_bytes((folder / "skill.npz").read_bytes()[:-100])
    (folder / "joints.csv").write_text("demo,a,b\n0,1,2\n0,3,4\n1,1,2\n1,3,4\n")
    (folder / "one.csv").write_text("x,y,z,qw,qx,qy,qz\n0,0,0,1,0,0,0\n1,0,0,1,0,0,0\n")
    monkeypatch.chdir(folder)
    code, out, err = run(capsys, *command.split())
    assert (code, out) == (2, "")
    lines = err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("skillfold: error: ") and said in lines[0]
