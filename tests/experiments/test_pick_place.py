"""Pick and place: the sets, what is measured on motions, and the table, on very few."""

import importlib.util
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from skillfold.errors import InputError
from skillfold.experiments import pick_place, pick_place_poses, pick_place_rows
from skillfold.experiments.pick_place_sets import (
    DEMOS,
    POINTS,
    MotionSet,
    cube,
    made,
    own,
    recorded,
    shape_distances,
)
from skillfold.experiments.rows import Settings
from skillfold.viewing import pick_place_pictures, tunnel_pictures
from skillfold.viewing.envelope_pictures import view
from skillfold.viewing.motion_views import Seen


@pytest.fixture(scope="module")
def motions():
    return made(np.random.default_rng(0))


@pytest.fixture(scope="module")
def compared(motions):
    skill = Settings(0).learn(list(motions.recordings), dim=1, kernels=5)
    return pick_place.Compared(motions, skill, {"manifold": pick_place.ask(motions, pick_place.planned(skill))})


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
    def half(starts, goals):
        return [np.linspace(a, 0.5 * (a + b), 5) for a, b in zip(starts, goals, strict=True)]

    assert not any(cell.reached.any() for cell in pick_place.ask(motions, half))


def test_every_set_has_a_name_of_its_own():
    for quick in (True, False):
        names = [each.name for each in pick_place.sets(Settings(0, quick=quick))]
        assert len(set(names)) == len(names) >= (1 if quick else 2)


def test_what_is_left_out_is_not_shown(motions):
    """Who repeats what was shown is off by what recordings differ; who is shown the truth, by nothing."""

    def repeat(shown):
        return lambda starts, goals: [shown[0]] * len(starts)

    def cheat(shown):
        return lambda starts, goals: [r for a in starts for r in motions.recordings if np.allclose(r[0], a)]

    assert (pick_place.leave_out(motions, repeat) > 0.01).all()
    assert np.allclose(pick_place.leave_out(motions, cheat), 0.0)


def test_rows_stand_beside_the_papers(compared):
    rows = pick_place_rows.rows([replace(compared, missing=("gmr is not installed",))])
    assert [row.met for row in rows[:4]] == [True] * 4
    assert rows[0].paper == "27; GMM/GMR 12"
    assert rows[4].target is None and "gmr is not installed" in rows[4].note
    assert [row.paper for row in pick_place_rows.rows([compared, compared])[7:11]] == [""] * 4


def test_the_others_least_is_the_target(compared):
    cells = compared.cells["manifold"]
    worse = [replace(cell, shapes=2.0 * cell.shapes) for cell in cells]
    better = [replace(cell, shapes=0.5 * cell.shapes) for cell in cells]
    both = replace(compared, cells={"manifold": cells, "A": worse, "B": better})
    row = pick_place_rows.rows([both])[4]
    assert row.target == pytest.approx(0.5 * row.measured) and row.met is False


def test_pictures_are_written(compared, tmp_path):
    assert pick_place_pictures.draw_data(compared, tmp_path / "a.png").stat().st_size > 20_000
    for what in ("start", "goal"):
        assert pick_place_pictures.draw_moved(compared, what, tmp_path / "b.png").stat().st_size > 20_000
    flat = replace(compared, motions=MotionSet("flat", tuple(r[:, :2] for r in compared.motions.recordings)))
    assert pick_place_pictures.draw_data(flat, tmp_path / "c.png").stat().st_size > 10_000


def test_shells_are_seen_where_they_are():
    """Of a ball's distance: a disc as wide as the shell, nothing around it."""
    low, high = -np.ones(3), np.ones(3)
    grid = np.linalg.norm(np.stack(np.meshgrid(*[np.linspace(-1, 1, 21)] * 3, indexing="ij"), axis=-1), axis=-1)
    seen = Seen(view(20.0, 30.0), -np.ones(2), np.ones(2))
    image = tunnel_pictures.gathered(grid, np.array([0.3, 0.5, 0.7]), low, high, seen)
    x, y = np.meshgrid(*(np.linspace(-1, 1, n) for n in image.shape[1::-1]))
    away = np.hypot(x, y)
    held = image[..., 3]
    assert (held[away > 0.76] == 0.0).all() and (held[away < 0.66] > 0.05).all()
    assert held[away < 0.25].min() > held[(away > 0.55) & (away < 0.65)].max()


def test_training_is_timed_against_learnt_dynamics(motions, monkeypatch):
    monkeypatch.setattr(pick_place_rows, "TRAININGS", (1, 1))
    rows = pick_place_rows.training_rows(motions, Settings(0))
    assert [row.unit for row in rows] == ["s", "s"] and all(row.measured > 0 for row in rows)
    if importlib.util.find_spec("gmr") is None:
        assert all(row.target is None and "pip install" in row.note for row in rows)
    else:
        assert all(row.target > 0 for row in rows)


def test_own_recordings_take_the_made_sets_place(motions, tmp_path):
    assert pick_place.sets(Settings(0, tmp_path, quick=True))[0].name == "pick and place (made)"
    folder = tmp_path / "pick_place"
    folder.mkdir()
    for i, pair in enumerate(zip(motions.recordings, motions.orientations, strict=True)):
        poses = np.hstack(pair) + np.eye(7)[0] * 5.0
        np.savetxt(folder / f"{i}.csv", poses, delimiter=",", header="x,y,z,qw,qx,qy,qz", comments="")
    mine = pick_place.sets(Settings(0, tmp_path, quick=True))[0]
    assert mine.name == "own recordings" and np.allclose(mine.goal, 0.0)
    assert shape_distances(mine.recordings[1], motions.recordings)[1] < 0.01
    assert np.allclose(np.linalg.norm(mine.orientations, axis=2), 1.0)
    for i in range(3):
        (folder / f"{i}.csv").unlink()
    with pytest.raises(InputError, match="expected 3 recordings or more"):
        own(tmp_path)


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


def test_orientations_belong_to_their_places(tmp_path):
    """A tool that turns in the first half of its way only is read as it turned."""
    (tmp_path / "robotasks").mkdir()
    share = np.linspace(0.0, 1.0, 300) ** 2
    angle = np.minimum(2.0 * share, 1.0)
    turns = np.column_stack([np.cos(angle / 2), np.sin(angle / 2), 0 * share, 0 * share])
    places = 100.0 * np.column_stack([share, 0 * share, 0 * share])
    np.save(tmp_path / "robotasks" / "bottle2shelf.npy", np.tile(np.hstack([places, turns]), (DEMOS, 1, 1)))
    motions = recorded(tmp_path)[0]
    assert np.allclose(motions.recordings[0][:, 0], np.linspace(-1.0, 0.0, POINTS))
    wanted = np.minimum(np.linspace(0.0, 2.0, POINTS), 1.0)
    assert np.allclose(2.0 * np.arccos(motions.orientations[0][:, 0]), wanted, atol=0.02)


def test_an_even_turn_has_no_shape(motions):
    """Whoever begins and ends otherwise, and turns evenly between, is as like a recording as its even turn."""

    def pose(turns):
        return np.hstack([motions.recordings[0], turns.as_quat(scalar_first=True)])

    way = np.linalg.norm(np.diff(motions.recordings[0], axis=0), axis=1)
    share = np.concatenate([[0.0], np.cumsum(way)])[:, None] / way.sum()
    even = Rotation.from_rotvec(share * [1.0, 0.0, 0.0])
    assert pick_place_poses.turn_distance(pose(even), [pose(even)]) < 1e-9
    bent = Rotation.from_rotvec(0.3 * np.sin(np.pi * share) * [0.0, 0.0, 1.0]) * even
    size = 0.3 * np.sqrt((np.sin(np.pi * np.linspace(0.0, 1.0, POINTS)) ** 2).mean())
    assert pick_place_poses.turn_distance(pose(bent), [pose(even)]) == pytest.approx(size, rel=0.02)
    assert pick_place_poses.turn_distance(pose(even * Rotation.from_rotvec([0.0, 0.4, 0.0])), [pose(even)]) < 1e-9


def test_poses_are_reached_with_their_orientations(motions):
    rows = pick_place_poses.pose_rows([motions, replace(motions, orientations=())], Settings(0))
    assert len(rows) == 6 and rows[0].met and rows[-1].target is None
    shape, turn, unseen, unseen_turn, off = (row.measured for row in rows[1:])
    assert shape < 0.3 and turn < 0.1 and unseen < 0.3 and unseen_turn < 0.1 and off < 0.4
    quarter = np.array([[np.cos(np.pi / 4), np.sin(np.pi / 4), 0.0, 0.0]])
    assert np.allclose(pick_place_poses.angles(quarter, np.array([[-1.0, 0.0, 0.0, 0.0]])), np.pi / 2)
