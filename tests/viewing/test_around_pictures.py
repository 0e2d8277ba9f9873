"""The pictures of plans around obstacles are drawn, and what they show is as told."""

import matplotlib as mpl
import numpy as np
import pytest
from scipy.spatial.distance import cdist

from skillfold.errors import InputError
from skillfold.experiments import around_shown, around_tray, three_link
from skillfold.experiments.rows import Settings
from skillfold.manifold.skill import SkillManifold
from skillfold.viewing import arm_pictures, around_pictures, tray_pictures


def quick(demos):
    return SkillManifold.fit(demos, kernels=20, dim=demos.shape[1] // 2 if demos.shape[1] > 3 else 2)


@pytest.fixture(scope="module")
def scenes():
    return around_shown.scenes(Settings(0, fit=quick), pairs=2)


@pytest.fixture(scope="module")
def task():
    return around_tray.prepare(Settings(0, fit=quick), 1, 1)


def test_paths_go_through_and_around(scenes):
    for scene in scenes:
        assert len(scene.through) == len(scene.around) == 2
        for through, around in zip(scene.through, scene.around, strict=True):
            np.testing.assert_array_equal(through[[0, -1]], around[[0, -1]])
            assert cdist(through, scene.points).min() < 0.5 * scene.reach < cdist(around, scene.points).min()


def test_the_surface_is_that_of_the_optimal_poses(scenes):
    surface = arm_pictures.half_disc()
    for axis in (0, 1):  # one sheet
        assert np.linalg.norm(np.diff(surface, axis=axis), axis=-1).max() < three_link.JUMP
    flat = surface.reshape(-1, 3)
    assert three_link.kkt_residual(flat, three_link.forward(flat), three_link.WEIGHTED_REACHING).max() < 1e-9
    for path in scenes[0].around:
        assert cdist(path, flat).min(axis=1).max() < 0.2


def test_the_picture_of_patches_is_written(scenes, tmp_path):
    before = dict(mpl.rcParams)
    written = around_pictures.draw(scenes, tmp_path / "around.png")
    assert written.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert written.stat().st_size > 20_000
    assert dict(mpl.rcParams) == before


def test_each_scene_has_its_surface_and_its_plane(scenes):
    made = around_pictures.around(*scenes)
    assert len(made.axes) == 4
    for plane, scene in zip(made.axes[1::2], scenes, strict=True):
        ways = [line.get_xydata() for line in plane.lines]
        for path in scene.around:
            places = three_link.forward(path)
            assert any(way.shape == places.shape and np.allclose(way, places) for way in ways)


def test_the_picture_of_boxes_is_written(task, tmp_path):
    skill = task.skills[400]
    answers = around_tray.ask(skill, [*task.past, *task.hard])
    written = tray_pictures.draw(skill, answers, tmp_path / "tray.png")
    assert written.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    made = tray_pictures.past_boxes(skill, answers)
    assert len(made.axes) == 3 * len(answers)


def test_outlines_are_those_of_boxes(task):
    box = next(iter(task.past[0].scene))
    above, side = (tray_pictures.outline(box, seen) for seen in ([0, 1], [1, 2]))
    x, y = np.roll(above, 1, axis=0).T
    area = 0.5 * abs(np.sum(x * above[:, 1] - y * above[:, 0]))
    assert area == pytest.approx(box.size[0] * box.size[1])
    np.testing.assert_allclose(above.mean(axis=0), box.pose[:2], atol=1e-12)
    assert np.ptp(side[:, 1]) == pytest.approx(box.size[2])


def test_a_missing_folder_is_told(scenes, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        around_pictures.draw(scenes, tmp_path / "nowhere" / "around.png")
