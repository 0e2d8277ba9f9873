import numpy as np
import pytest

from skillfold.manifold.features import Features


@pytest.fixture(scope="module")
def samples():
    return np.random.default_rng(0).normal(size=(300, 3))


def test_values_are_normalised_gaussians(samples):
    features = Features.place(samples, 12, 0)
    raw = np.exp(-((samples[:, None] - features.centres) ** 2).sum(2) / (2 * features.width**2))
    np.testing.assert_allclose(features(samples), raw / raw.sum(1, keepdims=True), atol=1e-12)
    assert features(samples.reshape(10, 30, 3)).shape == (10, 30, 12)


def test_width_is_twice_the_mean_distance_between_nearest_centres(samples):
    features = Features.place(samples, 12, 0)
    gaps = np.linalg.norm(features.centres[:, None] - features.centres, axis=2)
    np.fill_diagonal(gaps, np.inf)
    assert features.width == pytest.approx(2.0 * gaps.min(1).mean(), rel=1e-12)


def test_far_away_the_nearest_centre_speaks(samples):
    features = Features.place(samples, 12, 0)
    x = np.array([1e6, 2e6, -3e6])
    values = features(x)
    assert np.isfinite(values).all()
    assert values[np.linalg.norm(features.centres - x, axis=1).argmin()] == pytest.approx(1.0, abs=1e-12)


def test_one_kernel_is_constant(samples):
    np.testing.assert_array_equal(Features.place(samples, 1, 0)(samples), np.ones((300, 1)))


def test_never_more_centres_than_distinct_samples():
    samples = np.repeat(np.eye(3), 5, axis=0)
    assert Features.place(samples, 10, 0).centres.shape == (3, 3)


def test_same_seed_same_bits_and_global_state_untouched(samples):
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    first, second = (Features.place(samples, 8, 3) for _ in range(2))
    np.testing.assert_array_equal(first.centres, second.centres)
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002


def test_many_samples_are_thinned_before_clustering():
    samples = np.random.default_rng(0).uniform(size=(20_000, 2))
    features = Features.place(samples, 16, 0)
    assert features.centres.shape == (16, 2)
    assert np.linalg.norm(samples[:, None] - features.centres, axis=2).min(1).max() < 2 * features.width
