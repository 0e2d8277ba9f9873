"""The command line: what it writes, what it says, and how it ends."""

import csv
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import skillfold
from skillfold.cli import main
from skillfold.demonstrations import Demonstrations
from skillfold.experiments import bench
from skillfold.experiments.rows import Row
from skillfold.manifold.skill import SkillManifold

PHASE = np.linspace(0.0, 1.0, 40)
RECORDINGS = [np.column_stack([3 * PHASE, np.sin(3 * PHASE) + shift]) for shift in (0.0, 0.04, 0.08)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Three recordings, a skill learnt from them, one learnt from a cloud, and some states."""
    made = tmp_path_factory.mktemp("skill")
    demos = Demonstrations(RECORDINGS, times=PHASE, names=["x", "y"])
    demos.save(made / "recordings.csv")
    SkillManifold.fit(demos, dim=1, kernels=5, ridge=1e-4).save(made / "skill.npz")
    SkillManifold.fit(np.concatenate(RECORDINGS), dim=1, kernels=5, ridge=1e-4).save(made / "cloud.npz")
    (made / "states.csv").write_text("t,y,x\n0.0,0.5,0.6\n0.1,1.1,1.5\n0.2,0.4,2.9\n")
    return made


def run(capsys, *arguments):
    code = main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return code, out, err


def table(path):
    with Path(path).open(newline="") as file:
        return list(csv.DictReader(file))


def numbers(path):
    return np.loadtxt(path, delimiter=",", skiprows=1)


def test_fit_saves_a_skill_and_reports_it(folder, tmp_path, capsys):
    out = tmp_path / "new.npz"
    code, text, err = run(capsys, "fit", folder / "recordings.csv", "--out", out, "--dim", 1, "--kernels", 5)
    assert code == 0
    assert "residual" in text and "demonstrations  3" in text
    assert "skillfold:" in err and "skillfold:" not in text
    assert SkillManifold.load(out).names == ("x", "y")


def test_fit_appends_velocity_and_phase(folder, tmp_path, capsys):
    out = tmp_path / "long.npz"
    options = ("--dim", 1, "--kernels", 5, "--ridge", 1e-4, "--phase", "--velocity", "--json")
    code, text, _ = run(capsys, "fit", folder / "recordings.csv", "--out", out, *options)
    assert code == 0
    assert json.loads(text)["coordinates"] == ["x", "y", "x_velocity", "y_velocity", "phase"]


def test_fit_of_a_cloud_keeps_the_names_and_knows_no_route(folder, tmp_path, capsys):
    out = tmp_path / "cloud.npz"
    code, text, _ = run(capsys, "fit", folder / "recordings.csv", "--out", out, "--cloud", "--dim", 1, "--json")
    told = json.loads(text)
    assert code == 0
    assert told["coordinates"] == ["x", "y"]
    assert told["demonstrations"] is None
    assert SkillManifold.load(out).route is None


def test_info_tells_facts_and_selection(folder, capsys):
    code, text, err = run(capsys, "info", folder / "skill.npz")
    assert (code, err) == (0, "")
    assert "coordinates" in text and "x, y" in text and "✓" in text
    code, text, _ = run(capsys, "info", folder / "skill.npz", "--json")
    told = json.loads(text)
    assert told["dim"] == 1 and told["n_dims"] == 2 and told["samples"] == 120
    assert any(trial["chosen"] for trial in told["selection"])


def test_plan_writes_a_path_that_loads_as_a_recording(folder, tmp_path, capsys):
    out = tmp_path / "path.csv"
    code, text, _ = run(
        capsys, "plan", folder / "skill.npz", "--start", "0.0,0.02", "--goal", "3,0.2", "--out", out, "--json"
    )
    told = json.loads(text)
    assert code == 0 and told["success"] is True
    states = Demonstrations.load(out)[0].states
    np.testing.assert_array_equal(states, told["states"])
    np.testing.assert_array_equal(states[0], [0.0, 0.02])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("demo:0:first", RECORDINGS[0][0]),
        ("demo:2:last", RECORDINGS[2][-1]),
        ("states.csv:0", [0.6, 0.5]),
        ("states.csv:last", [2.9, 0.4]),
        ("-0.0, 0.02", [0.0, 0.02]),
        ("1e-2 3e-2", [0.01, 0.03]),
    ],
)
def test_states_may_be_given_in_many_ways(folder, capsys, monkeypatch, text, expected):
    monkeypatch.chdir(folder)
    code, out, _ = run(
        capsys, "plan", "skill.npz", "--start", text, "--goal", "1.5,1.0", "--route", "demonstrated", "--json"
    )
    told = json.loads(out)
    assert code in (0, 1)
    if told["success"]:
        np.testing.assert_allclose(told["states"][0], expected, atol=1e-12)


def test_plan_passes_via_points_and_points_on(folder, capsys):
    ends = ("--start", "demo:0:first", "--goal", "demo:0:last")
    more = ("--via", "1.5,1.05", "--via", "2.4,0.7", "--points", 33, "--json")
    code, out, _ = run(capsys, "plan", folder / "skill.npz", *ends, *more)
    states = np.array(json.loads(out)["states"])
    assert code == 0 and len(states) == 33
    assert [1.5, 1.05] in states.tolist() and [2.4, 0.7] in states.tolist()


def test_rows_of_recordings_need_the_recordings(folder, capsys):
    ends = ("--start", "demo:1:5", "--goal", "demo:1:last", "--json")
    code, out, err = run(capsys, "plan", folder / "skill.npz", *ends)
    assert (code, out) == (2, "") and "--recordings" in err
    code, out, _ = run(capsys, "plan", folder / "skill.npz", *ends, "--recordings", folder / "recordings.csv")
    assert code == 0
    np.testing.assert_array_equal(json.loads(out)["states"][0], RECORDINGS[1][5])


def test_a_plan_that_fails_ends_with_1_and_writes_nothing(folder, tmp_path, capsys, monkeypatch):
    out = tmp_path / "path.csv"
    plan = SkillManifold.plan

    def fails(*given, **options):
        return replace(plan(*given, **options), success=False, reason="The path jumps.")

    monkeypatch.setattr(SkillManifold, "plan", fails)
    ends = ("--start", "0,0", "--goal", "3,0.2", "--out", out)
    code, text, err = run(capsys, "plan", folder / "skill.npz", *ends, "--json")
    told = json.loads(text)
    assert code == 1 and told["success"] is False and told["states"] is None
    assert err == "skillfold: no path: The path jumps.\n"
    assert not out.exists()


def test_project_adds_distances_and_keeps_time(folder, tmp_path, capsys):
    out = tmp_path / "onto.csv"
    code, text, _ = run(capsys, "project", folder / "skill.npz", folder / "states.csv", "--out", out, "--json")
    told, rows = json.loads(text), table(out)
    assert code == 0 and told["states"] == 3
    assert list(rows[0]) == ["t", "x", "y", "distance", "inside"]
    assert [float(row["t"]) for row in rows] == [0.0, 0.1, 0.2]
    skill = SkillManifold.load(folder / "skill.npz")
    states = np.array([[0.6, 0.5], [1.5, 1.1], [2.9, 0.4]])
    np.testing.assert_allclose(numbers(out)[:, 1:3], skill.project(states))
    np.testing.assert_allclose(numbers(out)[:, 3], skill.distance(states))


def test_project_keeps_the_order_of_mixed_recordings(folder, tmp_path, capsys):
    states = tmp_path / "mixed.csv"
    states.write_text("demo,x,y\na,0.1,0.1\nb,0.2,0.2\na,0.3,0.3\n")
    code, _, _ = run(capsys, "project", folder / "skill.npz", states, "--out", tmp_path / "onto.csv")
    assert code == 0
    assert [row["demo"] for row in table(tmp_path / "onto.csv")] == ["a", "b", "a"]


def test_unnamed_coordinates_take_any_columns_in_order(folder, tmp_path, capsys):
    states = tmp_path / "named.csv"
    states.write_text("shoulder,elbow\n0.5,0.6\n")
    code, _, _ = run(capsys, "project", folder / "cloud.npz", states, "--out", tmp_path / "onto.csv")
    assert code == 0
    assert list(table(tmp_path / "onto.csv")[0]) == ["x0", "x1", "distance", "inside"]


HOSTILE = {
    "no such recording": ("fit nowhere.csv --out new.npz", "nowhere.csv"),
    "no recordings": ("fit --out new.npz", "No recordings"),
    "missing folder": ("fit recordings.csv --out nowhere/new.npz", "no folder nowhere"),
    "output is a folder": ("fit recordings.csv --out .", "is a folder"),
    "impossible dimension": ("fit recordings.csv --out new.npz --dim 7", "dim"),
    "phase of a cloud": ("fit recordings.csv --out new.npz --cloud --phase", "--cloud"),
    "a skill as recording": ("fit skill.npz --out new.npz", "skill.npz"),
    "no such skill": ("info nowhere.npz", "nowhere.npz"),
    "damaged skill": ("info damaged.npz", "checksum"),
    "recordings as skill": ("plan recordings.csv --start 0,0 --goal 1,1", "recordings.csv"),
    "text for numbers": ("plan skill.npz --start a,b --goal 1,1", "'a,b'"),
    "wrong dimensions": ("plan skill.npz --start 0,0,0 --goal 1,1", "3 numbers; expected 2: x, y"),
    "no number": ("plan skill.npz --start nan,0 --goal 1,1", "nan"),
    "row beyond the file": ("plan skill.npz --start states.csv:9 --goal 1,1", "from 0 to 2"),
    "row in words": ("plan skill.npz --start states.csv:third --goal 1,1", "third"),
    "no such state file": ("plan skill.npz --start none.csv:0 --goal 1,1", "none.csv"),
    "demonstration beyond": ("plan skill.npz --start demo:9:first --goal 1,1", "there are 3 demonstrations"),
    "demo without state": ("plan skill.npz --start demo:0 --goal 1,1", "demo:0:first"),
    "demo of a cloud": ("plan cloud.npz --start demo:0:first --goal 1,1", "--recordings"),
    "route of a cloud": ("plan cloud.npz --start 0,0 --goal 1,1 --route demonstrated", "recordings"),
    "too few points": ("plan skill.npz --start 0,0 --goal 1,1 --points 1", "points"),
    "other recordings": ("plan skill.npz --start demo:0:1 --goal 1,1 --recordings other.csv", "a, b"),
    "unwritable path": ("plan skill.npz --start 0,0 --goal 1,1 --out nowhere/path.csv", "no folder"),
    "other columns": ("project skill.npz other.csv --out onto.csv", "expected x, y"),
    "empty states": ("project skill.npz empty.csv --out onto.csv", "no rows"),
    "infinite state": ("project skill.npz infinite.csv --out onto.csv", "row 2, column 'y'"),
    "text in states": ("project skill.npz text.csv --out onto.csv", "'left'"),
    "unknown group": ("bench --groups velocity", "velocity"),
    "two reports": ("bench --json a.json b.json", "--json"),
    "report in a missing folder": ("bench --json nowhere/a.json", "no folder"),
    "no such data": ("bench --groups arm --data nowhere", "nowhere"),
    "negative seed of bench": ("bench --groups arm --seed -1", "--seed -1"),
    "negative seed of demo": ("demo --out d --seed -1", "--seed -1"),
    "nobody's folder": ("fit recordings.csv --out ~nobody/x.npz", "no folder"),
    "demo into a file": ("demo --out states.csv", "states.csv"),
}


@pytest.mark.parametrize(("command", "said"), HOSTILE.values(), ids=HOSTILE)
def test_bad_input_is_told_in_one_line(folder, capsys, monkeypatch, command, said):
    (folder / "damaged.npz").write_bytes((folder / "skill.npz").read_bytes()[:-100])
    (folder / "other.csv").write_text("a,b\n1,2\n3,4\n")
    (folder / "empty.csv").write_text("x,y\n")
    (folder / "infinite.csv").write_text("x,y\n1,inf\n")
    (folder / "text.csv").write_text("x,y\n1,left\n")
    monkeypatch.chdir(folder)
    code, out, err = run(capsys, *command.split())
    assert (code, out) == (2, "")
    lines = [line for line in err.splitlines() if not line.endswith("…")]
    assert len(lines) == 1 and lines[0].startswith("skillfold: error: ") and said in lines[0]


@pytest.mark.parametrize("command", ["plan", "fit x.csv --out y.npz --dim two", "plant", "info a.npz --jsn"])
def test_wrong_usage_ends_with_2_and_leaves_stdout_clean(capsys, command):
    code, out, err = run(capsys, *command.split())
    assert (code, out) == (2, "")
    assert err and "Traceback" not in err


def test_ctrl_c_ends_with_130(folder, capsys, monkeypatch):
    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(SkillManifold, "load", stop)
    assert run(capsys, "info", folder / "skill.npz") == (130, "", "skillfold: stopped\n")


def test_help_and_version(capsys):
    assert run(capsys, "--version") == (0, f"skillfold {skillfold.__version__}\n", "")
    code, text, _ = run(capsys)
    assert code == 0 and "radians" in text and "seconds" in text
    for command in ("fit", "info", "plan", "project", "simulate", "demo", "bench"):
        assert run(capsys, command, "--help")[0] == 0
        assert command in text


def test_help_names_every_group_of_the_benchmark(capsys):
    _, text, _ = run(capsys, "bench", "--help")
    assert ", ".join(bench.GROUPS) in " ".join(text.replace("│", " ").split())


def test_bench_reports_as_table_and_as_json(tmp_path, capsys, monkeypatch):
    rows = [Row("fast", 1.0, "s", 2.0, "<"), Row("slow", 3.0, "s", 2.0, "<"), Row("absent", None, note="no data")]
    monkeypatch.setitem(bench.GROUPS, "arm", (lambda settings: rows,))
    file = tmp_path / "bench.json"
    code, text, _ = run(capsys, "bench", "--groups", "arm", "--seed", 7, "--json", file)
    assert code == 0
    assert "✓" in text and "✗" in text and "1 of 2 targets met" in text and "seed 7" in text
    code, text, _ = run(capsys, "bench", "--groups", "arm", "--seed", 7, "--json")
    assert code == 0
    assert json.loads(text)["rows"] == json.loads(file.read_text())["rows"]


def test_numbers_that_json_has_not_become_null(capsys, monkeypatch):
    monkeypatch.setitem(bench.GROUPS, "arm", (lambda settings: [Row("lost", float("nan"))],))
    _, text, _ = run(capsys, "bench", "--groups", "arm", "--json")
    assert json.loads(text, parse_constant=pytest.fail)["rows"][0]["measured"] is None


def test_help_is_light():
    code = (
        "import sys; from skillfold.cli import main; main(['--help']); "
        "heavy = {'numpy', 'numba', 'matplotlib', 'scipy', 'sklearn', 'mujoco'} & set(sys.modules); "
        "sys.exit(str(heavy) if heavy else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_terminal_that_knows_no_unicode(folder):
    code = "import sys; from skillfold.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", code, "info", str(folder / "skill.npz")]
    done = subprocess.run(command, capture_output=True, env={**os.environ, "PYTHONIOENCODING": "ascii"}, check=False)
    assert done.returncode == 0, done.stderr


def test_a_closed_pipe_is_no_error(folder):
    code = "import sys; from skillfold.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", code, "info", str(folder / "skill.npz"), "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout and process.stderr
        process.stdout.close()
        assert process.wait(timeout=60) == 0
        assert process.stderr.read() == b""


def test_the_package_runs_as_a_module():
    command = [sys.executable, "-m", "skillfold", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == f"skillfold {skillfold.__version__}\n"
