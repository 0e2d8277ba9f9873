"""Laws of projection, tangents and distance: what must hold for any state, on skills of every kind."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from manifold import clouds
from manifold.conftest import fit
from manifold.kernels import scratch_memory
from manifold.laws import SURFACES, law, law_of_surfaces, states_about


@law_of_surfaces
def test_projecting_twice_is_projecting_once(skills, kind, seed):
    skill = skills[kind]
    once = skill.project(states_about(skill, seed))
    assert np.abs(skill.project(once) - once).max() < 1e-8 * skill.model.scale


@law_of_surfaces
def test_what_was_projected_is_on_the_manifold(skills, kind, seed):
    skill = skills[kind]
    on = skill.project(states_about(skill, seed))
    assert skill.distance(on).max() < 1e-8 * skill.model.scale
    assert skill.contains(on).all()


def test_of_recordings_most_states_find_the_manifold(recorded):
    """Where recordings part, the blend of their surfaces may have no point to go to; elsewhere the laws hold."""
    on = recorded.project(states_about(recorded, 0, count=500))
    assert np.mean(recorded.distance(on) < 1e-8 * recorded.model.scale) > 0.9


def test_far_states_go_no_farther_out_than_the_demonstrations():
    """The learnt surface goes on beyond them, but what a state far off it means is within."""
    rng = np.random.default_rng(3)
    u = rng.uniform(0.0, 1.0, (500, 2))
    skill = fit(np.column_stack([u, 0.1 * np.sin(9.0 * u[:, 0]) * np.cos(9.0 * u[:, 1])]), 2)
    far = np.column_stack([rng.uniform(-1.0, 2.0, (100, 2)), rng.uniform(1.0, 2.0, 100)])
    on = skill.project(far)
    assert on[:, :2].min() > u.min() - 2e-3
    assert on[:, :2].max() < u.max() + 2e-3


def foot(skill, state):
    """Straight steps back onto the surface from the sure anchor nearest to a state, what is free as in the state.

    Anchors that disagree with their neighbours about the surface are no place to start from (`Trust.sure`).
    """
    model = skill.model
    scratch = scratch_memory.make_scratch(model.table, 1)
    sure = model.anchors[model.trust.sure]
    point = sure[np.linalg.norm(sure - model.encode(state), axis=1).argmin()].copy()
    for _ in range(20):
        scratch_memory.evaluate(point[None], scratch)
        point -= scratch.normals[0]
    return model.moved(state, point)


@law_of_surfaces
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


@law_of_surfaces
def test_tracked_states_keep_the_answer_on_their_sheet(skills, kind, seed):
    skill = skills[kind]
    on = skill.project(states_about(skill, seed, spread=0.05))
    rng = np.random.default_rng(seed)
    pushed = on + 1e-3 * skill.model.scale * rng.normal(size=on.shape)
    back = skill.project(pushed, near=on)
    assert skill.distance(back).max() < 1e-7 * skill.model.scale
    assert (np.linalg.norm(back - pushed, axis=1) <= np.linalg.norm(on - pushed, axis=1) * (1 + 1e-5)).all()


def test_next_to_the_surface_no_state_is_moved_far(creased):
    """Where anchors disagree by a small share of the distance between samples, they still speak of one surface.

    At a crease, in samples without noise, that is many times more than they usually disagree by.
    """
    rng, model = np.random.default_rng(0), creased.model
    states = clouds.crease(6000, rng, inner=0.8)
    on = creased.project(states, near=states)
    on = creased.project(on, near=on) + 1e-6 * rng.normal(size=on.shape)
    scratch = scratch_memory.make_scratch(model.table, len(on))
    scratch_memory.evaluate(model.encode(on), scratch)
    unusual = scratch.doubts > 10.0 * model.trust.doubt
    one = scratch.doubts < 0.2 * model.trust.spacing
    assert (unusual & one).sum() > 10
    moved = np.linalg.norm(creased.project(on) - on, axis=1)
    assert moved[one].max() < 1e-5
    assert creased.distance(on)[one].max() < 1e-5


def test_between_two_sheets_a_state_goes_to_one_of_them():
    """Their blend is no surface, without noise either: it lies between them, who are farther apart than samples."""
    rng = np.random.default_rng(1)

    def bowl(places, height):
        return np.column_stack([places, 0.2 * (places**2).sum(1) + height])

    sheets = bowl(rng.uniform(-1, 1, (400, 2)), np.where(np.arange(400) % 2, 0.3, -0.3))
    skill = fit(sheets, 2, 5, neighbors=30)
    between = bowl(rng.uniform(-0.8, 0.8, (200, 2)), rng.uniform(-0.02, 0.02, 200))
    on = skill.project(between)
    height = on[:, 2] - 0.2 * (on[:, :2] ** 2).sum(1)
    assert np.abs(np.abs(height) - 0.3).max() < 1e-4
    assert skill.distance(between).min() > 0.25


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


@law
def test_tangents_are_orthonormal(skills, kind, seed):
    skill = skills[kind]
    basis = skill.tangent(states_about(skill, seed, spread=3.0))
    assert basis.shape == (5, skill.n_dims, skill.dim)
    gram = np.swapaxes(basis, 1, 2) @ basis
    np.testing.assert_allclose(gram, np.broadcast_to(np.eye(skill.dim), gram.shape), atol=1e-12)


@law_of_surfaces
def test_a_step_along_the_tangents_stays_on_the_manifold_to_first_order(skills, kind, seed):
    skill = skills[kind]
    on = skill.project(states_about(skill, seed, spread=0.02))
    for length in (1e-2, 1e-3):
        for a in range(skill.dim):
            moved = on + length * skill.model.scale * skill.tangent(on)[..., a]
            # The field is learnt: its tangents are those of the surface up to a small angle only.
            assert np.median(skill.distance(moved)) < 0.2 * length * skill.model.scale


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


def test_a_skill_sent_to_another_process_makes_its_own_table(sphere):
    """A table holds addresses, which mean nothing elsewhere."""
    states = states_about(sphere, 1)
    expected = sphere.distance(states)
    sent = pickle.dumps(sphere)
    assert sphere.model.table is sphere.model.table
    for copy in (pickle.loads(sent), replace(sphere, model=replace(sphere.model))):
        np.testing.assert_array_equal(copy.distance(states), expected)
        assert not np.array_equal(copy.model.table, sphere.model.table)
