"""What changes nothing, or everything in the same way: batches, seeds, rigid motions; and what fit tells."""

import numpy as np
import pytest

from manifold import clouds
from manifold.conftest import curves, fit
from manifold.laws import KINDS, samples_of, states_about
from skillfold import SkillManifold, StateSpace


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
    for name in ("points", "tangents", "bends", "radii"):
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
    other = x + np.array([2 * np.pi, 0.0, 0.0])
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
    assert "2 of 3 dimensions" in repr(skill) and f"{skill.n_samples} samples, residual" in repr(skill)


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
