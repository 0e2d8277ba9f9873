"""Pictures of the carried tray and of pushed runs, with snapshots where MuJoCo can draw."""

import numpy as np
import pytest

from skillfold.errors import InputError, RobotError
from skillfold.experiments import tray_demo, tumbler_shown
from skillfold.robots import rendering
from skillfold.viewing import snapshot_pictures, tumbler_pictures
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


@pytest.fixture(scope="module")
def examples(carrying):
    return tumbler_shown.examples(carrying.skill, np.random.default_rng(4))


def test_pushed_runs_are_drawn(examples, tmp_path):
    path, note = snapshot_pictures.draw(examples, tmp_path / "snapshots.png")
    assert path.stat().st_size > 20_000
    assert note == "" or "MUJOCO_GL" in note


def test_without_a_way_to_draw_arms_are_lines_and_a_note_says_so(examples, tmp_path, monkeypatch):
    def nowhere(*_, **__):
        raise RobotError("No pictures: MuJoCo cannot draw off the screen here. Set MUJOCO_GL.")

    monkeypatch.setattr(rendering, "pictures", nowhere)
    _, note = snapshot_pictures.draw(examples, tmp_path / "snapshots.png")
    assert "MUJOCO_GL" in note and "lines" in note
    made = snapshot_pictures.snapshots(examples, [])
    assert len(made.axes) == len(examples) * snapshot_pictures.SHOTS
    assert all(ax.has_data() for ax in made.axes)


def test_what_is_drawn_goes_from_left_to_right(examples):
    for example, kind in zip(examples, ("tool", "forearm"), strict=True):
        rows = snapshot_pictures.rows_of(example)
        assert example.title.startswith(f"{kind} pushed with {np.linalg.norm(example.trial.push.force):.0f} N")
        assert rows == sorted(rows) and rows[0] == 0 and len(set(rows)) == snapshot_pictures.SHOTS
        ways = [snapshot_pictures._ways(example, row)[0] for row in rows[1:]]
        assert [len(way) for way in ways] == sorted({len(way) for way in ways})
