"""The picture of Table I is drawn from few trials as well, and shows the figures it stands for."""

import matplotlib as mpl
import numpy as np
import pytest

from skillfold.errors import InputError
from skillfold.experiments import table_one
from skillfold.experiments.rows import Settings
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
        assert f"{cost.mean():.4f}±{cost.std():.4f}" in texts
    assert "0.0785±0.0160" in texts


def test_a_missing_folder_is_told(halves, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        draw(halves, tmp_path / "nowhere" / "table.png")


def test_real_skills_bring_motions_back(halves):
    """On the skills that `bench` measures, with the library's own defaults."""
    for half in halves:
        assert half.task.skill.dim == {"3-link": 2, "KUKA": 3}[half.task.name]
        excess = half.runs[1].excess
        assert np.nanmean(excess["manifold"]) < np.nanmean(excess["naive"]) / 3
