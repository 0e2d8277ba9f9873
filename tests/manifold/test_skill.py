"""Laws of a fitted skill: what must hold for any state, on skills of every kind."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from manifold import clouds
from manifold.conftest import arm_poses, curves, fit
from skillfold import SkillManifold, StateSpace
from skillfold.experiments.three_link import REACHING, forward, optimal
from skillfold.manifold.kernels import surface as kernels

KINDS = ["sphere", "arm", "cylinder", "recorded"]
SURFACES = KINDS[:3]  # of one surface each; curves that differ leave it open which of them a state belongs to
SEEDS = st.integers(0, 2**32 - 1)


class Skills(dict):
    """By kind; told in a word, or a failing law would print all their arrays."""

    def __repr__(self):
        return "skills"


@pytest.fixture(scope="session")
def skills(sphere, arm, cylinder, recorded):
    return Skills(zip(KINDS, (sphere, arm, cylinder, recorded), strict=True))


def samples_of(skill):
    """The anchors, in state units; what is free at its middle."""
    model = skill.model
    return model.centre + model.scale * model.anchors @ model.kept.T


def states_about(skill, seed, count=5, spread=0.3):
    """States near the samples and off them, by up to some share of the skill's size."""
    rng = np.random.default_rng(seed)
    at = samples_of(skill)[rng.integers(0, skill.model.anchors.shape[0], count)]
    off = rng.normal(size=at.shape) * spread * rng.random((count, 1)) * skill.model.scale
    return at + off


def law(function):
    return settings(max_examples=15, deadline=None)(given(kind=st.sampled_from(KINDS), seed=SEEDS)(function))


# Projection


@law
def test_projecting_twice_is_projecting_once(skills, kind, seed):
    skill = skills[kind]
    once = skill.project(states_about(skill, seed))
    assert np.abs(skill.project(once) - once).max() < 1e-8 * skill.model.scale


@law
def test_what_was_projected_is_on_the_manifold(skills, kind, seed):
    skill = skills[kind]
    on = skill.project(states_about(skill, seed))
    assert skill.distance(on).max() < 1e-8 * skill.model.scale
    assert skill.contains(on).all()


def foot(skill, state):
    """Straight steps back onto the surface from the anchor nearest to a state, what is free as in the state."""
    model = skill.model
    scratch = kernels.make_scratch(model.surface, model.field)
    point = model.anchors[np.linalg.norm(model.anchors - model.encode(state), axis=1).argmin()].copy()
    normal = np.empty(len(point))
    for _ in range(20):
        kernels.displacement(model.surface, model.field, point, scratch, normal)
        point -= normal
    return model.moved(state, point)


@law
def test_never_farther_than_the_nearest_anchor_s_foot(skills, kind, seed):
    skill = skills[kind]
    for state in states_about(skill, seed):
        limit = np.linalg.norm(state - foot(skill, state))
        assert np.linalg.norm(state - skill.project(state)) <= limit * (1 + 1e-6) + 1e-9 * skill.model.scale


@pytest.mark.parametrize("kind", SURFACES)
def test_the_way_back_is_at_right_angles_to_the_manifold(skills, kind):
    """Where the answer lies amid the demonstrations; at their edge it may be the edge that is nearest."""
    skill = skills[kind]
    states = states_about(skill, 0, count=500, spread=0.1)
    on = skill.project(states)
    amid = skill.inside(on) < 0.7
    assert amid.sum() > 100
    along = np.abs(np.einsum("nca,nc->na", skill.tangent(on), states - on)[amid]).max(1)
    assert np.quantile(along, 0.98) < 1e-7 * skill.model.scale


@law
def test_the_distance_is_that_to_the_projection(skills, kind, seed):
    skill = skills[kind]
    states = states_about(skill, seed)
    way = np.linalg.norm(states - skill.project(states), axis=1)
    # Next to the surface the displacement is taken for the distance: equal up to its square.
    np.testing.assert_allclose(skill.distance(states), way, rtol=1e-5, atol=1e-9 * skill.model.scale)


@law
def test_tracked_states_keep_the_answer_on_their_sheet(skills, kind, seed):
    skill = skills[kind]
    on = skill.project(states_about(skill, seed, spread=0.05))
    rng = np.random.default_rng(seed)
    pushed = on + 1e-3 * skill.model.scale * rng.normal(size=on.shape)
    back = skill.project(pushed, near=on)
    assert skill.distance(back).max() < 1e-7 * skill.model.scale
    assert (np.linalg.norm(back - pushed, axis=1) <= np.linalg.norm(on - pushed, axis=1) * (1 + 1e-5)).all()


def test_of_a_sphere_all_is_known(sphere):
    rng = np.random.default_rng(0)
    directions = clouds.draw_sphere(200, rng)
    radii = rng.uniform(0.6, 1.4, (200, 1))
    on = sphere.project(radii * directions)
    assert np.median(np.linalg.norm(on - directions, axis=1)) < 2e-3
    assert np.median(np.abs(sphere.distance(radii * directions) - np.abs(radii[:, 0] - 1))) < 1e-3
    gradient = sphere.distance_gradient(radii * directions)
    away = np.sign(radii - 1) * directions
    assert np.median((gradient * away).sum(1)) > 0.9999
    assert np.median(np.abs((sphere.tangent(directions) * directions[..., None]).sum(1))) < 0.02


# Tangents


@law
def test_tangents_are_orthonormal(skills, kind, seed):
    skill = skills[kind]
    basis = skill.tangent(states_about(skill, seed, spread=3.0))
    assert basis.shape == (5, skill.n_dims, skill.dim)
    gram = np.swapaxes(basis, 1, 2) @ basis
    np.testing.assert_allclose(gram, np.broadcast_to(np.eye(skill.dim), gram.shape), atol=1e-12)


@law
def test_a_step_along_the_tangents_stays_on_the_manifold_to_first_order(skills, kind, seed):
    skill = skills[kind]
    on = skill.project(states_about(skill, seed, spread=0.02))
    for length in (1e-2, 1e-3):
        for a in range(skill.dim):
            moved = on + length * skill.model.scale * skill.tangent(on)[..., a]
            # The field is learnt: its tangents are those of the surface up to a small angle only.
            assert np.median(skill.distance(moved)) < 0.2 * length * skill.model.scale


# Distance


@pytest.mark.parametrize("kind", SURFACES)
def test_distance_has_the_gradient_it_says(skills, kind):
    """Finite differences away from the surface, where the answer lies amid the demonstrations.

    Projection goes along the learnt field, so the way back is at right angles to that, not quite to the surface: the
    gradient is right up to the small angle between the two.
    """
    skill = skills[kind]
    scale = skill.model.scale
    states = states_about(skill, 0, count=300)
    away = (skill.distance(states) > 0.02 * scale) & (skill.inside(skill.project(states)) < 0.7)
    states = states[away]
    assert len(states) > 100
    h = 1e-5 * scale
    slopes = np.empty_like(states)
    for c in range(skill.n_dims):
        step = h * np.eye(skill.n_dims)[c]
        slopes[:, c] = (skill.distance(states + step) - skill.distance(states - step)) / (2 * h)
    error = np.linalg.norm(skill.distance_gradient(states) - slopes, axis=1)
    assert np.median(error) < 0.02
    assert np.quantile(error, 0.9) < 0.05


@law
def test_the_gradient_is_a_unit_vector_or_nothing(skills, kind, seed):
    skill = skills[kind]
    states = states_about(skill, seed)
    lengths = np.linalg.norm(skill.distance_gradient(np.vstack([states, skill.project(states)])), axis=1)
    np.testing.assert_allclose(lengths[:5], 1.0, atol=1e-9)
    assert ((np.abs(lengths[5:]) < 1e-9) | (np.abs(lengths[5:] - 1) < 1e-9)).all()


@pytest.mark.parametrize("kind", SURFACES)
def test_nothing_is_farther_than_it_was_moved(skills, kind):
    """Distance from a set changes no faster than the state does; where it stays among the demonstrations."""
    skill = skills[kind]
    on = skill.project(states_about(skill, 0, count=300, spread=0.02))
    step = 0.03 * skill.model.scale * np.random.default_rng(0).normal(size=on.shape)
    assert (skill.distance(on + step) <= np.linalg.norm(step, axis=1) * (1 + 1e-5)).all()


@law
def test_contains_is_distance_below_tolerance(skills, kind, seed):
    skill = skills[kind]
    states = states_about(skill, seed)
    distance = skill.distance(states)
    np.testing.assert_array_equal(skill.contains(states), distance <= skill.tolerance)
    np.testing.assert_array_equal(skill.contains(states, distance[0]), distance <= distance[0])


# Inside, samples


def test_inside_is_calibrated_on_held_out_samples():
    """One is the 95 % quantile: of new samples of the same kind about one in twenty lies beyond."""
    rng = np.random.default_rng(5)
    skill = fit(clouds.draw_sphere(400, rng), 2)
    share = (skill.inside(clouds.draw_sphere(2000, rng)) > 1).mean()
    assert 0.02 < share < 0.09


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
    assert len(np.unique(x, axis=0)) == 100
    np.testing.assert_array_equal(skill.sample(100, seed=1), x)
    assert not np.array_equal(skill.sample(100, seed=2), x)
    assert skill.sample(0).shape == (0, skill.n_dims)


def test_samples_of_a_sphere_are_spread_over_it(sphere):
    x = sphere.sample(2000, seed=0)
    np.testing.assert_allclose(x.mean(0), 0.0, atol=0.08)
    np.testing.assert_allclose(x.T @ x / 2000, np.eye(3) / 3, atol=0.06)


# Plans


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
        assert plan.residual == pytest.approx(skill.distance(states).max(), abs=1e-9 * skill.model.scale)
        assert (plan.route, plan.start_moved, plan.goal_moved) == ("geodesic", 0.0, 0.0)
        if plan.converged and plan.success:
            steps = np.linalg.norm(np.diff(states, axis=0), axis=1)
            assert plan.residual < 1e-5 * skill.model.scale
            if kind in SURFACES:
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


@law
def test_ends_off_the_manifold_are_projected_and_the_plan_says_so(skills, kind, seed):
    skill = skills[kind]
    start, goal = skill.sample(2, seed=seed % 2**31)
    normal = skill.distance_gradient(start + 0.1 * skill.model.scale * np.ones(skill.n_dims))
    off = start + 0.3 * skill.model.scale * normal
    if skill.distance(off) <= skill.tolerance * 1.01:
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
    x = clouds.draw_sphere(300, np.random.default_rng(0))
    x = x[x[:, 2] < 0.9]
    space = StateSpace.linear(3, -2.0, [2.0, 2.0, 0.9])
    skill = fit(x, 2, space=space)
    over_the_top = skill.plan([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8])
    assert not over_the_top.success
    assert "breaks the limits" in over_the_top.reason
    assert skill.plan([0.6, 0.0, 0.8], [0.0, 0.6, 0.8]).success


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


# Batches, seeds, invariance


@pytest.mark.parametrize("kind", KINDS)
def test_batches_equal_single_calls(skills, kind):
    skill = skills[kind]
    x = states_about(skill, 0, count=6).reshape(2, 3, skill.n_dims)
    near = skill.project(states_about(skill, 1, count=6)).reshape(x.shape)
    for ask in (
        lambda s: skill.project(s),
        lambda s: skill.project(s, method="leaf"),
        lambda s: skill.distance(s),
        lambda s: skill.distance_gradient(s),
        lambda s: skill.inside(s),
        lambda s: skill.contains(s),
        lambda s: skill.tangent(s),
    ):
        batch = ask(x)
        single = [[ask(x[i, j]) for j in range(3)] for i in range(2)]
        # Not to the last bit: matrix products of one row and of many add in another order.
        np.testing.assert_allclose(batch, single, rtol=0, atol=1e-9)
        assert np.shape(ask(np.empty((0, skill.n_dims))))[0] == 0
    expected = [[skill.project(x[i, j], near=near[i, j]) for j in range(3)] for i in range(2)]
    np.testing.assert_allclose(skill.project(x, near=near), expected, atol=1e-9)
    one_for_all = skill.project(x, near=near[0, 0])
    np.testing.assert_allclose(one_for_all[1, 2], skill.project(x[1, 2], near=near[0, 0]), atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_single_answers_are_plain_numbers(skills, kind):
    skill = skills[kind]
    x = samples_of(skill)[0].tolist()
    assert isinstance(skill.distance(x), float)
    assert isinstance(skill.inside(x), float)
    assert skill.contains(x) in (True, False)
    assert skill.project(x).shape == (skill.n_dims,)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_given_stays_as_it_is(skills, kind):
    skill = skills[kind]
    x = states_about(skill, 0)
    before = x.copy()
    skill.project(x)
    skill.project(x, near=x)
    skill.project(x, method="leaf")
    skill.distance(x)
    skill.distance_gradient(x)
    skill.plan(x[0], x[1], via=x[2:3])
    np.testing.assert_array_equal(x, before)


DATA = {
    "cloud": (clouds.draw_sphere(150, np.random.default_rng(0)), 2),
    "cylinder": (clouds.cylinder(1)(300, np.random.default_rng(1))[0], 2),
    "recordings": (curves(), 1),
}


def mapped(data, function):
    return [function(part) for part in data] if isinstance(data, list) else function(data)


@pytest.mark.parametrize("kind", DATA)
def test_the_same_seed_gives_the_same_bits(kind):
    data, dim = DATA[kind]
    first, second, other = (fit(data, dim, 8, seed=seed) for seed in (4, 4, 5))
    for name in ("points", "frames", "coefficients", "radii"):
        np.testing.assert_array_equal(getattr(first.model.surface, name), getattr(second.model.surface, name))
    np.testing.assert_array_equal(first.model.field.weights, second.model.field.weights)
    assert first.model.tolerance == second.model.tolerance
    assert not np.array_equal(first.model.field.weights, other.model.field.weights)


def test_fitting_leaves_the_global_generator_alone():
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    fit(*DATA["cloud"])
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002


@pytest.fixture(scope="module", params=DATA)
def plain(request):
    data, dim = DATA[request.param]
    return data, dim, fit(data, dim, 8)


def turn(D):
    return np.linalg.qr(np.random.default_rng(9).normal(size=(D, D)))[0]


MOTIONS = {
    "turned and moved": lambda x: x @ turn(x.shape[-1]).T + np.arange(1.0, 1.0 + x.shape[-1]),
    "coordinates permuted": lambda x: np.roll(x, 1, axis=-1),
    "mirrored": lambda x: x * np.r_[-1.0, np.ones(x.shape[-1] - 1)],
}


@pytest.mark.parametrize("motion", MOTIONS)
def test_rigid_motions_commute_with_everything(plain, motion):
    data, dim, skill = plain
    move = MOTIONS[motion]
    moved = fit(mapped(data, move), dim, 8)
    assert [t.setting for t in moved.selection if t.chosen] == [t.setting for t in skill.selection if t.chosen]
    states = states_about(skill, 0, count=20, spread=0.2)
    np.testing.assert_allclose(moved.distance(move(states)), skill.distance(states), atol=1e-7)
    np.testing.assert_allclose(moved.inside(move(states)), skill.inside(states), atol=1e-7)
    np.testing.assert_allclose(moved.project(move(states)), move(skill.project(states)), atol=1e-7)
    ends = skill.project(states[:2])
    for route in ("geodesic", "demonstrated") if skill.route else ("geodesic",):
        path = skill.plan(*ends, route=route).path.states
        found = moved.plan(*move(ends), route=route).path.states
        np.testing.assert_allclose(found, move(path), atol=1e-6)


def test_scale_commutes_too(plain):
    data, dim, skill = plain
    larger = fit(mapped(data, lambda x: 1000.0 * x), dim, 8)
    states = states_about(skill, 0, count=20, spread=0.2)
    np.testing.assert_allclose(larger.distance(1000.0 * states), 1000.0 * skill.distance(states), atol=1e-4)
    np.testing.assert_allclose(larger.project(1000.0 * states), 1000.0 * skill.project(states), atol=1e-4)


def test_a_turn_more_of_a_continuous_angle_is_the_same_state():
    """A helix in (angle, height): its states written with other turns."""
    angle = np.linspace(0, 2.5, 60)
    paths = [np.column_stack([angle, 0.5 * angle + 0.1 * i, np.cos(angle)]) for i in range(4)]
    skill = fit(paths, 1, 6, space=StateSpace.continuous(1) + StateSpace.linear(2))
    x = states_about(skill, 0)
    other = x + [2 * np.pi, 0.0, 0.0]
    np.testing.assert_allclose(skill.distance(other), skill.distance(x), atol=1e-9)
    np.testing.assert_allclose(skill.project(other), skill.project(x), atol=1e-9)


def test_everything_left_out_is_chosen_and_kept_in_the_table():
    skill = SkillManifold.fit(clouds.torus(200, np.random.default_rng(0)), jobs=1)
    assert skill.dim == 2
    assert {t.choice for t in skill.selection} == {"dimension", "surface", "field"}
    for choice in ("dimension", "surface", "field"):
        assert sum(t.chosen for t in skill.selection.of(choice)) == 1
    assert f"{skill.kernels} kernels" in next(t.setting for t in skill.selection.of("field") if t.chosen)
    assert skill.residual < 0.05
    assert "2 of 3 dimensions" in repr(skill)


def test_noise_is_estimated():
    rng = np.random.default_rng(0)
    skill = fit(clouds.draw_sphere(800, rng) + 0.02 * rng.normal(size=(800, 3)), 2)
    assert skill.noise == pytest.approx(0.02, rel=0.3)
    assert skill.tolerance > skill.noise


def test_crossing_recordings_are_noticed():
    t = np.linspace(0, 2 * np.pi, 120)
    eights = [np.column_stack([np.sin(t), np.sin(2 * t)]) + 0.01 * i for i in range(3)]
    with pytest.warns(UserWarning, match="crosses its own path"):
        skill = fit(eights, 1)
    assert len(skill.notes) == 1
