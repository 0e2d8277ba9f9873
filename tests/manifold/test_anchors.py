"""Local surfaces: exact on polynomials, equal to NumPy's least squares, and what is held out is held out."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from manifold import twins
from skillfold.experiments.point_sets import draw_circle, draw_sphere
from skillfold.manifold.anchors import fit_surfaces, held_out_residuals, nearest_others
from skillfold.manifold.polynomials import design, monomials


def rotation(D, rng):
    return np.linalg.qr(rng.normal(size=(D, D)))[0]


def heights(surfaces, i, points):
    """Height of the i-th surface above its own tangent plane, minus that of the points; (n, D - d)."""
    local = points @ surfaces.frames[i].T
    values = design(local[:, : surfaces.dim] / surfaces.radii[i], monomials(surfaces.dim, degree_of(surfaces)))
    return local[:, surfaces.dim :] - values @ surfaces.coefficients[i]


def degree_of(surfaces):
    degree = 0
    while len(monomials(surfaces.dim, degree).parents) < surfaces.coefficients.shape[1]:
        degree += 1
    return degree


def fit_offsets(offsets, dim, degree):
    """Surfaces through offsets (M, k, D) from their centres."""
    M, k, D = offsets.shape
    neighbours = np.arange(M * k).reshape(M, k)
    return fit_surfaces(offsets.reshape(M * k, D), np.zeros((M, D)), neighbours, dim, degree)


@pytest.mark.parametrize("D", [2, 3, 5])
def test_a_plane_is_found_exactly(D):
    rng = np.random.default_rng(D)
    turn = rotation(D, rng)
    offsets = rng.uniform(-1, 1, (6, 30, D - 1)) @ turn[:, : D - 1].T + 0.3 * turn[:, -1]
    surfaces = fit_offsets(offsets, D - 1, 1)
    for i in range(6):
        np.testing.assert_allclose(heights(surfaces, i, offsets[i]), 0.0, atol=1e-7)
        np.testing.assert_allclose(surfaces.shifts[i], 0.3 * turn[:, -1], atol=1e-7)
        np.testing.assert_allclose(np.abs(surfaces.frames[i, -1] @ turn[:, -1]), 1.0, atol=1e-12)


@pytest.mark.parametrize(("d", "D", "degree"), [(1, 2, 2), (1, 3, 4), (2, 3, 2), (2, 4, 3)])
def test_polynomial_graphs_tangent_at_the_centre_are_found(d, D, degree):
    """Over its own tangent plane such a sheet is a polynomial: only the ridge is left of the residual."""
    rng = np.random.default_rng(10 * d + D)
    table = monomials(d, degree)
    coefficients = 0.3 * rng.normal(size=(len(table.parents), D - d))
    coefficients[: 1 + d] = 0.0
    u = rng.uniform(-0.5, 0.5, (1, 80, d))
    u = np.concatenate([u, -u], axis=1)
    turn = rotation(D, rng)
    offsets = np.concatenate([u, design(u, table) @ coefficients], axis=2) @ turn.T
    surfaces = fit_offsets(offsets, d, degree)
    tangents = turn[:, :d]
    assert np.linalg.norm(surfaces.tangents[0] - tangents @ (tangents.T @ surfaces.tangents[0])) < 5e-2
    np.testing.assert_allclose(surfaces.shifts, 0.0, atol=2e-3)
    error = np.abs(heights(surfaces, 0, offsets[0])).max()
    assert error < 0.05 * np.abs(heights(fit_offsets(offsets, d, 1), 0, offsets[0])).max()


@pytest.mark.parametrize(("d", "D", "degree"), [(1, 2, 2), (2, 3, 3), (2, 5, 2)])
def test_coefficients_are_weighted_least_squares(d, D, degree):
    """Against np.linalg.lstsq in the same frame."""
    rng = np.random.default_rng(d + D)
    offsets = rng.normal(size=(4, 60, D)) * np.r_[np.ones(d), 0.1 * np.ones(D - d)]
    surfaces = fit_offsets(offsets, d, degree)
    for i in range(4):
        local = offsets[i] @ surfaces.frames[i].T
        weights = twins.wendland(np.linalg.norm(offsets[i], axis=1) / surfaces.radii[i])
        root = np.sqrt(weights)[:, None]
        rows = np.prod((local[:, None, :d] / surfaces.radii[i]) ** twins.powers(d, degree), axis=2)
        expected = np.linalg.lstsq(rows * root, local[:, d:] * root, rcond=None)[0]
        # The ridge pulls weakly determined high powers a little.
        np.testing.assert_allclose(surfaces.coefficients[i], expected, atol=1e-5)


def test_further_columns_count_for_the_distances_alone():
    """Weighted least squares again, with weights of the distances in all columns."""
    rng = np.random.default_rng(4)
    d, D, k = 2, 3, 50
    offsets = rng.normal(size=(k, D)) * [1.0, 1.0, 0.1]
    further = rng.normal(size=(k, 4))
    start = np.eye(D)[None]
    samples = np.hstack([offsets, further])
    surfaces = fit_surfaces(samples, np.zeros((1, D + 4)), np.arange(k)[None], d, 2, start=start)
    np.testing.assert_array_equal(start[0], np.eye(D))
    distances = np.linalg.norm(samples, axis=1)
    assert surfaces.radii[0] == pytest.approx(1.05 * distances.max(), rel=1e-12)
    local = offsets @ surfaces.frames[0].T
    root = np.sqrt(twins.wendland(distances / surfaces.radii[0]))[:, None]
    rows = np.prod((local[:, None, :d] / surfaces.radii[0]) ** twins.powers(d, 2), axis=2)
    expected = np.linalg.lstsq(rows * root, local[:, d:] * root, rcond=None)[0]
    np.testing.assert_allclose(surfaces.coefficients[0], expected, atol=1e-5)


def test_frames_are_orthonormal_and_tangents_agree_with_the_slope():
    rng = np.random.default_rng(0)
    x = draw_sphere(400, rng)
    neighbours = KDTree(x).query(x[:50], 30)[1]
    surfaces = fit_surfaces(x, x[:50], neighbours, 2, 2)
    gram = surfaces.frames @ np.swapaxes(surfaces.frames, 1, 2)
    np.testing.assert_allclose(gram, np.broadcast_to(np.eye(3), gram.shape), atol=1e-12)
    assert np.abs(np.einsum("mc,mca->ma", x[:50], surfaces.tangents)).max() < 5e-3  # tangents at right angles to x
    # Turned to their own surface: hardly any slope is left.
    assert np.abs(surfaces.coefficients[:, 1:3] / surfaces.radii[:, None, None]).max() < 1e-2


@pytest.mark.parametrize(("d", "D", "degree", "k"), [(1, 2, 2, 9), (2, 3, 3, 40), (2, 5, 1, 30), (3, 4, 2, 20)])
def test_fits_are_those_of_their_twin(d, D, degree, k):
    rng = np.random.default_rng(d + D)
    offsets = rng.normal(size=(3, k, D)) * np.r_[np.ones(d), 0.1 * np.ones(D - d)]
    surfaces = fit_offsets(offsets, d, degree)
    terms = len(twins.powers(d, min(degree, 2)))
    for i in range(3):
        frame, radius, coefficients = twins.local_fit(offsets[i], d, twins.powers(d, degree), terms)
        signs = np.sign((frame * surfaces.frames[i]).sum(1))  # of principal directions, which have none
        np.testing.assert_allclose(surfaces.frames[i] * signs[:, None], frame, atol=1e-6)
        assert surfaces.radii[i] == pytest.approx(radius, rel=1e-12)
        powers = twins.powers(d, degree)
        flips = np.prod(signs[:d] ** powers, axis=1)[:, None] * signs[d:]
        np.testing.assert_allclose(surfaces.coefficients[i] * flips, coefficients, atol=1e-5)


def test_threads_change_nothing():
    x = draw_sphere(300, np.random.default_rng(0))
    neighbours = KDTree(x).query(x, 20)[1]
    one, two = (fit_surfaces(x, x, neighbours, 2, 2, jobs) for jobs in (1, 2))
    np.testing.assert_array_equal(one.coefficients, two.coefficients)
    np.testing.assert_array_equal(one.frames, two.frames)
    others = nearest_others(x, np.arange(300), 20, None)
    np.testing.assert_array_equal(*(held_out_residuals(x, np.arange(300), others, 2, [1, 2], j) for j in (1, 2)))


def test_degrees_together_are_degrees_alone():
    x = draw_sphere(300, np.random.default_rng(0))
    others = nearest_others(x, np.arange(100), 24, None)
    together = held_out_residuals(x, np.arange(100), others, 2, [1, 2, 4])
    for degree, errors in zip((1, 2, 4), together, strict=True):
        alone = held_out_residuals(x, np.arange(100), others, 2, [degree])[0]
        np.testing.assert_allclose(errors, alone, rtol=1e-9, atol=1e-12)


def test_too_few_and_aligned_neighbours_stay_finite():
    offsets = np.zeros((2, 4, 3))
    offsets[:, :, 0] = np.arange(4)
    surfaces = fit_offsets(offsets, 2, 3)
    assert np.isfinite(surfaces.coefficients).all()
    np.testing.assert_allclose(surfaces.shifts, 0.0, atol=1e-12)


@pytest.mark.parametrize("groups", [None, np.repeat(np.arange(4), 25)])
def test_nearest_others_leave_out_what_they_must(groups):
    rng = np.random.default_rng(0)
    x = rng.normal(size=(100, 3))
    chosen = np.array([3, 30, 31, 99])
    found = nearest_others(x, chosen, 7, groups)
    for i, row in zip(chosen, found, strict=True):
        allowed = np.flatnonzero(np.arange(100) != i if groups is None else groups != groups[i])
        expected = allowed[np.linalg.norm(x[allowed] - x[i], axis=1).argsort()[:7]]
        np.testing.assert_array_equal(row, expected)


@pytest.mark.parametrize(
    ("draw", "d", "degree", "largest"),
    [(draw_sphere, 2, 2, 5e-3), (draw_sphere, 2, 4, 1e-3), (draw_circle, 1, 3, 1e-4)],
)
def test_held_out_residuals_of_true_surfaces_are_small(draw, d, degree, largest):
    x = draw(500, np.random.default_rng(0))
    chosen = np.arange(0, 500, 5)
    others = nearest_others(x, chosen, 30, None)
    residuals = held_out_residuals(x, chosen, others, d, [degree])[0]
    assert residuals.shape == (100,)
    assert np.median(residuals) < largest


def test_held_out_residuals_are_of_the_surface_of_a_sample_beside():
    """One sample by hand: of the nearest quarter of others, the one nearest along the plane, fitted without it."""
    rng = np.random.default_rng(1)
    x = draw_sphere(200, rng) + 0.01 * rng.normal(size=(200, 3))
    others = nearest_others(x, np.array([17]), 25, None)
    normal = fit_surfaces(x, x[others[:, 0]], others, 2, 1).frames[0, 2]
    offsets = x[others[0, :6]] - x[17]
    beside = others[:, np.linalg.norm(offsets - np.outer(offsets @ normal, normal), axis=1).argmin()]
    surfaces = fit_surfaces(x, x[beside], others, 2, 2)
    expected = np.linalg.norm(heights(surfaces, 0, x[[17]] - x[beside]))
    # Its frame is turned once less.
    assert held_out_residuals(x, np.array([17]), others, 2, [2])[0, 0] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("k", [50, 100, 200])
@pytest.mark.parametrize("seed", range(3))
def test_held_out_residuals_are_no_smaller_than_noise_wider_than_samples_lie_apart(k, seed):
    """The nearest sample shares it, and its surface would predict a sample too well."""
    rng = np.random.default_rng(seed)
    u = rng.uniform(-1, 1, (3000, 2))
    x = np.column_stack([u, 0.2 * u[:, 0] ** 2]) + 0.04 * rng.normal(size=(3000, 3))
    chosen = np.flatnonzero(np.abs(u).max(1) < 0.8)[:1000]
    residuals = held_out_residuals(x, chosen, nearest_others(x, chosen, k, None), 2, [2])[0]
    assert np.sqrt((residuals**2).mean()) > 0.04 * 0.98


def test_held_out_residuals_see_the_noise():
    rng = np.random.default_rng(2)
    x = draw_sphere(1000, rng) + 0.02 * rng.normal(size=(1000, 3))
    residuals = held_out_residuals(x, np.arange(200), nearest_others(x, np.arange(200), 60, None), 2, [2])[0]
    assert np.sqrt((residuals**2).mean()) == pytest.approx(0.02, rel=0.25)
