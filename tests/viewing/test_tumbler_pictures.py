"""The picture of the carried tray, with snapshots where MuJoCo can draw."""

import numpy as np
import pytest

from skillfold.errors import InputError
from skillfold.experiments import tray_demo
from skillfold.viewing import tumbler_pictures
from skillfold.viewing.tumbler_pictures import draw


@pytest.fixture(scope="module")
def carrying():
    return tray_demo.carried(tray_demo.skill_of(np.random.default_rng(0), 150, dim=3, kernels=30, ridge=1e-5))


def test_the_picture_is_written(carrying, tmp_path):
    path, note = draw(carrying, tmp_path / "tray.png")
    assert path.stat().st_size > 20_000
    assert note == "" or "MUJOCO_GL" in note


def test_it_has_room_for_snapshots_and_goes_without(carrying, tmp_path, monkeypatch):
    shots = [np.full((480, 640, 3), 200, np.uint8)] * 4
    assert len(tumbler_pictures.tumblers(carrying, shots).axes) == 9
    assert len(tumbler_pictures.tumblers(carrying, []).axes) == 5
    monkeypatch.setattr(tumbler_pictures, "_shots", lambda carrying: ([], ""))
    with pytest.raises(InputError, match="cannot be written"):
        draw(carrying, tmp_path / "nowhere" / "tray.png")
