"""`skillfold reproduce`: what it writes, what it says, and how it ends."""

import json
from io import StringIO

import pytest
from rich.console import Console

from skillfold.cli import console, main
from skillfold.viewing import reproduced
from viewing.stand_ins import experiments

NAMES = ("one", "two", "three")


@pytest.fixture
def made(monkeypatch, tmp_path):
    """Three experiments that cost nothing in place of the papers', and an empty folder to work in."""
    every, counted = experiments(*NAMES)
    monkeypatch.setattr(reproduced, "EXPERIMENTS", every)
    monkeypatch.chdir(tmp_path)
    return counted


def run(capsys, *arguments):
    code = main(["reproduce", *map(str, arguments)])
    out, err = capsys.readouterr()
    return code, out, err


def test_it_writes_a_report_and_shows_tables(made, tmp_path, capsys):
    code, out, err = run(capsys, "--seed", 7)
    assert code == 0
    assert {"report.html", "report.json", "one.json", "one.png"} <= {
        file.name for file in (tmp_path / "results").iterdir()
    }
    assert "Section I: two" in out and "✓" in out and "✗" in out and "0.95" in out
    assert "3 of 12 targets met; seed 7; report: results/report.html" in out
    assert "skillfold: two (2 of 3): trying …" in err.splitlines()
    assert not made["one"].calls[0].quick


def test_json_is_that_of_the_report(made, tmp_path, capsys):
    code, out, _ = run(capsys, "two", "--quick", "--json", "--out", "r")
    told = json.loads(out, parse_constant=pytest.fail)
    assert code == 0 and told == json.loads((tmp_path / "r" / "report.json").read_text())
    assert [part["name"] for part in told["experiments"]] == ["two"]
    assert made["two"].calls[0].quick and not made["one"].calls


def test_data_reaches_the_experiments(made, tmp_path, capsys):
    (tmp_path / "recordings").mkdir()
    assert run(capsys, "one", "--data", "recordings")[0] == 0
    assert made["one"].calls[0].data == (tmp_path / "recordings").resolve()


def test_ctrl_c_leaves_a_report_and_says_how_to_go_on(made, tmp_path, capsys):
    made["two"].raises = KeyboardInterrupt()
    code, out, err = run(capsys)
    assert (code, out) == (130, "")
    assert "1 finished, in results/report.html; two, three left; the same command goes on" in err
    assert err.splitlines()[-1] == "skillfold: stopped"
    assert "one reached" in (tmp_path / "results" / "report.html").read_text()
    made["two"].raises = None
    code, out, err = run(capsys)
    assert code == 0 and "taken over: one; --fresh" in err
    assert "Section I: one" in out and [len(made[name].calls) for name in NAMES] == [1, 2, 1]


def test_ctrl_c_in_a_fresh_run_says_what_to_leave_out(made, capsys):
    made["two"].raises = KeyboardInterrupt()
    code, _, err = run(capsys, "--fresh")
    assert code == 130 and "the same command without --fresh goes on" in err


def test_an_experiment_that_fails_ends_with_1_after_all_others(made, tmp_path, capsys):
    made["two"].raises = ValueError("no way")
    code, out, _ = run(capsys)
    assert code == 1 and len(made["three"].calls) == 1
    assert "two ended with an error. ValueError: no way" in out
    assert "no way" in (tmp_path / "results" / "report.html").read_text()


def test_a_complete_run_begins_anew_and_says_so(made, capsys):
    run(capsys)
    code, _, err = run(capsys)
    assert code == 0 and "skillfold: note: the run in results is complete: begun anew." in err.splitlines()
    assert made["one"].calls[0].seed != made["one"].calls[1].seed


def test_list_names_every_experiment_and_runs_nothing(made, tmp_path, capsys):
    code, out, _ = run(capsys, "--list")
    assert code == 0 and out.split("\n")[1].split("  ")[0] == "two" and "Section I: two" in out
    assert json.loads(run(capsys, "--list", "--json")[1]) == {name: f"Section I: {name}" for name in NAMES}
    assert not (tmp_path / "results").exists()


HOSTILE = {
    "unknown name": ("one four", "No experiment named four; there are one, two, three."),
    "negative seed": ("--seed -1", "--seed -1"),
    "no such data": ("--data nowhere", "--data nowhere"),
    "into a file": ("--out file", "file"),
    "into a folder of a report": ("--out odd", "report.json: cannot be written"),
}


@pytest.mark.parametrize(("command", "said"), HOSTILE.values(), ids=HOSTILE)
def test_bad_input_is_told_in_one_line(made, tmp_path, capsys, command, said):
    (tmp_path / "file").write_text("")
    (tmp_path / "odd" / "report.json").mkdir(parents=True)
    code, out, err = run(capsys, *command.split())
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert line.startswith("skillfold: error: ") and said in line
    assert not any(counted.calls for counted in made.values())


def test_help_names_every_experiment(capsys):
    _, text, _ = run(capsys, "--help")
    words = " ".join(text.replace("│", " ").split())
    for name in reproduced.EXPERIMENTS:
        assert name in words


def test_a_terminal_shows_the_whole_and_the_part_under_way(monkeypatch):
    screen = Console(file=StringIO(), force_terminal=True, width=100)
    monkeypatch.setattr(console, "_console", lambda stderr: screen)
    with console.progress_in_parts() as begin:
        begin("one (1 of 2)", 0.0)("learning", 0.5)
        begin("two (2 of 2)", 0.5)("planning", 1.0)
    shown = screen.file.getvalue()
    assert "two (2 of 2)" in shown and "planning" in shown
