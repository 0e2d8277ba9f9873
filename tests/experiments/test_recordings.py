"""The leave-one-out protocol on paths whose answers are known, and the loaders."""

from dataclasses import astuple
from types import SimpleNamespace

import numpy as np
import pytest

from skillfold.baselines.gmr_regression import gmr_path, gmr_rollout
from skillfold.errors import InputError
from skillfold.experiments import drawing, loaders, recordings
from skillfold.experiments import leave_one_out as protocol
from skillfold.experiments.rows import Settings


def arc(height, points=80):
    phase = np.linspace(0, 1, points)
    return np.column_stack([phase, height * np.sin(np.pi * phase)])


def test_resampling_keeps_ends_and_equal_steps():
    path = np.array([[0.0, 0], [1, 0], [1, 0], [1, 3]])
    out = protocol.resample(path, 9)
    np.testing.assert_allclose(np.linalg.norm(np.diff(out, axis=0), axis=1), 0.5)
    np.testing.assert_array_equal(out[[0, -1]], path[[0, -1]])


def test_corrected_mean_has_the_ends_and_is_exact_for_shifted_copies():
    shift = np.array([2.0, -1.0])
    mean = protocol.corrected_mean([arc(0.5), arc(0.5)], shift, shift + np.array([1, 0]), 60)
    np.testing.assert_allclose(mean, protocol.resample(arc(0.5), 60) + shift, atol=1e-12)


def test_located_stretch_has_the_asked_ends():
    path = arc(1.0, 201)
    np.testing.assert_array_equal(protocol.located(path, path[40], path[140]), path[40:141])


def test_distances_of_parallel_lines():
    line = np.column_stack([np.linspace(0, 1, 30), np.zeros(30)])
    shifted = line + np.array([0, 0.2])
    assert protocol.distance_between(shifted, line) == pytest.approx(0.2)
    assert protocol.nearest_distance(shifted, line) == pytest.approx(0.2)
    assert protocol.distance_between(line[::-1], line) > 0.4
    assert protocol.nearest_distance(line[::-1], line) == pytest.approx(0.0)


def test_random_stretch_is_a_part_of_the_asked_length():
    rng = np.random.default_rng(0)
    path = arc(1.0, 100)
    for _ in range(100):
        part = protocol.random_stretch(path, rng)
        assert 30 <= len(part) <= 70
        first = int(np.flatnonzero(path[:, 0] == part[0, 0])[0])
        np.testing.assert_array_equal(part, path[first : first + len(part)])


def test_unit_paths_stay_on_the_sphere():
    path = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0]])
    for out in (protocol.resample(path, 7, unit=True), protocol.straight_line(*path, 7, unit=True)):
        np.testing.assert_allclose(np.linalg.norm(out, axis=1), 1.0)


def test_same_sign_undoes_flips():
    rng = np.random.default_rng(0)
    smooth = np.cumsum(0.02 * rng.standard_normal((3, 60, 4)), axis=1) + np.array([1, 0, 0, 0])
    flipped = smooth * np.where(rng.uniform(size=(3, 60, 1)) < 0.3, -1, 1)
    out = loaders.same_sign(flipped)
    np.testing.assert_allclose(out * np.sign(out[0, 0, 0]), smooth)


def test_score_of_a_skill_that_answers_with_the_baseline_is_one():
    task = loaders.RecordedTask("arcs", tuple(arc(h) for h in (0.2, 0.3, 0.45, 0.5)))
    scores = recordings.score_task(task, Settings(0, fit=_Mean), np.random.default_rng(0))
    assert [score.whole for score in scores] == pytest.approx([1.0] * 4)
    assert [score.via for score in scores] == pytest.approx([1.0] * 4)
    assert all(score.line > 1 for score in scores)


def test_drawing_figures_of_a_straight_skill_are_those_of_the_line():
    task = loaders.RecordedTask("arcs", tuple(arc(h) for h in (0.2, 0.3, 0.4, 0.5)))
    percents = drawing.score_shape(task, Settings(0, fit=_Line), dynamics=True)
    assert [p.geodesic for p in percents] == pytest.approx([p.line for p in percents])
    _, *gmr, line, dynamics = np.mean([astuple(p) for p in percents], axis=0)
    assert max(*gmr, dynamics) < line


def test_gmr_follows_the_mean_and_its_dynamics_reach_the_goal():
    paths = [protocol.resample(arc(h), 80) for h in (0.3, 0.4, 0.5)]
    assert protocol.distance_between(gmr_path(paths, 0), arc(0.4)) < 0.02
    rolled = gmr_rollout(paths, paths[1][0], paths[1][-1], 0)
    assert np.linalg.norm(rolled[-1] - paths[1][-1]) < 0.05


def test_lasa_has_26_and_4_shapes():
    single, multi = loaders.lasa(False, 20), loaders.lasa(True, 20)
    assert (len(single), len(multi)) == (26, 4)
    assert {len(task.recordings) for task in single + multi} == {7}
    assert all(r.shape == (20, 2) for task in single + multi for r in task.recordings)


def test_robot_tasks_in_metres_and_unit_quaternions(tmp_path):
    poses = np.tile([100.0, 50, 25, 1, 0, 0, 0], (2, 10, 1)) + np.linspace(0, 1, 10)[:, None]
    poses[..., 3:] /= np.linalg.norm(poses[..., 3:], axis=-1, keepdims=True)
    (tmp_path / "robotasks").mkdir()
    for name in loaders.ROBOT_TASKS:
        np.save(tmp_path / "robotasks" / f"{name}.npy", poses)
    positions, orientations = (loaders.robot_tasks(tmp_path, kind, 15)[0] for kind in (False, True))
    np.testing.assert_allclose(positions.recordings[0][0], [1.0, 0.5, 0.25])
    np.testing.assert_allclose(np.linalg.norm(orientations.recordings[0], axis=1), 1.0)


def test_missing_robot_tasks_are_named(tmp_path):
    with pytest.raises(InputError, match="robotasks"):
        loaders.robot_tasks(tmp_path, orientations=False)


class _Mean:
    def __init__(self, demos, **options):
        self.demos = demos

    def plan(self, start, goal, via=None):
        return _plan(protocol.corrected_mean(self.demos, start, goal))


class _Line(_Mean):
    def plan(self, start, goal, route=None):
        return _plan(protocol.straight_line(start, goal))


def _plan(states):
    return SimpleNamespace(path=SimpleNamespace(states=states))
