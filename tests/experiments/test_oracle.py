"""Known paths on a truth that is easy to see through: a half cylinder over the plane."""

import numpy as np
import pytest

from skillfold.experiments.oracle import Oracle, length

STEP = 0.1


def on_cylinder(states):
    """The nearest state of x² + z² = 1, above; y is free."""
    over = states[:, [0, 2]] / np.linalg.norm(states[:, [0, 2]], axis=1, keepdims=True)
    return np.column_stack([over[:, 0], states[:, 1], over[:, 1]])


@pytest.fixture(scope="module")
def oracle():
    turns, along = np.arange(-15, 16), np.arange(-20, 21)
    lattice = np.stack(np.meshgrid(turns, along, indexing="ij"), axis=-1).reshape(-1, 2).astype(float)
    poses = np.column_stack([np.sin(STEP * lattice[:, 0]), STEP * lattice[:, 1], np.cos(STEP * lattice[:, 0])])
    poses[lattice[:, 1] == 20] = np.nan
    return Oracle.build(lattice, poses, 2**0.5, 0.5, on_cylinder, 0.02)


def ends():
    turns = np.array([-1.2, 1.2])
    return np.column_stack([np.sin(turns), [0.03, -0.04], np.cos(turns)])


def test_places_without_a_pose_are_left_out(oracle):
    assert len(oracle.poses) == 31 * 40
    assert np.isfinite(oracle.poses).all()


def test_the_shortest_path_lies_on_the_truth_and_is_not_far_from_shortest(oracle):
    start, goal = ends()
    path = oracle.path(start, goal)
    np.testing.assert_allclose(path[[0, -1]], [start, goal], atol=1e-12)
    np.testing.assert_allclose(path[:, 0] ** 2 + path[:, 2] ** 2, 1.0, atol=1e-12)
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() < 0.03
    assert np.hypot(2.4, 0.07) <= length(path) + 1e-3 <= 1.1 * np.hypot(2.4, 0.07)


def test_a_path_goes_around_what_is_not_clear(oracle):
    start, goal = ends()
    clear = ~((np.abs(oracle.poses[:, 0]) < 0.2) & (oracle.poses[:, 1] < 1.0))
    path = oracle.path(start, goal, clear)
    assert path[:, 1].max() > 0.9
    assert length(path) > 1.2 * length(oracle.path(start, goal))


def test_no_way_is_none(oracle):
    start, goal = ends()
    assert oracle.path(start, goal, np.abs(oracle.poses[:, 0]) > 0.2) is None
    assert oracle.path(start, goal, np.zeros(len(oracle.poses), bool)) is None


def test_the_straight_way_is_brought_onto_the_truth(oracle):
    start, goal = ends()
    path = oracle.direct(start, goal)
    np.testing.assert_allclose(on_cylinder(path), path, atol=1e-12)
    np.testing.assert_allclose(path[[0, -1]], [start, goal], atol=1e-12)
