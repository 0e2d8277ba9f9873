"""Samples and plans: on the manifold, exact at their ends, true where the truth is known."""

from itertools import pairwise

import numpy as np
import pytest

from manifold import clouds
from manifold.conftest import arm_poses, curves, fit
from manifold.laws import KINDS, SURFACES, law, samples_of
from skillfold import StateSpace
from skillfold.errors import InputError
from skillfold.experiments.three_link import REACHING, forward, optimal
from skillfold.manifold.projection import OnManifold


@pytest.mark.parametrize("count", [400, 2050, 3000, 6000])
def test_inside_is_calibrated_on_held_out_samples(count):
    """One is the 95 % quantile: of new samples of the same kind about one in twenty lies beyond.

    Whether all samples are anchors, or most, or so many.
    """
    rng = np.random.default_rng(5)
    skill = fit(clouds.draw_sphere(count, rng), 2)
    share = (skill.inside(clouds.draw_sphere(2000, rng)) > 1).mean()
    assert 0.02 < share < 0.09


@pytest.mark.parametrize("count", [400, 1000, 2050])
def test_inside_is_calibrated_where_noise_is_wider_than_samples_lie_apart(count):
    """Anchors are without noise, new samples are not: the nearest sample tells less than the nearest anchor."""
    rng = np.random.default_rng(5)

    def noisy_circle(n):
        turn = rng.uniform(0.0, 2.0 * np.pi, n)
        return np.column_stack([np.cos(turn), np.sin(turn)]) + 0.03 * rng.standard_normal((n, 2))

    skill = fit(noisy_circle(count), 1)
    share = (skill.inside(noisy_circle(2000)) > 1).mean()
    assert 0.02 < share < 0.1


def test_the_tolerance_holds_where_anchors_are_fewer_than_samples():
    """Around the nearest anchor a surface is farther off than around the nearest of many samples."""
    rng = np.random.default_rng(5)

    def helix(n):
        turn = rng.uniform(0.0, 5.0, n)
        return np.column_stack([np.cos(turn), np.sin(turn), 0.2 * turn])

    skill = fit(helix(6000), 1)
    assert 0.9 < skill.contains(helix(2000)).mean() < 0.99


@pytest.mark.parametrize("kind", KINDS)
def test_inside_grows_with_the_way_out(skills, kind):
    skill = skills[kind]
    at = samples_of(skill)[0]
    out = (at - skill.model.centre) / np.linalg.norm(at - skill.model.centre)
    ways = at + np.array([0.0, 2.0, 10.0, 100.0])[:, None] * skill.model.scale * out
    inside = skill.inside(ways)
    assert inside[0] < 1e-9
    assert (np.diff(inside) > 0).all()
    assert inside[3] > 10


def test_along_free_directions_one_is_inside_until_their_range_is_left(cylinder):
    at = cylinder.project(samples_of(cylinder)[0])
    extent = cylinder.model.free_extent[0]
    direction = cylinder.model.free[:, 0]
    assert cylinder.inside(at + 0.99 * extent * direction) < 0.1
    assert cylinder.inside(at + 3.0 * extent * direction) > 1.0
    np.testing.assert_allclose(cylinder.distance(at + np.outer([0, 1, 50], direction)), 0.0, atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_samples_lie_on_the_manifold_and_within_the_demonstrations(skills, kind):
    skill = skills[kind]
    x = skill.sample(100, seed=1)
    assert x.shape == (100, skill.n_dims)
    assert skill.distance(x).max() < 1e-7 * skill.model.scale
    assert skill.inside(x).max() <= 1.0 + 1e-9
    # Beyond the edge of what is trusted, two may come to the foot of the same anchor.
    assert len(np.unique(x, axis=0)) > 95
    np.testing.assert_array_equal(skill.sample(100, seed=1), x)
    assert not np.array_equal(skill.sample(100, seed=2), x)
    assert skill.sample(0).shape == (0, skill.n_dims)


def test_samples_of_a_sphere_are_spread_over_it(sphere):
    x = sphere.sample(2000, seed=0)
    np.testing.assert_allclose(x.mean(0), 0.0, atol=0.08)
    np.testing.assert_allclose(x.T @ x / 2000, np.eye(3) / 3, atol=0.06)


def pairs(skill, seed, count=3):
    x = skill.sample(2 * count, seed=seed % 2**31)
    return zip(x[:count], x[count:], strict=True)


@law
def test_geodesics_end_exactly_and_stay_on_the_manifold(skills, kind, seed):
    skill = skills[kind]
    for start, goal in pairs(skill, seed):
        plan = skill.plan(start, goal, 30, route="geodesic")
        states = plan.path.states
        np.testing.assert_array_equal(states[[0, -1]], [start, goal])
        assert len(states) == 30
        assert plan.length == pytest.approx(np.linalg.norm(np.diff(states, axis=0), axis=1).sum(), rel=1e-12)
        assert plan.length >= np.linalg.norm(goal - start) * (1 - 1e-12)
        if kind in SURFACES:  # small ones are told as displacements: equal up to their square
            assert plan.residual == pytest.approx(
                skill.distance(states).max(), rel=1e-2, abs=1e-7 * skill.model.scale
            )
        assert (plan.route, plan.start_moved, plan.goal_moved) == ("geodesic", 0.0, 0.0)
        if plan.converged and plan.success:
            steps = np.linalg.norm(np.diff(states, axis=0), axis=1)
            if kind in SURFACES:
                assert plan.residual < 1e-5 * skill.model.scale
                assert steps.max() < 1.5 * steps.min()  # of a shortest path they are even


def test_great_circles_are_found(sphere):
    rng = np.random.default_rng(0)
    starts = sphere.project(clouds.draw_sphere(10, rng))
    goals = sphere.project(clouds.draw_sphere(10, rng))
    for start, goal in zip(starts, goals, strict=True):
        angle = np.arccos(np.clip(start @ goal / np.linalg.norm(start) / np.linalg.norm(goal), -1, 1))
        if angle > 2.5:
            continue  # near the antipode every way is as short
        plan = sphere.plan(start, goal)
        assert plan.success
        assert plan.converged
        assert plan.length == pytest.approx(angle, rel=2e-3)
        normal = np.cross(start, goal) / np.linalg.norm(np.cross(start, goal))
        assert np.abs(plan.path.states @ normal).max() < 0.02


def test_the_arm_s_paths_are_optimal_poses(arm):
    starts, goals = arm_poses(5, 1), arm_poses(5, 2)
    states = np.concatenate([arm.plan(a, b).path.states for a, b in zip(starts, goals, strict=True)])
    truth = optimal(forward(states), REACHING)
    assert np.sqrt(((states - truth) ** 2).mean()) < 1e-3


@pytest.mark.parametrize("kind", KINDS)
def test_via_points_are_passed(skills, kind):
    skill = skills[kind]
    start, first, second, goal = skill.sample(4, seed=3)
    for via in (first[None], np.stack([first, second]), [first.tolist()]):
        for route in ("geodesic", "demonstrated") if skill.route else ("geodesic",):
            states = skill.plan(start, goal, 41, via=via, route=route).path.states
            assert len(states) == 41
            np.testing.assert_array_equal(states[[0, -1]], [start, goal])
            rows = [int(np.flatnonzero((states == v).all(1))[0]) for v in np.asarray(via)]
            assert rows == sorted(rows)
            assert 0 < rows[0] <= rows[-1] < 40


@pytest.mark.parametrize("rows", [(6, [55], 30), (24, [2], 55), (0, [45, 15], 59), (55, [20, 40], 3)])
def test_via_points_in_another_order_than_the_demonstrations_are_passed(recorded, rows):
    """Beyond the goal, before the start, swapped: leg by leg where the whole route would be torn."""
    start, via, goal = rows
    curve = curves()[2]
    plan = recorded.plan(curve[start], curve[goal], via=curve[via])
    assert plan.success, plan.reason
    assert plan.route == "demonstrated"
    found = [int(np.flatnonzero((plan.path.states == curve[row]).all(1))[0]) for row in via]
    assert found == sorted(found)
    given = [start, *via, goal]
    ways = [np.diff(curve[min(a, b) : max(a, b) + 1], axis=0) for a, b in pairwise(given)]
    assert plan.path.length < 1.1 * np.linalg.norm(np.concatenate(ways), axis=1).sum()


@law
def test_ends_off_the_manifold_are_projected_and_the_plan_says_so(skills, kind, seed):
    skill = skills[kind]
    start, goal = skill.sample(2, seed=seed % 2**31)
    normal = skill.distance_gradient(start + 0.1 * skill.model.scale * np.ones(skill.n_dims))
    off = start + 0.3 * skill.model.scale * normal
    # Where recordings spread, the displacement may be within tolerance and the way to a sure point not.
    if OnManifold(skill.model, skill.tolerance).distance(off[None])[0] <= skill.tolerance * 1.01:
        return
    plan = skill.plan(off, goal, route="geodesic")
    np.testing.assert_allclose(plan.path.states[0], skill.project(off), atol=1e-12)
    assert plan.start_moved == pytest.approx(np.linalg.norm(plan.path.states[0] - off))
    assert plan.goal_moved == 0.0
    assert "start moved" in plan.reason


@pytest.mark.parametrize("kind", KINDS)
def test_a_plan_that_stays_where_it_is(skills, kind):
    skill = skills[kind]
    x = skill.sample(1, seed=0)[0]
    plan = skill.plan(x, x, route="geodesic")
    assert plan.success, plan.reason
    assert plan.length < 1e-5 * skill.model.scale
    np.testing.assert_allclose(plan.path.states, np.broadcast_to(x, plan.path.states.shape), atol=1e-5)


@pytest.mark.parametrize("options", [{}, {"route": "demonstrated"}])
def test_a_method_of_geodesics_is_not_dropped_in_silence(recorded, options):
    with pytest.raises(InputError, match="'leaf' is for geodesics; ask for route='geodesic'"):
        recorded.plan(np.zeros(recorded.n_dims), np.ones(recorded.n_dims), method="leaf", **options)


def test_demonstrated_routes_end_exactly_and_follow_the_recordings(recorded):
    for curve in curves():
        plan = recorded.plan(curve[0], curve[-1])
        assert plan.success, plan.reason
        assert plan.route == "demonstrated"
        np.testing.assert_array_equal(plan.path.states[[0, -1]], curve[[0, -1]])
        gaps = np.linalg.norm(plan.path.states[:, None] - curve, axis=2).min(1)
        assert gaps.max() < 0.05
        assert len(plan.path.states) == 101


def test_plans_that_cannot_be_met_are_data(recorded):
    start = curves()[0][0]
    plan = recorded.plan(start, start + 100.0)
    assert not plan.success
    assert plan.reason
    assert plan.path.states.shape == (101, 3)
    assert np.isfinite(plan.path.states).all()
    assert "failure" in repr(plan)


def test_limits_that_a_path_breaks_make_it_fail():
    """Over a gap at the top of a sphere, as narrow as others between its samples but beyond the limit."""
    x = clouds.draw_sphere(600, np.random.default_rng(0))
    x = x[x[:, 2] < 0.98]
    skill = fit(x, 2, space=StateSpace.linear(3, -2.0, [2.0, 2.0, 0.985]))
    over_the_top = skill.plan([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8])
    assert not over_the_top.success
    assert "breaks the limits" in over_the_top.reason
    assert skill.plan([0.6, 0.0, 0.8], [0.0, 0.6, 0.8]).success


def test_demonstrated_routes_from_beyond_the_limits_say_so_first():
    """As from degrees where radians are meant; jumps and distances that follow from it tell less."""
    skill = fit(curves(), 1, 6, space=StateSpace.angles(3, -0.5, 2.5))
    start, goal = curves()[0][[0, -1]]
    plan = skill.plan(start, np.degrees(goal))
    assert not plan.success and plan.route == "demonstrated"
    assert plan.reason == "The goal breaks the limits of coordinate 0 by 54.8."


def test_given_states_off_the_manifold_are_told(recorded):
    start, goal = curves()[2][[0, -1]]
    aside = start + np.array([0.0, 0.0, 0.3])
    assert f"{recorded.distance(aside):.2g} off the manifold" in recorded.plan(aside, goal).reason
    assert "off the manifold" not in recorded.plan(start, goal).reason


def test_geodesic_distance_is_the_length_of_the_plan(sphere):
    a, b = sphere.sample(6, seed=1).reshape(2, 3, 3)
    lengths = sphere.geodesic_distance(a, b)
    assert lengths.shape == (3,)
    for i in range(3):
        plan = sphere.plan(a[i], b[i], route="geodesic")
        assert lengths[i] == (plan.length if plan.success else np.inf)
        assert isinstance(sphere.geodesic_distance(a[i], b[i]), float)
    np.testing.assert_allclose(sphere.geodesic_distance(b, a), lengths, rtol=1e-3)
    np.testing.assert_allclose(sphere.geodesic_distance(a[0], b), [sphere.geodesic_distance(a[0], x) for x in b])


def test_paths_keep_within_the_edge():
    """Between horns of land; the bay was not shown. Nothing holds a path ashore, nor one whose ends are afloat."""
    skill = fit(clouds.bay(300), 2)
    horns, ashore, afloat = ([[-0.8, 0.3], [0.8, 0.3]], [[-0.6, 0.8], [0.6, 0.8]], [[-0.2, 0.3], [0.2, 0.3]])
    plans = [skill.plan(*np.column_stack([ends, 0.3 * np.prod(ends, axis=1)])) for ends in (horns, ashore, afloat)]
    held = ["held within the edge" in plan.reason for plan in plans]
    assert held == [True, False, False]
    assert all(plan.converged for plan in plans)
    assert plans[0].success
    x, y, _ = plans[0].path.states.T
    assert (0.6 * (1.0 - x**2) - y).max() < 0.1
    steps = np.linalg.norm(np.diff(plans[0].path.states, axis=0), axis=1)
    assert steps.max() < 1.5 * steps.mean()


def _arches(count, steps=50):
    """Recordings without noise, exact copies of each other but for where they are aside."""
    t = np.linspace(0.0, 1.0, steps)
    return [np.column_stack([t, np.full(steps, y), 0.2 * np.sin(3.0 * t)]) for y in np.linspace(0.0, 1.0, count)]


@pytest.mark.parametrize(
    ("recordings", "dim"),
    [(_arches(21), 2), ([_arches(1)[0]] * 2, 1), ([np.outer(np.linspace(0.0, 1.0, 50), [1.0, 2.0, 3.0])] * 2, 1)],
    ids=["copies", "twice the same", "line"],
)
def test_recordings_without_noise_are_followed_on_their_surface(recordings, dim):
    """Chords between the recorded states lie farther off it than samples do."""
    skill = fit(recordings, dim)
    for i, j in np.random.default_rng(0).choice(50, (5, 2), replace=False):
        plan = skill.plan(recordings[0][i], recordings[-1][j])
        assert plan.success, plan.reason
        off = skill.distance(plan.path.states)
        allowed = skill.tolerance + 3.0 * plan.stats["spread"].max() + 1e-6 * skill.model.scale
        assert off.max() <= 1.01 * max(allowed, 1.5 * off[0], 1.5 * off[-1])
        bends = np.linalg.norm(np.diff(plan.path.states, 2, axis=0), axis=1)
        assert bends.max() < plan.length / len(bends)


def test_a_geodesic_to_where_it_starts_stays_there():
    """Also where the state is a little off the surface and the field tells its tangents badly."""
    recordings = curves()
    skill = fit(recordings, 2, kernels=1)
    for state in recordings[0][::20]:
        plan = skill.plan(state, state, route="geodesic")
        assert plan.success, plan.reason
        assert plan.length == 0.0


def test_on_a_roll_no_path_goes_from_sheet_to_sheet():
    """Where a path grown straight toward its goal jumps across the gap, one is found over the samples."""
    rng = np.random.default_rng(3)
    turn, along = rng.uniform(-np.pi, np.pi, 600), rng.uniform(-1.0, 1.0, 600)
    radius = 1.0 + 0.5 * turn / np.pi
    skill = fit(np.column_stack([radius * np.cos(turn), radius * np.sin(turn), along]), 2, 20)
    ends = samples_of(skill)[rng.permutation(600)[:40].reshape(20, 2)]
    for start, goal in ends:
        plan = skill.plan(start, goal)
        assert plan.success, plan.reason
        x, y, _ = plan.path.states.T
        angle = np.arctan2(y, x)
        np.testing.assert_allclose(np.hypot(x, y), 1.0 + 0.5 * angle / np.pi, atol=1e-5)
        assert np.abs(np.diff(angle)).max() < 0.5  # at a turn of π the roll ends
