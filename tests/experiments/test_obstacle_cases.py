"""Planning cases: blocked, solvable, and the same for a seed; judged by distances of this file's own."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from skillfold.experiments import patch_cases, three_link, tray, tray_cases
from skillfold.experiments.reaching import REACH
from skillfold.experiments.three_link import WEIGHTED_REACHING

COUNT = 4
ELL = 0.24


@pytest.fixture(scope="module", params=[(1.0, "disc"), (0.7, "disc"), (0.7, "wall")], ids=str)
def patches(request):
    beta, kind = request.param
    make = {"disc": patch_cases.disc_cases, "wall": patch_cases.wall_cases}[kind]
    return make(COUNT, beta * ELL, np.random.default_rng(0))


@pytest.fixture(scope="module", params=[tray_cases.past_boxes, tray_cases.hard_cases], ids=["past", "hard"])
def boxes(request):
    return request.param(COUNT, np.random.default_rng(0))


def optimality(states):
    return three_link.kkt_residual(states, three_link.forward(states), WEIGHTED_REACHING)


def test_patches_lie_on_the_manifold_and_leave_the_ends_clear(patches):
    for case in patches:
        on = optimality(case.points) < 1e-8
        assert on.mean() > 0.5  # walls go on straight where the arm was never shown
        assert optimality(np.stack([case.start, case.goal])).max() < 1e-8
        assert cdist([case.start, case.goal], case.points).min() > case.reach


def test_patches_are_in_the_way(patches):
    for case in patches:
        line = case.start + np.linspace(0, 1, 200)[:, None] * (case.goal - case.start)
        states = three_link.optimal(np.maximum(three_link.forward(line), [-1, 1e-6]), WEIGHTED_REACHING)
        assert cdist(states, case.points).min() < 0.55 * case.reach


def test_there_is_a_way_past_patches(patches):
    for case in patches:
        np.testing.assert_allclose(case.oracle[[0, -1]], [case.start, case.goal], atol=1e-6)
        assert cdist(case.oracle, case.points).min() >= case.reach
        assert case.clearance(case.oracle).min() >= 0
        assert optimality(case.oracle).max() < 1e-8
        assert np.linalg.norm(np.diff(case.oracle, axis=0), axis=1).max() < case.reach / 1.5
        assert case.length >= np.linalg.norm(case.goal - case.start)


def test_points_lie_closer_than_what_they_reach(patches):
    for case in patches:
        apart = np.sort(cdist(case.points, case.points), axis=1)[:, 1]
        assert apart.max() < 0.6 * case.reach


def test_walls_close_all_but_their_gap():
    """With the gap closed there is no way."""
    for case in patch_cases.wall_cases(4, 0.2, np.random.default_rng(1)):
        wall = case.points[22:]  # what is carried on beyond its ends comes first
        gap = int(np.argmax(np.linalg.norm(np.diff(wall, axis=0), axis=1)))
        plug = wall[gap] + np.linspace(0, 1, 40)[:, None] * (wall[gap + 1] - wall[gap])
        closed = np.vstack([case.points, three_link.optimal(three_link.forward(plug), WEIGHTED_REACHING)])
        clear = cdist(patch_cases.oracle().poses, closed).min(axis=1) > case.reach
        assert patch_cases.oracle().path(case.start, case.goal, clear, 2 * case.reach) is None


def test_oracle_of_the_arm_covers_the_upper_half_disc():
    places = three_link.forward(patch_cases.oracle().poses)
    assert places[:, 1].min() > 0
    assert 0.93 < np.linalg.norm(places, axis=1).max() <= REACH + 1e-3
    assert len(places) > 3000


def test_straight_way_runs_into_a_box(boxes):
    for case in boxes:
        line = case.start + np.linspace(0, 1, 200)[:, None] * (case.goal - case.start)
        states = tray.levelled(line, tray.LEVEL_WEIGHT)
        assert tray.arm().obstacles(case.scene).clearance(states).min() < -0.01


def test_there_is_a_way_past_boxes(boxes):
    for case in boxes:
        obstacles = tray.arm().obstacles(case.scene)
        np.testing.assert_allclose(case.oracle[[0, -1]], [case.start, case.goal], atol=1e-6)
        assert obstacles.clearance(case.oracle[[0, -1]]).min() >= 0.04
        assert obstacles.clearance(case.oracle).min() >= 0.02
        assert obstacles.edge_clear(case.oracle[:-1], case.oracle[1:], 0.01).all()
        assert tray.inside_limits(case.oracle).all()
        places = tray.positions(case.oracle)
        assert tray.kkt_residual(case.oracle, places, tray.LEVEL_WEIGHT).max() < 1e-9
        assert tray.tilt(case.oracle).max() < 0.01
        assert case.length >= np.linalg.norm(case.goal - case.start)


def test_hard_cases_have_a_wall_of_two_heights():
    for case in tray_cases.hard_cases(2, np.random.default_rng(2)):
        heights = sorted(shape.size[2] for shape in case.scene.shapes[:2])
        assert heights[0] <= 0.60
        assert heights[1] >= 0.85
        assert len(case.scene) >= 4


@pytest.mark.parametrize("kind", ["disc", "wall", "past", "hard"])
def test_the_same_seed_gives_the_same_cases(kind):
    def make():
        rng = np.random.default_rng(3)
        if kind in ("disc", "wall"):
            return getattr(patch_cases, f"{kind}_cases")(2, 0.2, rng)
        return {"past": tray_cases.past_boxes, "hard": tray_cases.hard_cases}[kind](2, rng)

    for first, second in zip(make(), make(), strict=True):
        np.testing.assert_array_equal(first.oracle, second.oracle)
        for name in ("start", "goal"):
            np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
