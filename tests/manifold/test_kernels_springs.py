"""Algorithm 2's springs against their twin, and what they are for."""

import numpy as np
import pytest

from manifold import twins_around as twins
from manifold.kernels import springs
from manifold.random_terrains import TERRAINS, random_terrain


@pytest.fixture(params=TERRAINS, ids=str)
def terrain(request):
    return random_terrain(71, *request.param)


def relaxed(terrain, path, tolerance, limit):
    path = path.copy()
    told = springs.relax_springs(
        terrain.model.table,
        terrain.land.chart,
        terrain.barrier,
        path,
        terrain.margin,
        terrain.compiled.capacity,
        tolerance,
        limit,
    )
    return path, *told


@pytest.mark.parametrize(("n", "limit"), [(2, 3), (3, 1), (9, 1), (9, 2), (14, 8)])
def test_relax_springs(terrain, n, limit):
    for _ in range(3):
        path = terrain.blocked_path(n) if n > 3 else terrain.path(n)
        found, iterations, moved = relaxed(terrain, path, 1e-4, limit)
        wanted, turns, last = twins.relax_springs(terrain.land, path, terrain.margin, 1e-4, limit)
        assert iterations == turns
        assert moved == pytest.approx(last, abs=1e-8)
        np.testing.assert_allclose(found, wanted, atol=1e-8)
        np.testing.assert_array_equal(found[[0, -1]], path[[0, -1]])


def test_a_path_at_rest_is_on_the_surface_and_clearer_than_before(terrain):
    clearer = []
    for _ in range(4):
        path = terrain.blocked_path(20)
        found, _, _ = relaxed(terrain, path, 1e-5, 400)
        before, after = (
            terrain.land.balls.clearance(twins.to_state(terrain.land.chart, p)).min() for p in (path, found)
        )
        clearer.append(after > before)
        assert np.abs(twins.frames(terrain.land, found[1:-1])[0]).max() < 1e-2
    assert sum(clearer) >= 3


def test_a_state_at_an_obstacle_point_has_no_way_off_it_and_does_no_harm(terrain):
    """There the clearance has no gradient."""
    path = terrain.blocked_path(9)
    path[4] = terrain.ball_centres()[0]
    found, _, moved = relaxed(terrain, path, 1e-4, 3)
    assert np.isfinite(moved)
    np.testing.assert_allclose(found, twins.relax_springs(terrain.land, path, terrain.margin, 1e-4, 3)[0], atol=1e-7)


def test_pull_of():
    rng = np.random.default_rng(0)
    for rest in (0.1, 1.0, 5.0):
        neighbour, here, move = rng.normal(size=(3, 4))
        found = move.copy()
        springs.pull_of(neighbour, here, rest, found)
        np.testing.assert_allclose(found, move + twins.pull_of(neighbour, here, rest), atol=1e-13)
    move = np.zeros(4)
    springs.pull_of(here, here, 1.0, move)
    np.testing.assert_array_equal(move, 0.0)  # of two in one place there is no way off


@pytest.mark.parametrize("n", [2, 3, 12])
def test_bend(n):
    path = np.random.default_rng(n).normal(size=(n, 3))
    bends, mean = np.zeros((n, 3)), np.full(3, 7.0)
    springs.bend(path, bends, mean)
    wanted = twins.bend(path)
    np.testing.assert_allclose(bends, wanted[0], atol=1e-13)
    np.testing.assert_allclose(mean, wanted[1], atol=1e-13)
