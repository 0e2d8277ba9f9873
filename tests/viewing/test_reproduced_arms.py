"""The arms' experiments: fewer trials for a first look, pictures that are there, and what differs from the paper."""

import re
from dataclasses import replace
from types import SimpleNamespace

import pytest

from skillfold.experiments.rows import Row, Settings
from skillfold.viewing.reproduced import arms
from skillfold.viewing.reproduced.arms import ARMS

ROW = Row("measured", 1.0)


@pytest.fixture
def asked(monkeypatch):
    """What is asked of each experiment; nothing is measured or drawn."""
    seen = {}

    def keep(name, answer):
        return lambda settings, *counts: seen.update({name: counts}) or answer

    run = SimpleNamespace(answers=[None] * 4, skill=None)
    for module, name, answer in (
        (arms.reaching, "measure", [ROW]),
        (arms.around_arm, "measure", [ROW]),
        (arms.table_one, "table", ()),
        (arms.around_tray, "prepare", None),
        (arms.tumblers, "measure", [ROW]),
    ):
        monkeypatch.setattr(module, name, keep(module.__name__.rsplit(".", 1)[1], answer))
    monkeypatch.setattr(arms.around_tray, "run", lambda task, settings: [run] * 3)
    monkeypatch.setattr(arms.around_tray, "rows", lambda task, runs: [ROW])
    monkeypatch.setattr(arms.reaching_shown, "run", lambda settings: None)
    monkeypatch.setattr(arms.reaching_shown, "rows", lambda shown: [ROW])
    monkeypatch.setattr(arms.around_shown, "scenes", lambda settings: None)
    monkeypatch.setattr(arms.tray_demo, "run", lambda rng: SimpleNamespace(skill=None))
    monkeypatch.setattr(arms.tumbler_shown, "examples", lambda skill, rng: [])
    monkeypatch.setattr(arms.reaching_pictures, "draw", lambda shown, folder: [folder / f"{i}.png" for i in "abc"])
    for drawn in (arms.around_pictures, arms.pushed_pictures, arms.table_pictures):
        monkeypatch.setattr(drawn, "draw", lambda what, path: path)
    monkeypatch.setattr(arms.tray_pictures, "draw", lambda skill, answers, path: path)
    for drawn in (arms.snapshot_pictures, arms.tumbler_pictures):
        monkeypatch.setattr(drawn, "draw", lambda what, path: (path, "No pictures: set MUJOCO_GL."))
    return seen


def test_every_figure_of_the_arms_is_drawn(asked, tmp_path):
    results = [experiment.run(Settings(0), tmp_path) for experiment in ARMS.values()]
    pictures = [picture for result in results for picture in result.pictures]
    assert len({picture.file for picture in pictures}) == len(pictures)
    figures = {int(number) for picture in pictures for number in re.findall(r"\d+", picture.figures)}
    assert figures == {8, 9, 10, 11, 12, 13, 15, 16}
    assert all(picture.caption for picture in pictures)


def test_a_first_look_asks_for_less(asked, tmp_path):
    settings = Settings(0)
    for experiment in ARMS.values():
        experiment.run(settings, tmp_path)
    whole = dict(asked)
    for experiment in ARMS.values():
        experiment.run(replace(settings, quick=True), tmp_path)
    assert set(asked) == {"reaching", "around_arm", "table_one", "around_tray", "tumblers"}
    for name in set(asked) - {"around_arm"}:
        assert all(few < many for few, many in zip(asked[name], whole[name], strict=True))
    assert whole["around_arm"] == (None,)  # its own counts
    assert sum(asked["around_arm"][0].cases) < sum(arms.around_arm.Counts().cases)


def test_where_nothing_is_drawn_off_the_screen_the_caption_says_so(asked, tmp_path):
    result = ARMS["tumblers"].run(Settings(0), tmp_path)
    assert all(picture.caption.endswith("No pictures: set MUJOCO_GL.") for picture in result.pictures)


def test_each_says_what_differs_from_the_paper():
    for experiment in ARMS.values():
        assert experiment.paper == "000"
        assert experiment.differs and all(sentence.endswith(".") for sentence in experiment.differs)
