"""The arm's optimal poses against SciPy's optimisers, and the protocol on skills that are always right."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import approx_fprime, minimize

from skillfold.experiments import reaching
from skillfold.experiments.rows import Settings
from skillfold.experiments.three_link import (
    REACHING,
    WEIGHTED_REACHING,
    forward,
    jacobian,
    kkt_residual,
    optimal,
)

PLACES = {REACHING: reaching.inside_grid, WEIGHTED_REACHING: reaching.upper_half_disc}


def test_forward_of_known_poses():
    poses = np.array([[0, 0, 0], [np.pi / 2, 0, 0], [np.pi / 2, -np.pi / 2, 0], [0, np.pi, 0]])
    expected = np.array([[1, 0], [0, 1], [2 / 3, 1 / 3], [-1 / 3, 0]])
    np.testing.assert_allclose(forward(poses), expected, atol=1e-15)


def test_jacobian_is_the_derivative():
    pose = np.array([0.3, -0.7, 1.1])
    numeric = [approx_fprime(pose, lambda q, i=i: forward(q)[i]) for i in range(2)]
    np.testing.assert_allclose(jacobian(pose), numeric, atol=1e-6)


@pytest.mark.parametrize("redundancy", [REACHING, WEIGHTED_REACHING], ids=["V-A", "V-B"])
def test_optimum_reaches_its_position_and_is_stationary(redundancy):
    positions = PLACES[redundancy](3000, np.random.default_rng(0))
    poses = optimal(positions, redundancy)
    assert kkt_residual(poses, positions, redundancy).max() < 1e-10
    assert np.median(kkt_residual(poses, positions, redundancy)) < 1e-13


@pytest.mark.parametrize("redundancy", [REACHING, WEIGHTED_REACHING], ids=["V-A", "V-B"])
def test_optimum_is_the_best_of_many_local_optimisations(redundancy):
    rng = np.random.default_rng(1)
    positions = PLACES[redundancy](8, rng)
    for position, pose in zip(positions, optimal(positions, redundancy), strict=True):
        best = min(
            (found for found in (_slsqp(position, redundancy, rng) for _ in range(25)) if found.success),
            key=lambda found: found.fun,
        )
        assert redundancy.cost(pose) <= best.fun + 1e-3
        np.testing.assert_allclose(pose, best.x, atol=1e-3)


@pytest.mark.parametrize("redundancy", [REACHING, WEIGHTED_REACHING], ids=["V-A", "V-B"])
def test_optimum_is_continuous_where_it_is_used(redundancy):
    x, y = (np.linspace(0, 0.9, 80), np.linspace(-0.675, 0.675, 120))
    if redundancy is WEIGHTED_REACHING:
        x, y = np.linspace(-0.95, 0.95, 160), np.linspace(1e-6, 0.95, 80)
    positions = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    poses = optimal(positions.reshape(-1, 2), redundancy).reshape(*positions.shape[:2], 3)
    poses[np.linalg.norm(positions, axis=-1) > reaching.REACH] = np.nan
    for axis in (0, 1):
        assert np.nanmax(np.abs(np.diff(poses, axis=axis))) < 0.4


def test_out_of_reach_is_not_a_number():
    assert np.isnan(optimal(np.array([[1.2, 0.0], [0.5, 0.1]]), REACHING)).all(axis=1).tolist() == [
        True,
        False,
    ]


def test_full_reach_is_close_to_the_stretched_arm():
    poses = optimal(0.9999 * np.array([[np.cos(0.7), np.sin(0.7)]]), WEIGHTED_REACHING)
    np.testing.assert_allclose(poses, [[0.7, 0, 0]], atol=0.05)


def test_grid_has_the_papers_size_and_spacing():
    points = reaching.grid()
    assert points.shape == (651, 2)
    np.testing.assert_allclose(points.mean(axis=0), reaching.GRID_CENTRE, atol=1e-12)
    np.testing.assert_allclose(np.diff(np.unique(points[:, 0].round(9))), 0.03, atol=1e-9)


def test_outside_grid_is_outside_and_in_reach():
    points = reaching.outside_grid(500, np.random.default_rng(0))
    away = np.abs(points - reaching.GRID_CENTRE) / reaching.GRID_HALF
    assert (away.max(axis=1) > 1).all()
    assert (away <= 1.5).all()
    assert (np.linalg.norm(points, axis=1) <= reaching.REACH).all()


def test_protocol_finds_no_error_in_optimal_paths_and_the_right_one_in_shifted_paths(monkeypatch):
    monkeypatch.setattr(reaching, "in_parallel", lambda function, cases, *_: [function(*case) for case in cases])
    settings = Settings(0, fit=lambda samples: _Skill(shift=0.0))
    rows = {row.name: row for row in reaching.measure(settings, trials=2, pairs=3)}
    assert all(row.measured is not None and row.measured < 1e-9 for row in rows.values() if row.unit == "rad")
    assert all(row.met for row in rows.values() if row.unit != "ms")
    # A joint error along the arm's self-motion shows in full: the tip stays, the pose is no longer optimal.
    pose = optimal(np.array([[0.5, 0.1]]), REACHING)
    null = np.linalg.svd(jacobian(pose[0]))[2][-1]
    assert reaching.path_rmse(pose + 1e-3 * null, REACHING) == pytest.approx(1e-3 / np.sqrt(3), rel=1e-2)


def _slsqp(position, redundancy, rng):
    reach = {"type": "eq", "fun": lambda q: forward(q) - position, "jac": jacobian}
    start = rng.uniform(-np.pi, np.pi, 3)
    return minimize(redundancy.cost, start, jac=redundancy.gradient, constraints=[reach], method="SLSQP")


class _Skill:
    """Plans through optimal poses of positions on a line; knows which cost by the ends."""

    dim = 2

    def __init__(self, shift):
        self.shift = shift

    def plan(self, start, goal):
        line = np.linspace(forward(start), forward(goal), 20)
        redundancy = min((REACHING, WEIGHTED_REACHING), key=lambda r: kkt_residual(start, line[0], r))
        states = optimal(line, redundancy) + self.shift
        return SimpleNamespace(path=SimpleNamespace(states=states), converged=True)


def test_below_the_axis_no_path_is_judged_in_other_processes_either():
    """There the mirror image of what was learnt is optimal."""
    above = optimal(np.array([[0.5, 0.2], [0.4, 0.3]]), WEIGHTED_REACHING)
    path = np.vstack([above, optimal(np.array([[0.4, 1e-3]]), WEIGHTED_REACHING) - [1e-2, 0.0, 0.0]])
    assert forward(path)[2, 1] < 0.0
    for redundancy in (WEIGHTED_REACHING, pickle.loads(pickle.dumps(WEIGHTED_REACHING))):
        assert reaching.path_rmse(path, redundancy) < 1e-9
