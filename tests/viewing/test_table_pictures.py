"""Table I and one pushed motion of each arm are drawn from few trials as well, and show what they stand for."""

import matplotlib as mpl
import numpy as np
import pytest

from skillfold.errors import InputError
from skillfold.experiments import table_one
from skillfold.experiments.rows import Settings
from skillfold.viewing import pushed_pictures
from skillfold.viewing.style import style
from skillfold.viewing.table_pictures import draw
from skillfold.viewing.table_pictures import table_one as drawn


@pytest.fixture(scope="module")
def halves():
    return table_one.table(Settings(0), trials=4)


def test_the_picture_is_written(halves, tmp_path):
    before = dict(mpl.rcParams)
    written = draw(halves, tmp_path / "table.png")
    assert written.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert written.stat().st_size > 20_000
    assert dict(mpl.rcParams) == before


def test_the_table_in_it_is_that_of_the_trials(halves):
    with style():
        texts = [text.get_text() for ax in drawn(*halves).axes for text in ax.texts]
    for method in ("naive", "manifold"):
        cost = halves[1].runs[2].costs(halves[1].task.costs["J2"])[method]
        assert f"{cost.mean():.4f} ± {cost.std():.4f}" in texts
    assert "0.0785 ± 0.0160" in texts


def test_pushed_motions_are_drawn(halves, tmp_path):
    before = dict(mpl.rcParams)
    written = pushed_pictures.draw(halves, tmp_path / "pushed.png")
    assert written.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert dict(mpl.rcParams) == before
    with style():
        axes = pushed_pictures.pushed(*halves).axes
    assert len(axes) == 11
    assert all(ax.has_data() for ax in axes)


def test_a_pushed_motion_falls_into_its_parts(halves):
    for half in halves:
        run = half.runs[-1]
        for trial in range(len(half.task.ends)):
            told = pushed_pictures.parts(half, run, trial)
            np.testing.assert_allclose(np.subtract(*told.push[::-1]), run.pushes[trial], atol=1e-12)
            np.testing.assert_allclose(told.before[-1], told.push[0], atol=1e-12)
            np.testing.assert_array_equal(told.back[0], told.push[1])
            np.testing.assert_array_equal(told.back[-1], told.on[0])
            np.testing.assert_array_equal(told.on[-1], run.motions["manifold"][trial, -1])
            assert half.task.skill.distance(told.on).max() < half.task.skill.distance(told.push[1])


def test_a_missing_folder_is_told(halves, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        draw(halves, tmp_path / "nowhere" / "table.png")


def test_real_skills_bring_motions_back(halves):
    """On the skills that `bench` measures, with the library's own defaults."""
    for half in halves:
        assert half.task.skill.dim == {"3-link": 2, "KUKA": 3}[half.task.name]
        excess = half.runs[1].excess
        assert np.nanmean(excess["manifold"]) < np.nanmean(excess["naive"]) / 3
