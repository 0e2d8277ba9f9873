"""Paths that bend around balls: kernels against their twins, and what they are for on paths with a known answer."""

import numpy as np
import pytest

from manifold import twins_around as twins
from manifold.kernels import detours, scratch_memory
from manifold.random_terrains import TERRAINS, random_terrain
from skillfold import PointObstacles
from skillfold.manifold.kernels.walking import Chart
from skillfold.planning.barrier import barrier_of

CAP = 0.3


@pytest.fixture(params=TERRAINS, ids=str)
def terrain(request):
    return random_terrain(61, *request.param)


def room(terrain, n):
    return detours.make_bending(n, terrain.dim, terrain.width, terrain.compiled.capacity)


def test_make_bending():
    made = detours.make_bending(5, 2, 3, 7)
    shapes = [array.shape for array in made]
    assert shapes[:6] == [(5, 3), (5, 2, 3), (5, 2, 2), (5, 2), (5, 2, 3), (5, 3)]
    assert shapes[6:] == [(5,), (5,), (7,), (7, 3), (3,), (3,)]
    assert not any(array.any() for array in made)


def framed(terrain, path):
    """The memory of a path with its frames, by kernels."""
    kept = terrain.land.surface.points.shape[0]
    b, scratch = room(terrain, len(path)), scratch_memory.make_scratch(terrain.model.table, len(path))
    detours.free_rows(b.tangents, kept)
    inner = np.empty((len(path), kept))
    detours.frame_path(path, inner, b.normals, b.tangents, scratch)
    return b


@pytest.mark.parametrize("n", [2, 9])
def test_frame_path(terrain, n):
    path = terrain.path(n)
    b = framed(terrain, path)
    normals, tangents = twins.frames(terrain.land, path)
    np.testing.assert_allclose(b.normals, normals, atol=1e-10)
    np.testing.assert_allclose(b.tangents, tangents, atol=1e-10)
    for basis in b.tangents:
        np.testing.assert_allclose(basis @ basis.T, np.eye(terrain.dim), atol=1e-12)


@pytest.mark.parametrize(("d", "kept", "D"), [(2, 3, 3), (3, 3, 4), (3, 2, 4)])
def test_free_rows(d, kept, D):
    tangents = np.zeros((4, d, D))
    detours.free_rows(tangents, kept)
    wanted = np.zeros((d, D))
    wanted[d - (D - kept) :, kept:] = np.eye(D - kept)
    np.testing.assert_array_equal(tangents, np.tile(wanted, (4, 1, 1)))


@pytest.mark.parametrize("cap", [CAP, 0.01])
def test_bend_once_again_and_again(terrain, cap):
    """With springs of the caller's besides, and a chain that is not the path."""
    chart, balls, margin = terrain.land.chart, terrain.land.balls, terrain.margin
    for n in (3, 8):
        path, chain = terrain.path(n), terrain.model.rng.normal(size=(n, terrain.width))
        b, memory, steepest = framed(terrain, path), twins.Memory(n, terrain.width), 0.0
        for _ in range(4):
            roots = terrain.model.rng.normal(size=b.stiffness.shape)
            b.stiffness[:], b.force[:] = roots @ roots.swapaxes(1, 2), terrain.model.rng.normal(size=b.force.shape)
            given = b.normals, b.tangents, b.stiffness.copy(), b.force.copy()
            wanted = twins.bend_once(chart, balls, path, chain, *given, margin, cap, memory)
            moved, steepest = detours.bend_once(chart, terrain.barrier, path, chain, margin, steepest, cap, b)
            np.testing.assert_allclose(path, wanted, atol=1e-8)
            assert moved == pytest.approx(np.linalg.norm(memory.steps, axis=1).max())
            assert steepest == pytest.approx(memory.steepest)
            assert moved <= cap * (1 + 1e-9)
            assert not b.stiffness.any()
            assert not b.force.any()


def bent(terrain, path, limit, spacing):
    capacity, land = terrain.compiled.capacity, terrain.land
    table, barrier, margin = terrain.model.table, terrain.barrier, terrain.margin
    return detours.bend_clear(table, land.chart, barrier, path, margin, capacity, CAP, 1e-3, limit, spacing)


@pytest.mark.parametrize(("n", "limit"), [(5, 1), (9, 1)])
def test_bend_clear_within_the_edge(terrain, n, limit):
    """Paths that lead out are pulled back; those that do not are left alone."""
    held, spacing = 0, 0.05
    for _ in range(6):
        path = terrain.blocked_path(n)
        path[1:-1, :2] += 0.6  # out of the anchors' reach, which is about one
        hold = twins.Hold(terrain.land, path, spacing)
        wanted, iterations, moved = twins.bend_clear(terrain.land, path, terrain.margin, CAP, 1e-3, limit, hold)
        found = path.copy()
        told = bent(terrain, found, limit, spacing)
        if told == (0, 0.0):
            np.testing.assert_array_equal(found, path)
            continue
        held += 1
        assert told == (iterations, pytest.approx(moved, abs=1e-3))
        np.testing.assert_allclose(found, wanted, atol=1e-3)
    assert held > 0


@pytest.mark.parametrize(("n", "limit"), [(3, 1), (9, 1), (9, 2), (14, 6)])
def test_bend_clear(terrain, n, limit):
    for _ in range(3):
        path = terrain.blocked_path(n)
        wanted, iterations, moved = twins.bend_clear(terrain.land, path, terrain.margin, CAP, 1e-3, limit)
        found = path.copy()
        told = bent(terrain, found, limit, 0.0)
        assert told == (iterations, pytest.approx(moved, abs=1e-7))
        np.testing.assert_allclose(found, wanted, atol=1e-7)
        np.testing.assert_array_equal(found[[0, -1]], path[[0, -1]])


@pytest.mark.parametrize(("n", "limit"), [(3, 1), (9, 2), (20, 8)])
def test_bend_aside(terrain, n, limit):
    chart, balls, margin = terrain.land.chart, terrain.land.balls, terrain.margin
    for reach in (0.5, 3.0):
        path = terrain.blocked_path(n)
        wanted, iterations, moved = twins.bend_aside(chart, balls, path, margin, reach, 0.1, 1e-4, limit)
        found = path.copy()
        told = detours.bend_aside(
            chart, terrain.barrier, found, margin, terrain.compiled.capacity, reach, 0.1, 1e-4, limit
        )
        assert told == (iterations, pytest.approx(moved, abs=1e-7))
        np.testing.assert_allclose(found, wanted, atol=1e-7)
        np.testing.assert_array_equal(found[[0, -1]], path[[0, -1]])


@pytest.mark.parametrize("off", [0.0, 0.02, 0.3, 3.0])
def test_settle_path(terrain, off):
    for n in (2, 3, 9):
        path = terrain.path(n, off)
        found = path.copy()
        good = detours.settle_path(terrain.model.table, terrain.land.support, found)
        if n == 2:
            assert good
            np.testing.assert_array_equal(found, path)
            continue
        wanted, believed = twins.settle_path(terrain.land, path)
        assert good == believed
        if good:
            np.testing.assert_allclose(found, wanted, atol=1e-8)
            np.testing.assert_array_equal(found[[0, -1]], path[[0, -1]])


def test_settle_path_believes_only_its_support(terrain):
    land, path = terrain.land, np.repeat(terrain.on_surface(1), 5, axis=0)
    assert detours.settle_path(terrain.model.table, land.support, path.copy())
    for support in (land.support._replace(farthest=0.0), land.support._replace(doubt=0.0)):
        assert not detours.settle_path(terrain.model.table, support, path.copy())


@pytest.mark.parametrize("margin", [0.0, 0.6])
def test_first_blocked(terrain, margin):
    margin, found = margin * terrain.margin, []
    for path in (*(terrain.path(8) for _ in range(8)), *(terrain.blocked_path(8) for _ in range(8))):
        found.append(detours.first_blocked(terrain.land.chart, terrain.barrier, path, margin))
        assert found[-1] == twins.first_blocked(terrain.land, path, margin)
    assert -1 in found
    assert max(found) > 0


# Where the answer is known: the identity chart of a plane, and one ball


FLAT = Chart(np.zeros(2), 1.0, np.eye(2), np.full(2, -np.inf), np.full(2, np.inf))


def aside(path, centre, reach=2.0, margin=0.2, chart=FLAT):
    obstacles = PointObstacles([centre], 2 * margin)
    compiled, path = obstacles.compiled(), path.copy()
    iterations, moved = detours.bend_aside(
        chart, barrier_of(compiled), path, margin, compiled.capacity, reach, 0.1, 1e-5, 500
    )
    return path, obstacles, iterations, moved


def straight(n=81):
    return np.column_stack([np.linspace(-2, 2, n), np.zeros(n)])


def test_a_path_is_pushed_aside_near_the_ball_and_elsewhere_keeps_its_way():
    path, obstacles, iterations, moved = aside(straight(), [0.0, 0.05])
    assert iterations < 500
    assert moved < 1e-5
    assert obstacles.clearance(path).min() > 0.9 * obstacles.margin
    assert path[40, 1] < -0.25  # on the side that it was on
    far = np.abs(straight()[:, 0]) > 1.0
    np.testing.assert_allclose(path[far], straight()[far], atol=2e-3)


def test_the_farther_a_push_is_passed_on_the_wider_is_the_bow():
    bows = [aside(straight(), [0.0, 0.05], reach)[0][:, 1] for reach in (1.0, 4.0, 12.0)]
    widths = [(bow < -0.02).sum() for bow in bows]
    assert widths[0] < widths[1] < widths[2]


def test_a_path_out_of_the_ball_s_reach_stays_to_the_bit():
    path, *_ = aside(straight(), [0.0, 0.7])
    np.testing.assert_array_equal(path, straight())


def test_a_path_that_is_pushed_over_a_limit_gives_way():
    limited = FLAT._replace(lower=np.array([-3.0, -0.2]))
    path, *_ = aside(straight(), [0.0, 0.05], chart=limited)
    free, *_ = aside(straight(), [0.0, 0.05])
    assert free[:, 1].min() + 0.03 < path[:, 1].min() < -0.2


def test_a_path_pulled_straight_does_not_run_through_what_was_out_of_sight():
    """It starts with nothing near any of its states; what comes into sight on its way stops it."""
    x = np.linspace(-2, 2, 25)
    path = np.column_stack([x, 2.0 - x**2 / 2.0])
    obstacles, b, steepest, least = PointObstacles([[0.0, 0.05]], 0.4), detours.make_bending(25, 2, 2, 1), 0.0, []
    b.tangents[:] = np.eye(2)
    barrier = barrier_of(obstacles.compiled())
    assert obstacles.clearance(path).min() > twins.SIGHT * obstacles.margin
    for _ in range(80):
        _, steepest = detours.bend_once(FLAT, barrier, path, path, obstacles.margin, steepest, 0.1, b)
        least.append(obstacles.clearance(path).min())
    assert min(least) > 0.0
    assert least[-1] > 0.8 * obstacles.margin
    assert path[12, 1] == pytest.approx(0.45, abs=0.1)
