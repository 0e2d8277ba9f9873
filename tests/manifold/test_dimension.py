import numpy as np
import pytest

from manifold import clouds
from skillfold.experiments.upright import JACO, upright_poses
from skillfold.manifold.dimension import choose_dimension, gaps_after, local_extents, scales

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
        found, trials = choose_dimension(x, few_recordings=False, seed=0)
        assert found == dim
        assert [t.setting for t in trials if t.chosen] == [f"d = {dim}"]


@pytest.mark.parametrize("name", ["circle", "sphere", "two circles"])
def test_rigid_motions_and_order_do_not_matter(name):
    draw, dim = KNOWN[name]
    rng = np.random.default_rng(0)
    x = draw(400, rng)
    moved = clouds.rotated(x, rng)[rng.permutation(400)] * 50.0 - 3.0
    assert choose_dimension(moved, False, 0)[0] == dim


def test_extents_are_those_of_the_local_covariance():
    """With all samples as neighbours they are the singular values themselves, in the root mean square."""
    rng = np.random.default_rng(0)
    x = rng.normal(size=(40, 3)) * [1.0, 0.5, 0.01]
    values = np.linalg.svd(x - x.mean(0), compute_uv=False)
    np.testing.assert_allclose(local_extents(x, 39, 0), values / np.sqrt(40), rtol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_bends_are_no_dimension(seed):
    """The upright tool of a six-joint arm: wide neighbourhoods are as thick as they bend."""
    poses = clouds.normalised(upright_poses(JACO, 1000, np.random.default_rng(seed)))
    assert choose_dimension(poses, False, 0)[0] == 4


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
    assert choose_dimension(x, False, 0)[0] == 3


def test_of_few_recordings_the_smallest_well_supported_dimension_is_taken():
    """Curves that differ a little are still curves, though together they make a narrow sheet."""
    t = np.linspace(0, 1, 100)
    curves = [np.column_stack([t, np.sin(3 * t), 0.12 * i * np.ones(100)]) for i in range(5)]
    x = clouds.normalised(np.vstack(curves))
    few, trials = choose_dimension(x, few_recordings=True, seed=0)
    assert few == 1
    assert few <= choose_dimension(x, few_recordings=False, seed=0)[0]
    assert [t.setting for t in trials] == ["d = 1", "d = 2"]


def test_two_coordinates_leave_only_curves():
    x = np.random.default_rng(0).normal(size=(100, 2))
    assert choose_dimension(x, False, 0)[0] == 1
