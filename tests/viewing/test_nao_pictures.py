"""The pictures of the Nao, of a skill that goes straight."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from joblib import parallel_config

from skillfold.errors import InputError
from skillfold.experiments import nao_balance, nao_stepping
from skillfold.experiments.nao_poses import Optimiser
from skillfold.experiments.rows import Settings
from skillfold.robots.shapes import Sphere
from skillfold.viewing import nao_around_pictures, nao_balance_pictures, nao_bodies, nao_step_pictures
from skillfold.viewing.reproduced import nao


class Straight:
    """Projects to one pose a little off home; goes straight."""

    dim = 3

    def project(self, states, near=None):
        home = Optimiser("left").robot.home
        return home + 0.01 * np.tanh(states)

    def tangent(self, state):
        return np.eye(12)[:, :3]

    def plan(self, start, goal, points=9, via=None, obstacles=None):
        states = np.linspace(start, goal, points)
        return SimpleNamespace(path=SimpleNamespace(states=states), success=True)


@pytest.fixture(scope="module", autouse=True)
def in_one_process():
    """What starts others takes longer than so few trials."""
    with parallel_config(backend="sequential"):
        yield


@pytest.fixture(scope="module")
def settings():
    return Settings(0, fit=lambda demos, **options: Straight())


@pytest.fixture(scope="module")
def table(settings):
    return nao_balance.run(settings, nao_balance.Counts((12,), 2))[0]


@pytest.fixture(scope="module")
def stepping(settings):
    return nao_stepping.run(settings, nao_stepping.Counts(2, 2, 3, 2))


@pytest.fixture
def blind(monkeypatch):
    """Nothing can be drawn off the screen."""
    monkeypatch.setattr(nao_bodies, "shots", lambda *args, **options: [])


def gaps(figure):
    """Texts of a figure that leave its edges."""
    width, height = figure.bbox.width, figure.bbox.height
    boxes = [(text.get_text(), text.get_window_extent()) for text in figure.texts]
    return [text for text, box in boxes if box.x0 < 0 or box.y0 < 0 or box.x1 > width or box.y1 > height]


def test_balance_is_written(table, tmp_path):
    files = nao_balance_pictures.draw(table, tmp_path)
    assert all(path.stat().st_size > 20_000 for path in files if path)


def test_balance_goes_without_snapshots(table, tmp_path, blind):
    files = nao_balance_pictures.draw(table, tmp_path)
    assert [path is None for path in files] == [False, False, True, False]
    assert [picture.figures for picture in nao._pictures(files, nao.BALANCE)] == ["figure 25", "figure 26", ""]
    with pytest.raises(InputError, match="cannot be written"):
        nao_balance_pictures.draw(table, tmp_path / "nowhere")


def test_every_foot_position_is_shown(table):
    space, above, beside = nao_balance_pictures.reach(table).axes
    for ax in (space, above, beside):
        counts = [len(line.get_xdata()) for line in ax.lines[:3]]
        assert counts == [len(table.missed), len(table.demonstrations), len(table.trials)]


def test_who_stands_is_drawn_as_long_as_the_rows_say(table):
    trial = table.trials[0]
    falls = replace(trial.floor.verdicts[0], margin=-1.0)
    fallen = replace(trial, floor=replace(trial.floor, verdicts=(falls, falls)))
    ax = nao_balance_pictures.judged(replace(table, trials=[fallen, *table.trials[1:]])).axes[2]
    bars = [line.get_xdata()[1] for line in ax.lines if len(line.get_xdata()) == 2]
    assert len(bars) == 2 * 10
    projected = sum(trial.floor.verdicts[0].stable for trial in table.trials[1:])
    assert bars[-4] == pytest.approx(projected / len(table.trials))


def test_snapshots_lie_beside_each_other_and_texts_inside(table):
    shot = np.full((480, 640, 3), 200, np.uint8)
    for figure in (
        nao_balance_pictures.motion([shot] * 20, [str(i) for i in range(20)]),
        nao_balance_pictures.projections(table),
        nao_balance_pictures.reach(table),
    ):
        boxes = [ax.get_position() for ax in figure.axes if ax.images]
        assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[i + 1 :])
        assert gaps(figure) == []


def test_skeletons_join_at_the_torso_and_stand_on_the_left_foot():
    spine, left, right, *arms, sole, other = nao_bodies.skeleton(Optimiser("left").robot.home)
    np.testing.assert_allclose(left[0], spine[0])
    np.testing.assert_allclose(right[0], spine[0])
    np.testing.assert_allclose(left[-1], [0.0, 0.0], atol=1e-12)
    assert len(arms) == 2
    assert spine[1, 1] > spine[0, 1] > right[1, 1] > right[2, 1] > right[-1, 1] - 1e-9
    np.testing.assert_allclose(sole, np.pad(nao_bodies.sole(), ((0, 0), (0, 1))) @ nao_bodies.plane().T, atol=1e-9)
    np.testing.assert_allclose(other[0], other[-1])


def test_steps_are_written(stepping, tmp_path):
    files = *nao_step_pictures.draw(stepping, tmp_path), *nao_around_pictures.draw(stepping.around, tmp_path)
    assert all(path.stat().st_size > 20_000 for path in files if path)


def test_steps_go_without_snapshots(stepping, tmp_path, blind):
    files = *nao_step_pictures.draw(stepping, tmp_path), *nao_around_pictures.draw(stepping.around, tmp_path)
    assert [path is None for path in files] == [False] * 5 + [True]


def test_graphs_join_every_sample(stepping):
    left, inset, *_ = nao_step_pictures.graphs(stepping).axes
    examples = stepping.skills["left"].examples
    assert len(left.lines[0].get_xdata()) == 10 * len(examples)
    assert len(inset.lines) == len(examples)


def test_the_first_balls_come_before_the_first_edges(stepping):
    ball, other, edge = stepping.around
    assert [isinstance(answer.case.obstacle, Sphere) for answer in (ball, other, edge)] == [True, True, False]
    shown = nao_around_pictures.mixed([edge, ball, other, ball, edge, edge])
    assert [id(answer) for answer in shown] == [id(answer) for answer in (ball, other, edge, edge)]
