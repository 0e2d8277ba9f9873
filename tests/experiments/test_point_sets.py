"""The surfaces' equations, gradients and closest distances against independent computations."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import approx_fprime, minimize

from skillfold.errors import InputError
from skillfold.experiments import projection
from skillfold.experiments.point_sets import CIRCLE, PLANE, SETS, SPHERE, plane_gradient
from skillfold.experiments.rows import Settings


@pytest.mark.parametrize("kind", SETS, ids=lambda kind: kind.name)
def test_drawn_samples_lie_on_the_surface(kind):
    samples = kind.samples(500, np.random.default_rng(0), None)
    assert samples.shape == (500, 3)
    assert np.abs(kind.residual(samples)).max() < 1e-10
    assert kind.distance(samples).max() < 1e-7


def test_plane_gradient_is_the_derivative():
    q = np.array([0.4, -1.3, 0.8])
    np.testing.assert_allclose(plane_gradient(q), approx_fprime(q, PLANE.residual), atol=1e-6)


def test_closed_forms():
    x = np.array([[2.0, 0, 0], [0, 0, 0.5], [0.6, 0.8, 1.0]])
    np.testing.assert_allclose(SPHERE.distance(x), [1, 0.5, np.sqrt(2) - 1])
    np.testing.assert_allclose(CIRCLE.distance(x), [1, np.hypot(1, 0.5), 1])


def test_plane_distance_is_the_best_of_many_local_optimisations():
    rng = np.random.default_rng(2)
    states = rng.uniform([-2.09, -2.63, -2.63], [2.09, 2.63, 2.63], (12, 3))
    starts = PLANE.draw(20, rng)
    for state, distance in zip(states, PLANE.distance(states), strict=True):
        gaps = [_slsqp(state, start) for start in starts]
        assert distance == pytest.approx(min(gaps), abs=1e-5)


def test_missing_data_folder_is_named(tmp_path):
    with pytest.raises(InputError, match="circle_loop"):
        CIRCLE.samples(10, np.random.default_rng(0), tmp_path)


def test_published_samples_are_a_seeded_choice(tmp_path):
    (tmp_path / "ecomann").mkdir()
    np.save(tmp_path / "ecomann" / CIRCLE.file, CIRCLE.draw(50, np.random.default_rng(0)))
    first, again = (CIRCLE.samples(10, np.random.default_rng(3), tmp_path) for _ in range(2))
    np.testing.assert_array_equal(first, again)
    assert len(np.unique(first, axis=0)) == 10


def test_protocol_is_content_with_the_true_projection_of_the_sphere():
    skill = SimpleNamespace(dim=2, project=lambda x: x / np.linalg.norm(x, axis=1, keepdims=True))
    states = projection.box_states(SPHERE.draw(100, np.random.default_rng(0)), np.random.default_rng(1))
    rows = projection._rows(SPHERE, skill, states)
    assert [row.met for row in rows] == [True] * 4
    assert rows[2].measured == pytest.approx(1.0)


def test_protocol_sees_through_the_nearest_sample():
    def fit(samples):
        def nearest(x):
            return samples[np.linalg.norm(x[:, None] - samples, axis=2).argmin(axis=1)]

        return SimpleNamespace(dim=2, project=nearest)

    rows = projection.measure(Settings(0, fit=fit))
    worst = {row.name: row.met for row in rows if "95 %" in row.name}
    assert list(worst.values()) == [False, False, True], "a circle of 1000 samples leaves nothing to gain"


def test_raw_noise_measures_as_what_it_is():
    rng = np.random.default_rng(0)
    clean = PLANE.draw(4000, rng)
    sigma = projection.noise_of(clean)
    noisy = clean + sigma * rng.standard_normal(clean.shape)
    assert projection._noise_row(PLANE, noisy, sigma).measured == pytest.approx(projection.RAW_MEDIAN, abs=0.03)


def _slsqp(state, start):
    on_surface = {"type": "eq", "fun": PLANE.residual, "jac": plane_gradient}
    found = minimize(
        lambda q: 0.5 * np.sum((q - state) ** 2),
        start,
        jac=lambda q: q - state,
        constraints=[on_surface],
        method="SLSQP",
        options={"maxiter": 200, "ftol": 1e-12},
    )
    good = found.success and abs(PLANE.residual(found.x)) < 1e-8
    inside = (np.abs(np.cumsum(found.x)) < 2.0945).all()
    return np.linalg.norm(found.x - state) if good and inside else np.inf
