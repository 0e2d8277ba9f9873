"""Pictures are drawn without pyplot, in their own look, and tell when they cannot be written."""

import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest

from skillfold.errors import InputError
from skillfold.experiments import demo
from skillfold.experiments.loaders import RecordedTask
from skillfold.viewing import plots
from skillfold.viewing.demo_pictures import draw
from skillfold.viewing.style import figure, style


@pytest.fixture(scope="module")
def story():
    phase = np.linspace(0.0, 1.0, 40)
    recordings = tuple(np.column_stack([30 * phase, 10 * np.sin(3 * phase) + shift]) for shift in (0.0, 0.5, 1.0))
    rng = np.random.default_rng(0)
    wave = demo.handwriting(RecordedTask("wave", recordings), rng)
    return demo.Story((wave, demo.three_link_arm(rng, samples=60, paths=5)), ())


def test_all_pictures_are_written(story, tmp_path):
    before = dict(mpl.rcParams)
    written = draw(story, tmp_path)
    assert {path.name for path in written} == {"handwriting.png", "three_link.png", "demo.png"}
    for path in written:
        assert path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
        assert path.stat().st_size > 20_000
    assert dict(mpl.rcParams) == before


def test_no_window_is_needed():
    code = "import sys, skillfold.viewing.demo_pictures; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_without_handwriting_there_is_the_arm(story, tmp_path):
    written = draw(demo.Story(story.chapters[1:], ()), tmp_path)
    assert [path.name for path in written] == ["three_link.png"]


def test_pictures_into_a_missing_folder(story, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        draw(demo.Story(story.chapters[1:], ()), tmp_path / "nowhere")


def test_parts_draw_in_the_plane_and_in_space():
    rng = np.random.default_rng(0)
    with style():
        made = figure(4.0, 2.0)
        for place, dims, projection in ((121, 2, None), (122, 3, "3d")):
            ax = made.add_subplot(place, projection=projection)
            states = rng.standard_normal((6, dims))
            plots.demonstrations(ax, [states])
            plots.samples(ax, states)
            plots.paths(ax, [states, states + 1])
            plots.tangents(ax, states, rng.standard_normal((6, dims, dims - 1)), 0.2)
            plots.projections(ax, states, states + 0.1)
        made.canvas.draw()
