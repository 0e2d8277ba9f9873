"""The pictures of the Nao, of a skill that goes straight."""

from types import SimpleNamespace

import numpy as np
import pytest

from skillfold.errors import InputError
from skillfold.experiments import nao_balance, nao_stepping
from skillfold.experiments.nao_poses import Optimiser
from skillfold.experiments.rows import Settings
from skillfold.viewing import nao_pictures


class Straight:
    """Projects to one pose a little off home; goes straight."""

    dim = 3

    def project(self, states):
        home = Optimiser("left").robot.home
        return home + 0.01 * np.tanh(states)

    def plan(self, start, goal, via=None, obstacles=None):
        states = np.linspace(start, goal, 9)
        return SimpleNamespace(path=SimpleNamespace(states=states), success=True)


@pytest.fixture(scope="module")
def settings():
    return Settings(0, fit=lambda demos, **options: Straight())


@pytest.fixture(scope="module")
def table(settings):
    return nao_balance.run(settings, nao_balance.Counts((8,), 2))[0]


def test_balance_is_written(table, tmp_path):
    path = nao_pictures.draw_balance(table, tmp_path / "balance.png")
    assert path.stat().st_size > 20_000


def test_balance_goes_without_snapshots(table, tmp_path, monkeypatch):
    shots = [np.full((480, 640, 3), 200, np.uint8)] * 2
    assert len(nao_pictures.balance(table, shots).axes) == 3 + 2 + 2
    assert len(nao_pictures.balance(table, []).axes) == 3 + 2
    monkeypatch.setattr(nao_pictures, "_shots", lambda poses: [])
    with pytest.raises(InputError, match="cannot be written"):
        nao_pictures.draw_balance(table, tmp_path / "nowhere" / "balance.png")


def test_skeletons_join_at_the_torso_and_stand_on_the_left_foot():
    spine, left, right = nao_pictures.skeleton(Optimiser("left").robot.home)
    np.testing.assert_allclose(left[0], spine[0])
    np.testing.assert_allclose(right[0], spine[0])
    np.testing.assert_allclose(left[-1], [0.0, 0.0], atol=1e-12)
    assert spine[1, 1] > spine[0, 1] > right[1, 1] > right[2, 1] > right[-1, 1] - 1e-9


def test_steps_are_written(settings, tmp_path):
    stepping = nao_stepping.run(settings, nao_stepping.Counts(1, 2, 3, 2))
    path = nao_pictures.draw_stepping(stepping, tmp_path / "steps.png")
    assert path.stat().st_size > 20_000
