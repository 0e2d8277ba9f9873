"""The pictures of the three-link arm's reaching are drawn, and what they show is as told."""

import matplotlib as mpl
import numpy as np
import pytest

from skillfold.errors import InputError
from skillfold.experiments import reaching, reaching_shown, three_link
from skillfold.experiments.rows import Settings
from skillfold.manifold.skill import SkillManifold
from skillfold.viewing import reaching_pictures
from skillfold.viewing.style import style


@pytest.fixture(scope="module")
def shown():
    return reaching_shown.run(Settings(0, fit=lambda demos: SkillManifold.fit(demos, kernels=10, dim=2)), 6, 20)


def test_the_pictures_are_written(shown, tmp_path):
    before = dict(mpl.rcParams)
    written = reaching_pictures.draw(shown, tmp_path)
    assert len(set(written)) == 3
    assert all(file.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n" and file.stat().st_size > 20_000 for file in written)
    assert dict(mpl.rcParams) == before


def test_paths_inside_keep_to_the_grid_and_those_beyond_leave_it(shown):
    def ends(paths):
        return three_link.forward(np.array([states[[0, -1]] for states in paths.states])).reshape(-1, 2)

    assert reaching_shown.beyond(ends(shown.inside)).max() <= 1e-9
    assert reaching_shown.beyond(ends(shown.outside)).min() >= -1e-9


def test_distance_from_the_grid_is_that_from_its_edge():
    edge = reaching.GRID_CENTRE + reaching.GRID_HALF
    places = np.array([edge + np.array(away) for away in ([0.03, 0.04], [0.02, -0.2], [-0.05, -0.2])])
    places = np.vstack([places, reaching.GRID_CENTRE])
    np.testing.assert_allclose(reaching_shown.beyond(places), [0.05, 0.02, -0.05, -reaching.GRID_HALF.min()])


def test_errors_are_those_of_the_protocol(shown):
    for paths, redundancy in ((shown.inside, three_link.REACHING), (shown.geodesics, three_link.WEIGHTED_REACHING)):
        above = [three_link.forward(states[1:-1])[:, 1] >= 0 for states in paths.states]
        states = np.concatenate([states[1:-1] for states in paths.states])
        if redundancy is three_link.REACHING:
            assert reaching.path_rmse(states, redundancy) == pytest.approx(paths.rmse)
        else:
            kept = np.concatenate(paths.errors)[np.concatenate(above)]
            assert reaching.path_rmse(states, redundancy) == pytest.approx(np.sqrt(np.mean(kept**2)))


def test_the_graph_is_that_of_the_samples(shown):
    for learnt in (shown.grid, shown.half_disc):
        states, edges = learnt.graph
        assert np.abs(states - learnt.samples).max() < 0.05
        assert edges.max() == len(states) - 1
        assert learnt.centres.shape == (10, 3)


def test_random_states_are_brought_nearer_to_the_optimum(shown):
    row = reaching_shown.rows(shown)[0]
    assert row.measured is not None and row.measured < 0.05
    assert "of 20 states" in row.note
    before = reaching_shown.state_errors(shown.random, three_link.WEIGHTED_REACHING)
    assert np.nanmedian(before) > 5 * row.measured


def test_every_panel_shows_something(shown):
    with style():
        for made, count in (
            (reaching_pictures.reaching(shown), 8),
            (reaching_pictures.weighted(shown), 6),
            (reaching_pictures.projections(shown), 2),
        ):
            assert len(made.axes) == count
            assert all(ax.has_data() for ax in made.axes)


def test_a_missing_folder_is_told(shown, tmp_path):
    with pytest.raises(InputError, match="cannot be written"):
        reaching_pictures.draw(shown, tmp_path / "nowhere")
