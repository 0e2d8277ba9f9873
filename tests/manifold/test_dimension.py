import numpy as np
import pytest

from manifold import clouds
from skillfold.experiments.upright import JACO, upright_poses
from skillfold.manifold.dimension import choose_dimension, gaps_after, local_extents, scales, thinned

KNOWN = {
    "circle": (clouds.draw_circle, 1),
    "sphere": (clouds.draw_sphere, 2),
    "torus": (clouds.torus, 2),
    "height": (clouds.draw_plane, 2),
    "two circles": (clouds.tori, 2),
    "sphere in 4": (clouds.sphere_of(4), 3),
    "sheet 2 in 5": (clouds.sheet(5, 2), 2),
    "sheet 3 in 5": (clouds.sheet(5, 3), 3),
    "curve in 6": (clouds.sheet(6, 1), 1),
}


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize("count", [400, 1000])
def test_the_dimension_of_known_sets_is_found(name, noise, count):
    draw, dim = KNOWN[name]
    for seed in range(3):
        rng = np.random.default_rng(seed)
        x = draw(count, rng)
        x = clouds.normalised(x + noise * rng.normal(size=x.shape))
        found, trials = choose_dimension(x, None, seed=0)
        assert found == dim
        assert [t.setting for t in trials if t.chosen] == [f"d = {dim}"]


@pytest.mark.parametrize("name", ["circle", "sphere", "two circles"])
def test_rigid_motions_and_order_do_not_matter(name):
    draw, dim = KNOWN[name]
    rng = np.random.default_rng(0)
    x = draw(400, rng)
    moved = clouds.rotated(x, rng)[rng.permutation(400)] * 50.0 - 3.0
    assert choose_dimension(moved, None, 0)[0] == dim


def test_extents_are_those_of_the_local_covariance():
    """With all samples as neighbours they are the singular values themselves, in the root mean square."""
    rng = np.random.default_rng(0)
    x = rng.normal(size=(40, 3)) * [1.0, 0.5, 0.01]
    values = np.linalg.svd(x - x.mean(0), compute_uv=False)
    everything = np.tile(np.arange(40), (40, 1))
    np.testing.assert_allclose(local_extents(x, np.arange(40), everything, True), values / np.sqrt(40), rtol=1e-9)


def test_extents_about_a_sample_of_another_recording_show_what_the_others_do_not():
    """Neighbours in a plane, samples scattered all about them."""
    rng = np.random.default_rng(1)
    plane = rng.normal(size=(500, 3)) * [1.0, 1.0, 0.0]
    x = np.vstack([plane, rng.normal(size=(4000, 3))])
    around = np.tile(np.arange(500), (4000, 1))
    extents = local_extents(x, np.arange(500, 4500), around, False)
    np.testing.assert_allclose(extents, np.sqrt([2.0, 2.0, 1.0]), rtol=0.1)


@pytest.mark.parametrize("seed", range(3))
def test_bends_are_no_dimension(seed):
    """The upright tool of a six-joint arm: wide neighbourhoods are as thick as they bend."""
    poses = clouds.normalised(upright_poses(JACO, 1000, np.random.default_rng(seed)))
    assert choose_dimension(poses, None, 0)[0] == 4


@pytest.mark.parametrize("name", ["circle", "curve in 6", "sphere", "sheet 2 in 5"])
@pytest.mark.parametrize("count", [3000, 10000])
@pytest.mark.parametrize("noise", [0.01, 0.03])
def test_noise_wider_than_samples_lie_apart_is_no_dimension(name, count, noise):
    draw, dim = KNOWN[name]
    rng = np.random.default_rng(count)
    x = clouds.normalised(draw(count, rng))
    x += noise * rng.normal(size=x.shape)
    assert choose_dimension(x, None, 0)[0] == dim


def test_samples_are_thinned_while_all_neighbourhoods_find_enough():
    x = np.random.default_rng(0).normal(size=(5000, 3))
    assert [len(some) for some in thinned(x, 0, 3)] == [5000, 1250, 312]
    assert [len(some) for some in thinned(x[:600], 0, 3)] == [600]
    assert len(np.unique(np.vstack(thinned(x, 0, 3)), axis=0)) == 5000


@pytest.mark.parametrize("growth", [0.0, 0.5, 1.2])
def test_a_direction_counts_as_one_unless_it_grows_as_bends_do(growth):
    """The sharper gap, after a third direction, shows in wide neighbourhoods only."""
    sizes = np.array([[1.0], [1.5], [2.0]])
    third = 0.1 * sizes[:, 0] ** growth
    extents = np.column_stack([np.ones(3), [0.9, 0.8, 0.7], third, third / [2.0, 9.0, 12.0]])
    assert 1 + gaps_after(extents, sizes, True).argmax() == (2 if growth > 1.0 else 3)
    assert 1 + gaps_after(extents, sizes, False).argmax() == 3
    assert 1 + gaps_after(extents[:1], sizes[:1], True).argmax() == 2


@pytest.mark.parametrize(("n", "D"), [(6, 3), (20, 3), (100, 3), (1000, 7), (10, 6)])
def test_scales_fit_the_samples(n, D):
    assert scales(n, D)
    assert all(1 <= k <= max(n / 6, min(2 * D + 2, n - 1)) for k in scales(n, D))


def test_the_finest_scale_is_for_samples_that_allow_a_wider_one():
    assert scales(1000, 7, finest=True) == [9, *scales(1000, 7)]
    assert scales(40, 7, finest=True) == scales(40, 7)


@pytest.mark.parametrize("seed", range(3))
def test_little_room_in_many_coordinates_is_no_dimension_more(seed):
    """Where a sheet of three dimensions bends in all the others, only the nearest samples show it flat."""
    x = clouds.normalised(clouds.sheet(7, 3)(400, np.random.default_rng(seed)))
    assert choose_dimension(x, None, 0)[0] == 3


def test_of_few_recordings_the_smallest_well_supported_dimension_is_taken():
    """Curves that differ a little are still curves, though together they make a narrow sheet."""
    t = np.linspace(0, 1, 100)
    curves = [np.column_stack([t, np.sin(3 * t), 0.12 * i * np.ones(100)]) for i in range(5)]
    x = clouds.normalised(np.vstack(curves))
    few, trials = choose_dimension(x, np.repeat(np.arange(5), 100), seed=0)
    assert few == 1
    assert few <= choose_dimension(x, None, seed=0)[0]
    assert [t.setting for t in trials] == ["d = 1", "d = 2"]


def recordings(draw, count):
    """Recordings (count × 100, D) drawn one by one, normalised, and which is which."""
    return clouds.normalised(np.vstack([draw() for _ in range(count)])), np.repeat(np.arange(count), 100)


@pytest.mark.parametrize("count", [3, 5, 10, 20])
@pytest.mark.parametrize("spread", [0.02, 0.1])
@pytest.mark.parametrize("seed", range(3))
def test_recordings_that_spread_to_all_sides_are_of_one_curve(count, spread, seed):
    """Few of them lie in a space of few dimensions, whichever they are."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, 100)[:, None]
    curve = np.sin(3 * t * rng.normal(size=7) + rng.uniform(0, 6, 7))
    ways = np.hstack([1 - t, t, np.sin(np.pi * t)])
    x, groups = recordings(lambda: curve + spread * ways @ rng.normal(size=(3, 7)), count)
    assert choose_dimension(x, groups, 0)[0] == 1


@pytest.mark.parametrize("count", [20, 40])
@pytest.mark.parametrize("seed", range(3))
def test_recordings_that_cover_a_sheet_are_of_a_sheet(count, seed):
    rng = np.random.default_rng(seed)
    t = np.linspace(-1, 1, 100)

    def stroke():
        y = rng.uniform(-1, 1) + 0.3 * rng.normal() * t
        return np.column_stack([t, y, 0.3 * np.sin(2 * t + y), 0.3 * np.cos(2 * y)]) + 0.002 * rng.normal(
            size=(100, 4)
        )

    x, groups = recordings(stroke, count)
    assert choose_dimension(x, groups, 0)[0] == 2


def test_two_coordinates_leave_only_curves():
    x = np.random.default_rng(0).normal(size=(100, 2))
    assert choose_dimension(x, None, 0)[0] == 1
