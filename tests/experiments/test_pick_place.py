"""Pick and place: the sets, what is measured on motions, and the table, on very few."""

import numpy as np
import pytest

from skillfold.experiments import pick_place, pick_place_poses
from skillfold.experiments.pick_place_sets import DEMOS, POINTS, cube, made, recorded, shape_distances
from skillfold.experiments.rows import Settings
from skillfold.viewing import pick_place_pictures


@pytest.fixture(scope="module")
def motions():
    return made(np.random.default_rng(0))


@pytest.fixture(scope="module")
def compared(motions):
    skill = Settings(0).learn(list(motions.recordings), dim=1, kernels=5)
    return pick_place.Compared(motions, skill, {"manifold": pick_place.ask(motions, pick_place._planned(skill))})


def test_the_set_is_shaped_like_the_papers(motions):
    assert len(motions.recordings) == len(motions.orientations) == DEMOS
    for places, turns in zip(motions.recordings, motions.orientations, strict=True):
        assert places.shape == (POINTS, 3)
        assert np.allclose(places[-1], 0.0)
        assert np.allclose(np.linalg.norm(turns, axis=1), 1.0)
        assert (np.einsum("ni,ni->n", turns[1:], turns[:-1]) > 0.9).all()
    starts = np.array([places[0] for places in motions.recordings])
    assert np.abs(starts.mean(0) - [1.8, 1.8, -1.1]).max() < 0.1


def test_the_same_seed_makes_the_same_set(motions):
    again = made(np.random.default_rng(0))
    assert all(np.array_equal(a, b) for a, b in zip(motions.recordings, again.recordings, strict=True))


def test_a_cube_has_27_places():
    places = cube(np.ones(3), 0.5)
    assert places.shape == (27, 3)
    assert len({tuple(place) for place in places.tolist()}) == 27
    assert np.allclose(places.min(0), 0.5) and np.allclose(places.max(0), 1.5)


def test_shape_does_not_know_the_ends(motions):
    recording = motions.recordings[0]
    share = np.linspace(0.0, 1.0, POINTS)[:, None]
    sheared = recording + 0.01 * (1.0 - share)
    assert shape_distances(recording, motions.recordings[:1]) == (0.0, 0.0)
    assert shape_distances(sheared, motions.recordings[:1])[1] < 0.01
    straight = recording[0] + share * (recording[-1] - recording[0])
    assert np.allclose(shape_distances(straight, motions.recordings[:1]), 1.0)
    to_all, to_nearest = shape_distances(recording, motions.recordings)
    assert to_nearest == 0.0 < to_all


def test_the_manifold_reaches_all_and_keeps_the_shape(compared):
    for cell in compared.cells["manifold"]:
        assert cell.reached.all() and len(cell.reached) == 27
        assert cell.shapes.max() < 0.25


def test_motions_that_stop_short_do_not_count(motions):
    def half(start, goal):
        return np.linspace(start, 0.5 * (start + goal), 5)

    assert not any(cell.reached.any() for cell in pick_place.ask(motions, half))


def test_rows_stand_beside_the_papers_and_the_picture_is_written(compared, tmp_path):
    rows = pick_place.rows([compared])
    assert [row.met for row in rows[:4]] == [True] * 4
    assert rows[0].paper == "27; GMM/GMR 12"
    assert rows[-1].target is None and "nothing to compare with" in rows[-1].note
    assert pick_place_pictures.draw(compared, tmp_path / "pick.png").stat().st_size > 20_000


def test_training_is_timed_against_learnt_dynamics():
    pytest.importorskip("gmr", reason="gmr is not installed")
    rows = pick_place.training_rows(Settings(0), 1)
    assert [row.unit for row in rows] == ["s", "s"]
    assert all(row.measured > 0 and row.target > 0 for row in rows)


def test_recordings_of_ones_own_are_taken_where_they_are(tmp_path):
    assert all(motions.name != "bottle2shelf" for motions in recorded(tmp_path))
    folder = tmp_path / "robotasks"
    folder.mkdir()
    rng = np.random.default_rng(1)
    way = np.cumsum(rng.random((9, 200, 3)), axis=1)
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (9, 200, 1))
    for name in ("bottle2shelf", "openbox", "platestandingtolying", "pouring"):
        np.save(folder / f"{name}.npy", np.concatenate([way, turns], axis=2))
    first = recorded(tmp_path)[0]
    assert first.name == "bottle2shelf" and len(first.recordings) == DEMOS
    assert np.allclose(first.goal, 0.0)


def test_poses_are_reached_with_their_orientations(motions):
    reached, shape, turned = pick_place_poses.pose_rows(motions, Settings(0), np.random.default_rng(0))
    assert reached.met and shape.measured < 0.3 and turned.measured < 0.4
    quarter = np.array([[np.cos(np.pi / 4), np.sin(np.pi / 4), 0.0, 0.0]])
    assert np.allclose(pick_place_poses.angles(quarter, np.array([[-1.0, 0.0, 0.0, 0.0]])), np.pi / 2)
