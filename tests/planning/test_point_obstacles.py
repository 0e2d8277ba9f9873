"""`PointObstacles`: clearance and gradient by definition, in batches, in threads, from files, and bad input."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning import twins
from skillfold import PointObstacles
from skillfold.errors import InputError

LAWS = settings(max_examples=30, deadline=None)
SEEDS = st.integers(0, 2**32 - 1)


def cloud(seed, count=20, D=3):
    return np.random.default_rng(seed).normal(size=(count, D))


@given(seed=SEEDS, D=st.integers(1, 6), shape=st.sampled_from([(), (1,), (5,), (2, 3), (0,), (2, 0)]))
@LAWS
def test_clearance_is_the_distance_to_the_nearest_ball(seed, D, shape):
    points, rng = cloud(seed, D=D), np.random.default_rng(seed + 1)
    obstacles, q = PointObstacles(points, 0.4), rng.normal(size=(*shape, D))
    found = obstacles.clearance(q)
    assert np.shape(found) == shape
    np.testing.assert_allclose(found, twins.clearance(points, 0.2, q), atol=1e-13)
    assert obstacles.clearance_gradient(q).shape == q.shape


@given(seed=SEEDS, D=st.integers(1, 6))
@LAWS
def test_gradients_are_derivatives(seed, D):
    """Where one point is nearest on either side: between two the clearance has a kink."""
    points, h = cloud(seed, D=D), 1e-6
    obstacles = PointObstacles(points, 0.4)
    for q in np.random.default_rng(seed + 1).normal(size=(5, D)):
        nearest = np.sort(np.linalg.norm(points - q, axis=1))
        if nearest[0] < 1e-3 or nearest[1] - nearest[0] < 1e-4:
            continue
        steps = h * np.eye(D)
        slope = (obstacles.clearance(q + steps) - obstacles.clearance(q - steps)) / (2 * h)
        gradient = obstacles.clearance_gradient(q)
        np.testing.assert_allclose(gradient, slope, atol=1e-5)
        assert np.linalg.norm(gradient) == pytest.approx(1.0)


def test_at_a_point_itself_there_is_no_way_off():
    obstacles = PointObstacles([[1.0, 2.0]], 0.4)
    assert obstacles.clearance([1.0, 2.0]) == -0.2
    np.testing.assert_array_equal(obstacles.clearance_gradient([1.0, 2.0]), 0.0)


def test_half_the_reach_is_forbidden_and_half_is_kept():
    obstacles = PointObstacles([[0.0, 0.0]], 0.4)
    assert obstacles.margin == 0.2
    assert obstacles.clearance([0.2, 0.0]) == 0.0
    assert obstacles.clearance([0.4, 0.0]) == pytest.approx(obstacles.margin)
    assert 0.0 < obstacles.resolution <= obstacles.margin / 5
    lower, upper = obstacles.bounds
    np.testing.assert_array_equal(lower, [-np.inf, -np.inf])
    np.testing.assert_array_equal(upper, [np.inf, np.inf])


def test_the_nearest_is_named():
    points = cloud(0)
    obstacles = PointObstacles(points, 0.4)
    for i in (0, 7, 19):
        assert obstacles.nearest(points[i] + 1e-3) == f"obstacle point {i}"


def test_it_is_told_in_a_word():
    assert repr(PointObstacles(cloud(0), 0.4)) == "PointObstacles(20 points in 3 dimensions, reach 0.4)"


def test_points_are_its_own():
    points = np.zeros((1, 2))
    obstacles = PointObstacles(points, 0.4)
    points[0, 0] = 5.0
    assert obstacles.clearance([0.0, 0.0]) == -0.2
    with pytest.raises(ValueError, match="read-only"):
        obstacles.points[0, 0] = 5.0


@pytest.mark.parametrize("points", [[[0, 1], [2, 3]], np.array([[0, 1], [2, 3]], np.float32), np.eye(4)[::2, 1:3]])
def test_numbers_of_every_kind_are_numbers(points):
    obstacles = PointObstacles(points, np.float32(1))
    q = np.array([[5, 5], [1, 0]])
    np.testing.assert_allclose(obstacles.clearance(q), twins.clearance(np.asarray(points, float), 0.5, q))
    assert obstacles.clearance(q.tolist()) == pytest.approx(obstacles.clearance(q))
    assert np.isfinite(obstacles.clearance(np.asfortranarray(q.T).T)).all()


def test_it_can_be_pickled_and_used_again():
    obstacles, q = PointObstacles(cloud(0), 0.4), cloud(1)
    before = obstacles.clearance(q)  # with memory of this thread, which stays here
    again = pickle.loads(pickle.dumps(obstacles))
    assert (again.reach, again.margin) == (obstacles.reach, obstacles.margin)
    np.testing.assert_array_equal(again.points, obstacles.points)
    np.testing.assert_array_equal(again.clearance(q), before)
    assert not again.points.flags.writeable


def test_threads_do_not_disturb_one_another():
    obstacles = PointObstacles(cloud(0, 300), 0.4)
    batches = [cloud(i, 2000) for i in range(8)]
    alone = [obstacles.clearance(batch) for batch in batches]
    with ThreadPoolExecutor(4) as pool:
        for found, wanted in zip(pool.map(obstacles.clearance, 4 * batches), 4 * alone, strict=True):
            np.testing.assert_array_equal(found, wanted)


def test_each_thread_has_arguments_of_its_own():
    obstacles = PointObstacles(cloud(0), 0.4)
    mine = obstacles.compiled()
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(obstacles.compiled).result()
    assert not np.array_equal(mine.arguments, other.arguments)
    np.testing.assert_array_equal(mine.arguments, obstacles.compiled().arguments)
    assert mine.capacity == 20


def test_what_compiled_loops_are_given_answers_alike():
    points = cloud(0)
    obstacles = PointObstacles(points, 0.4)
    made, gradient = obstacles.compiled(), np.empty(3)
    near, gradients = np.empty(made.capacity), np.empty((made.capacity, 3))
    for start, end in zip(cloud(1), cloud(2), strict=True):
        assert made.clearance(start, gradient, made.arguments) == obstacles.clearance(start)
        np.testing.assert_array_equal(gradient, obstacles.clearance_gradient(start))
        count = made.within(start, 0.5, near, gradients, made.arguments)
        np.testing.assert_allclose(near[:count], twins.within(points, 0.2, start, 0.5)[0], atol=1e-13)
        share = made.edge(start, end, 0.1, made.arguments)
        assert share == pytest.approx(twins.share(points, 0.2, start, end, 0.1), abs=1e-9)


NO_POINTS = {
    "none": None,
    "text": "abc",
    "a number": 3.0,
    "one row": [1.0, 2.0],
    "empty": [],
    "no rows": np.empty((0, 3)),
    "no columns": np.empty((3, 0)),
    "too deep": np.zeros((2, 3, 4)),
    "ragged": [[1.0, 2.0], [1.0]],
    "NaN": [[0.0, np.nan]],
    "infinity": [[0.0, np.inf]],
    "complex": np.array([[1j, 0.0]]),
    "flags": np.array([[True, False]]),
    "objects": [[{}, {}]],
    "masked": np.ma.masked_array([[0.0, 1.0]], [[False, True]]),
    "far beyond all numbers of use": [[1e200, 0.0]],
}


@pytest.mark.parametrize("points", NO_POINTS.values(), ids=NO_POINTS)
def test_points_that_are_none(points):
    with pytest.raises(InputError, match=r"Obstacle points.*\(m, D\)"):
        PointObstacles(points, 0.1)


@pytest.mark.parametrize(
    "reach", [0, 0.0, -1.0, np.nan, np.inf, "far", None, True, 10**400, [0.1], 1j, 1e200, np.array([1.0])]
)
def test_reaches_that_are_none(reach):
    with pytest.raises(InputError, match="reach"):
        PointObstacles(np.zeros((2, 2)), reach)


NO_STATES = {
    **{name: NO_POINTS[name] for name in ("none", "text", "a number", "empty", "ragged", "NaN", "infinity")},
    **{name: NO_POINTS[name] for name in ("complex", "masked", "objects", "far beyond all numbers of use")},
    "another dimension": np.zeros(3),
    "a batch of another dimension": np.zeros((4, 1)),
}


@pytest.mark.parametrize("ask", ["clearance", "clearance_gradient", "nearest"])
@pytest.mark.parametrize("q", NO_STATES.values(), ids=NO_STATES)
def test_states_that_are_none(ask, q):
    with pytest.raises(InputError, match="expected"):
        getattr(PointObstacles(np.zeros((2, 2)), 0.1), ask)(q)


@pytest.mark.parametrize("q", [np.zeros((3, 2)), np.empty((0, 2))])
def test_the_nearest_is_asked_for_one_state(q):
    with pytest.raises(InputError, match=r"nearest.*\(2,\)"):
        PointObstacles(np.zeros((2, 2)), 0.1).nearest(q)
