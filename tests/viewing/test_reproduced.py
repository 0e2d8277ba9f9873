"""Experiments repeated: what is finished is kept, what was stopped goes on, and nothing of another run counts."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from skillfold.errors import InputError, MissingExtraError
from skillfold.viewing.reproduced import EXPERIMENTS, report, running, stored
from skillfold.viewing.reproduced.running import Asked
from viewing.stand_ins import experiments, png

NAMES = ("one", "two", "three")


def silent(part, done):
    return lambda stage, share: None


def repeat(asked, every, folder):
    """A whole call: what it took up and what it came to."""
    under_way = running.take_up(asked, every, folder)
    taken = list(under_way.taken)
    running.go_on(under_way, every, folder, silent, lambda now: report.write(now, every, folder))
    return under_way, taken


def told(folder):
    return json.loads((folder / "report.json").read_text(), parse_constant=pytest.fail)


def test_all_run_in_order_with_what_was_asked_for(tmp_path):
    every, made = experiments(*NAMES)
    under_way, taken = repeat(Asked(quick=True, data=tmp_path, seed=7), every, tmp_path)
    assert (taken, under_way.left, under_way.failed) == ([], [], {})
    for name in NAMES:
        (settings,) = made[name].calls
        assert (settings.seed, settings.quick, settings.data) == (7, True, tmp_path)
    assert [part["name"] for part in told(tmp_path)["experiments"]] == list(NAMES)
    assert told(tmp_path)["seed"] == 7 and told(tmp_path)["quick"] is True


def test_progress_names_the_experiment_and_passes_its_own_on(tmp_path):
    every, _ = experiments(*NAMES)
    heard = []

    def begin(part, done):
        heard.append((part, done))
        return lambda stage, share: heard.append((stage, share))

    running.go_on(running.take_up(Asked(), every, tmp_path), every, tmp_path, begin, lambda now: None)
    assert heard[:3] == [("one (1 of 3)", 0.0), ("trying", 0.5), ("two (2 of 3)", 1 / 3)]


def test_what_is_stored_is_read_back_as_it_was(tmp_path):
    every, _ = experiments("one")
    under_way, _ = repeat(Asked(seed=3), every, tmp_path)
    run, finished = stored.read(tmp_path / "one.json")
    assert run == under_way.run
    assert finished == under_way.done["one"]
    assert [row.met for row in finished.rows] == [False, None, True, None, False]


def test_a_run_that_was_stopped_goes_on_with_its_seed(tmp_path):
    every, made = experiments(*NAMES, two={"raises": KeyboardInterrupt()})
    with pytest.raises(KeyboardInterrupt):
        repeat(Asked(), every, tmp_path)
    before = told(tmp_path)
    assert [part["name"] for part in before["experiments"]] == ["one"]
    assert list(before["absent"]) == ["two", "three"]
    made["two"].raises = None
    under_way, taken = repeat(Asked(), every, tmp_path)
    assert taken == ["one"] and under_way.run.seed == before["seed"]
    assert [len(made[name].calls) for name in NAMES] == [1, 2, 1]
    assert {settings.seed for name in NAMES for settings in made[name].calls} == {before["seed"]}
    after = told(tmp_path)
    assert after["experiments"][0] == before["experiments"][0] and after["absent"] == {}


def test_a_run_killed_between_two_experiments_has_its_report(tmp_path):
    every, _ = experiments(*NAMES)
    seen = []
    under_way = running.take_up(Asked(), every, tmp_path)
    running.go_on(under_way, every, tmp_path, silent, lambda now: seen.append((list(now.done), list(now.left))))
    assert seen[0] == ([], list(NAMES)) and seen[1] == (["one"], ["two", "three"])


def test_a_complete_run_begins_anew_with_another_seed(tmp_path):
    every, made = experiments(*NAMES)
    first, _ = repeat(Asked(), every, tmp_path)
    second, taken = repeat(Asked(), every, tmp_path)
    assert taken == [] and second.run.seed != first.run.seed
    assert "complete" in " ".join(second.notes)
    assert [len(made[name].calls) for name in NAMES] == [2, 2, 2]


@pytest.mark.parametrize("asked", [Asked(seed=5), Asked(names=("two", "one"))], ids=["seed", "names"])
def test_with_its_seed_or_by_name_nothing_finished_is_measured_again(tmp_path, asked):
    every, made = experiments(*NAMES)
    repeat(Asked(seed=5), every, tmp_path)
    under_way, taken = repeat(asked, every, tmp_path)
    assert taken == list(asked.names or NAMES) and under_way.run.seed == 5
    assert [len(made[name].calls) for name in NAMES] == [1, 1, 1]
    assert len(told(tmp_path)["experiments"]) == 3


def test_further_names_join_the_run_and_its_report(tmp_path):
    every, _ = experiments(*NAMES)
    repeat(Asked(names=("three",)), every, tmp_path)
    repeat(Asked(names=("one",)), every, tmp_path)
    assert [part["name"] for part in told(tmp_path)["experiments"]] == ["one", "three"]
    assert stored.read(tmp_path / "one.json")[0] == stored.read(tmp_path / "three.json")[0]


def test_fresh_measures_what_is_asked_for_anew(tmp_path):
    every, made = experiments(*NAMES)
    repeat(Asked(seed=5), every, tmp_path)
    same, taken = repeat(Asked(names=("two",), seed=5, fresh=True), every, tmp_path)
    assert taken == [] and len(made["two"].calls) == 2
    assert sorted(same.done) == sorted(NAMES)  # the others are of the same run
    other, _ = repeat(Asked(names=("two",), fresh=True), every, tmp_path)
    assert other.run.seed != 5 and list(other.done) == ["two"]


OTHERS = {
    "seed": Asked(seed=6),
    "quick": Asked(quick=True),
    "data": Asked(data=Path("elsewhere")),
}


@pytest.mark.parametrize("asked", OTHERS.values(), ids=OTHERS)
def test_nothing_of_another_run_counts(tmp_path, asked):
    every, made = experiments(*NAMES, three={"raises": KeyboardInterrupt()})
    with pytest.raises(KeyboardInterrupt):
        repeat(Asked(seed=5), every, tmp_path)
    made["three"].raises = None
    under_way, taken = repeat(asked, every, tmp_path)
    assert taken == [] and "begun anew" in " ".join(under_way.notes)
    assert all(made[name].calls[-1].seed == under_way.run.seed for name in NAMES)


def test_nothing_of_other_versions_counts(tmp_path, monkeypatch):
    every, made = experiments(*NAMES)
    repeat(Asked(names=("one",)), every, tmp_path)
    facts = running.machine()
    monkeypatch.setattr(running, "machine", lambda: facts | {"python": "4.0"})
    assert repeat(Asked(names=("one",)), every, tmp_path)[1] == []
    assert len(made["one"].calls) == 2


def test_a_picture_drawn_over_takes_what_was_stored_with_it(tmp_path):
    """Else figures of one run would stand beside pictures of another."""
    every, made = experiments("one", "two")
    repeat(Asked(seed=5), every, tmp_path)
    made["one"].raises = KeyboardInterrupt()
    with pytest.raises(KeyboardInterrupt):
        repeat(Asked(seed=6), every, tmp_path)
    assert not (tmp_path / "one.json").exists()
    assert stored.read(tmp_path / "two.json")[0].seed == 5


FAILURES = {
    "a fault": (ZeroDivisionError("of <b>"), "ZeroDivisionError: of <b> (stand_ins.py, line "),
    "a missing package": (MissingExtraError("gmr is not installed."), "gmr is not installed."),
    "lines": (ValueError("so\n  many\nlines"), "ValueError: so many lines ("),
}


@pytest.mark.parametrize(("error", "words"), FAILURES.values(), ids=FAILURES)
def test_an_experiment_that_fails_does_not_stop_the_others(tmp_path, error, words):
    every, made = experiments(*NAMES, two={"raises": error})
    under_way, _ = repeat(Asked(), every, tmp_path)
    assert list(under_way.done) == ["one", "three"] and list(under_way.failed) == ["two"]
    part = told(tmp_path)["experiments"][1]
    assert part["failed"].startswith(words) and part["seconds"] is None and part["rows"] == []
    made["two"].raises = None
    again, taken = repeat(Asked(), every, tmp_path)
    assert taken == ["one", "three"] and again.failed == {}


def test_an_experiment_without_its_picture_has_failed(tmp_path):
    every, made = experiments("one", "two")

    def loses(settings, folder):
        result = made["one"](settings, folder)
        result.pictures[0].file.unlink()
        return result

    under_way, _ = repeat(Asked(), every | {"one": replace(every["one"], run=loses)}, tmp_path)
    assert list(under_way.failed) == ["one"] and "one.png" in under_way.failed["one"]
    assert not (tmp_path / "one.json").exists()


def test_a_folder_that_cannot_be_written_is_told(tmp_path):
    every, _ = experiments("one")
    (tmp_path / "report.json").mkdir()
    with pytest.raises(InputError, match=r"report\.json: cannot be written"):
        repeat(Asked(), every, tmp_path)
    assert not list(tmp_path.glob(".report*"))


def test_a_folder_in_the_place_of_what_is_kept_costs_that_experiment_only(tmp_path):
    every, _ = experiments("one", "two")
    (tmp_path / "one.json").mkdir()
    under_way, _ = repeat(Asked(), every, tmp_path)
    assert list(under_way.failed) == ["one"] and list(under_way.done) == ["two"]


def changed(**values):
    """A stored file with some of its values changed; None leaves one out."""

    def change(text):
        plain = json.loads(text) | values
        return json.dumps({name: value for name, value in plain.items() if value is not None})

    return change


def of_row(**values):
    def change(text):
        plain = json.loads(text)
        plain["rows"][0] |= values
        return json.dumps(plain)

    return change


PICTURE = {"file": "one.png", "figures": "", "caption": ""}
HOSTILE = {
    "cut short": lambda text: text[:-40],
    "empty": lambda text: "",
    "no object": lambda text: "[1, 2]",
    "very deep": lambda text: "[" * 100_000,
    "of another format": changed(format=2),
    "no rows": changed(rows=None),
    "rows of text": changed(rows="many"),
    "a row of numbers": changed(rows=[1]),
    "a row without name": changed(rows=[{"measured": 1.0}]),
    "a figure of text": of_row(measured="much"),
    "a figure that is true": of_row(measured=True),
    "an endless whole number": of_row(measured=10**400),
    "a figure that is a list": of_row(target=[1]),
    "another comparison": of_row(comparison="~"),
    "a note that is a number": of_row(note=3),
    "no seconds": changed(seconds=None),
    "seconds in words": changed(seconds="long"),
    "no run": changed(run=None),
    "a run of text": changed(run="mine"),
    "a run without seed": changed(run={"quick": False}),
    "a picture elsewhere": changed(pictures=[PICTURE | {"file": "../secret.png"}]),
    "a picture by its root": changed(pictures=[PICTURE | {"file": "/secret.png"}]),
    "a picture that is missing": changed(pictures=[PICTURE | {"file": "nowhere.png"}]),
    "a picture that is none": changed(pictures=[PICTURE | {"file": "one.json"}]),
    "a picture without a name": changed(pictures=[PICTURE | {"file": ""}]),
    "a picture with a zero byte": changed(pictures=[PICTURE | {"file": "a\0.png"}]),
    "a picture with a number": changed(pictures=[PICTURE | {"caption": 1}]),
}


@pytest.mark.parametrize("change", HOSTILE.values(), ids=HOSTILE)
def test_what_is_damaged_is_measured_anew(tmp_path, change):
    folder = tmp_path / "results"
    folder.mkdir()
    (tmp_path / "secret.png").write_bytes(png(1))
    every, made = experiments("one", "two")
    repeat(Asked(seed=5), every, folder)
    file = folder / "one.json"
    file.write_text(change(file.read_text()))
    under_way, taken = repeat(Asked(seed=5), every, folder)
    assert taken == ["two"] and len(made["one"].calls) == 2
    (note,) = under_way.notes
    assert note.startswith(f"{file} does not count: ") and len(note.splitlines()) == 1
    assert running.take_up(Asked(seed=5), every, folder).taken == ["one", "two"]


@pytest.mark.parametrize(
    "content",
    [b"", b"\xff\xfe", b"{}", b'{"format": 1, "seed": -1, "quick": false, "data": null, "machine": {}}', None],
)
def test_a_damaged_report_costs_nothing_but_the_seed(tmp_path, content):
    every, _ = experiments("one")
    (file := tmp_path / "report.json").write_bytes(os.urandom(50) if content is None else content)
    under_way, taken = repeat(Asked(), every, tmp_path)
    assert (taken, under_way.notes) == ([], [])
    assert stored.read_run(file) == under_way.run


def test_the_papers_experiments_can_all_be_reported():
    for name, experiment in EXPERIMENTS.items():
        assert experiment.paper in report.PAPERS and experiment.title
        assert name != "report" and Path(name).name == name
