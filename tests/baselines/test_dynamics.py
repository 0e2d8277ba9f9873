"""What the manifold is compared with: learnt dynamics and primitives, on motions they must be able to do."""

import numpy as np
import pytest

from skillfold.baselines.dmp import Primitive, from_rest
from skillfold.baselines.gmr_dynamics import REACHED, Dynamics

SHARE = np.linspace(0.0, 1.0, 80)[:, None]
GOAL = np.array([1.0, 0.0])


def arcs():
    return [np.hstack([SHARE, height * np.sin(np.pi * SHARE)]) for height in (0.28, 0.3, 0.32)]


def test_dynamics_come_near_the_goal_they_were_shown():
    pytest.importorskip("gmr", reason="gmr is not installed")
    fitted = Dynamics.fit(arcs(), seed=0, components=5)
    path = fitted.path(np.zeros(2), GOAL)
    assert fitted.components == 5
    assert np.linalg.norm(path - GOAL, axis=1).min() < 3 * REACHED
    assert abs(path[:, 1].max() - 0.3) < 0.05


def test_the_number_of_gaussians_is_chosen_where_it_is_not_given():
    pytest.importorskip("gmr", reason="gmr is not installed")
    line = [
        np.hstack([SHARE, 0.0 * SHARE]) + 1e-3 * np.random.default_rng(i).standard_normal((80, 2)) for i in (0, 1)
    ]
    assert 3 <= Dynamics.fit(line, seed=0).components <= 10


def test_motions_that_lead_nowhere_end():
    pytest.importorskip("gmr", reason="gmr is not installed")
    path = Dynamics.fit(arcs(), seed=0, components=5).path(np.zeros(2), np.array([5.0, 5.0]))
    assert len(path) <= 3 * 79 + 1


def test_motions_asked_together_are_those_asked_alone():
    pytest.importorskip("gmr", reason="gmr is not installed")
    fitted = Dynamics.fit(arcs(), seed=0, components=5)
    starts = np.array([[0.0, 0.0], [0.05, 0.02], [0.5, 0.4]])
    goals = np.array([GOAL, [5.0, 5.0], GOAL])
    for path, start, goal in zip(fitted.paths(starts, goals), starts, goals, strict=True):
        assert np.allclose(path, fitted.path(start, goal))


def test_a_motion_from_rest_keeps_its_way():
    line = np.hstack([SHARE, 2.0 * SHARE])
    moved = from_rest(line)
    steps = np.linalg.norm(np.diff(moved, axis=0), axis=1)
    assert np.allclose(moved[:, 1], 2.0 * moved[:, 0]) and np.allclose(moved[[0, -1]], line[[0, -1]])
    assert max(steps[0], steps[-1]) < 0.01 * steps.max()


def test_primitives_go_from_end_to_end():
    pytest.importorskip("movement_primitives", reason="movement_primitives is not installed: extra peers")
    path = Primitive.fit(arcs()).path(np.array([0.1, 0.1]), np.array([1.2, -0.1]))
    assert np.allclose(path[0], [0.1, 0.1])
    assert np.linalg.norm(path[-1] - [1.2, -0.1]) < 0.03
    assert 0.2 < path[:, 1].max() < 0.45


def test_primitives_of_poses_stay_on_the_sphere():
    pytest.importorskip("movement_primitives", reason="movement_primitives is not installed: extra peers")
    half = 0.5 * SHARE
    turns = np.hstack([np.cos(half), np.sin(half), 0 * half, 0 * half])
    poses = np.hstack([SHARE, np.sin(np.pi * SHARE), 0 * SHARE, turns])
    path = Primitive.fit_poses([poses, poses]).path(poses[0], poses[-1])
    assert np.allclose(np.linalg.norm(path[:, 3:], axis=1), 1.0)
    assert np.linalg.norm(path[-1] - poses[-1]) < 0.05
