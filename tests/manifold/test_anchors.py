"""Local surfaces: exact on polynomials, equal to NumPy's least squares, and what is held out is held out."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from manifold import twins
from skillfold.experiments.point_sets import draw_circle, draw_sphere
from skillfold.manifold import anchors
from skillfold.manifold.anchors import fit_offsets, fit_surfaces, held_out_residuals, nearest_others, wendland
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


def test_wendland_is_one_at_the_centre_and_flat_zero_at_the_edge():
    r = np.array([0.0, 0.5, 1.0, 1.7])
    np.testing.assert_allclose(wendland(r), [1.0, 0.5**4 * 3.0, 0.0, 0.0])
    assert wendland(np.array(1 - 1e-4)) < 1e-14


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
    """Over its own tangent plane such a sheet is a polynomial: only the ridge of 1e-9 is left of the residual."""
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
        weights = wendland(np.linalg.norm(offsets[i], axis=1) / surfaces.radii[i])
        root = np.sqrt(weights)[:, None]
        rows = np.prod((local[:, None, :d] / surfaces.radii[i]) ** twins.powers(d, degree), axis=2)
        expected = np.linalg.lstsq(rows * root, local[:, d:] * root, rcond=None)[0]
        # The ridge of 1e-9 pulls weakly determined high powers a little.
        np.testing.assert_allclose(surfaces.coefficients[i], expected, atol=1e-5)


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


def test_batches_in_chunks_give_the_same(monkeypatch):
    rng = np.random.default_rng(0)
    x = draw_sphere(300, rng)
    neighbours = KDTree(x).query(x, 20)[1]
    whole = fit_surfaces(x, x, neighbours, 2, 2)
    monkeypatch.setattr(anchors, "CHUNK", 2000)
    parts = fit_surfaces(x, x, neighbours, 2, 2)
    np.testing.assert_allclose(parts.coefficients, whole.coefficients, atol=1e-12)
    np.testing.assert_allclose(parts.frames, whole.frames, atol=1e-12)


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
    residuals = held_out_residuals(x, chosen, others, d, degree)
    assert residuals.shape == (100,)
    assert np.median(residuals) < largest


def test_held_out_residuals_are_of_the_nearest_other_sample_s_surface():
    """One sample by hand: its nearest other sample's surface, fitted without it."""
    rng = np.random.default_rng(1)
    x = draw_sphere(200, rng) + 0.01 * rng.normal(size=(200, 3))
    others = nearest_others(x, np.array([17]), 25, None)
    surfaces = fit_surfaces(x, x[others[:, 0]], others, 2, 2)
    expected = np.linalg.norm(heights(surfaces, 0, x[[17]] - x[others[:, 0]]))
    assert held_out_residuals(x, np.array([17]), others, 2, 2)[0] == pytest.approx(expected, rel=1e-9)


def test_held_out_residuals_see_the_noise():
    rng = np.random.default_rng(2)
    x = draw_sphere(1000, rng) + 0.02 * rng.normal(size=(1000, 3))
    residuals = held_out_residuals(x, np.arange(200), nearest_others(x, np.arange(200), 60, None), 2, 2)
    assert np.sqrt((residuals**2).mean()) == pytest.approx(0.02, rel=0.25)
