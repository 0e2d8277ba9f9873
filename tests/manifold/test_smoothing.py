"""Noisy samples are fitted more than once where that predicts left-out ones better, others never."""

import numpy as np
import pytest
from scipy.linalg import subspace_angles

from skillfold.experiments.point_sets import draw_plane, draw_sphere, plane_distance
from skillfold.manifold.shapes import Chosen, Shape
from skillfold.manifold.smoothing import TURNED, Serving, denoised, held_out_squares, tilts

QUADRATIC = Shape(2, 54)
SCALE = 2.45  # rms radius of the plane set


def judged(samples, *shapes):
    """One shape for all, or the first for the lower half and the second for the upper one."""
    n = len(samples)
    taken = (samples[:, 2] > 0).astype(np.int64) if len(shapes) > 1 else np.zeros(n, np.int64)
    return Chosen(list(shapes), taken, np.ones(n), np.arange(n), np.arange(n), [])


def noisy_plane(seed, n=1000, noise=0.025):
    rng = np.random.default_rng(seed)
    return (draw_plane(n, rng) + noise * rng.normal(size=(n, 3))) / SCALE


def smoothed(samples, *shapes, unordered=True):
    return denoised(samples, np.arange(len(samples)), judged(samples, *shapes), 2, unordered, 0, 1)


@pytest.mark.parametrize(("d", "D"), [(1, 2), (2, 3), (2, 5)])
def test_tilts_are_apart_by_the_angles_between_tangents(d, D):
    rng = np.random.default_rng(d + D)
    tangents = np.linalg.qr(rng.normal(size=(2, D, d)))[0]
    a, b = tilts(tangents)
    expected = TURNED**2 * (np.sin(subspace_angles(*tangents)) ** 2).sum()
    assert ((a - b) ** 2).sum() == pytest.approx(expected, rel=1e-9)


def test_noise_is_smoothed_again_where_a_surface_is_folded():
    samples = noisy_plane(0)
    again, _, trials = smoothed(samples, QUADRATIC)
    once, _, _ = smoothed(samples, QUADRATIC, unordered=False)
    assert [t.setting for t in trials if t.chosen] in (["2 ×"], ["3 ×"])
    errors = [np.median(plane_distance(SCALE * points)) for points in (once, again)]
    assert errors[1] < 0.9 * errors[0]


def test_anchors_lie_on_their_own_surfaces():
    samples = noisy_plane(1)
    serving = Serving([QUADRATIC], np.zeros(len(samples), np.int64), 2, 1)
    *_, (points, local) = serving.fits(samples, 1)
    first = serving.fit(samples, samples)
    np.testing.assert_allclose(points, samples + first.shifts)
    assert np.linalg.norm(local.shifts, axis=1).mean() < np.linalg.norm(first.shifts, axis=1).mean()


@pytest.mark.parametrize("shapes", [(Shape(3, 16),), (Shape(2, 9), Shape(3, 24))])
def test_shapes_that_follow_the_samples_are_fitted_once(shapes):
    samples = draw_sphere(400, np.random.default_rng(0))
    anchors, local, trials = smoothed(samples, *shapes)
    assert trials == []
    assert local.coefficients.shape[1] == 10
    np.testing.assert_allclose(np.linalg.norm(anchors, axis=1), 1.0, atol=2e-2)


@pytest.mark.parametrize(
    ("shape", "n", "noisy"), [(Shape(2, 54), 500, True), (Shape(2, 54), 400, False), (Shape(3, 30), 500, False)]
)
def test_neighbourhoods_that_average_and_are_local_tell_of_noise(shape, n, noisy):
    assert Serving([Shape(1, 10), shape], np.repeat([0, 1], [n // 3, n - n // 3]), 2, 1).noisy == noisy


def test_some_samples_alone_and_recordings_are_fitted_once():
    samples = noisy_plane(2)
    assert Serving([QUADRATIC], np.zeros(1000, np.int64), 2, 1).noisy
    assert smoothed(samples, QUADRATIC, unordered=False)[2] == []
    some = denoised(samples, np.arange(0, 1000, 2), judged(samples, QUADRATIC), 2, True, 0, 1)
    assert some[0].shape == (500, 3)
    assert some[2] == []


def test_what_would_be_rounded_off_is_fitted_once():
    """Without noise, a neighbourhood that is too large is too large again."""
    rng = np.random.default_rng(3)
    angle = rng.uniform(0, 2 * np.pi, (400, 2))
    samples = np.column_stack([np.cos(angle[:, 0]), np.sin(angle[:, 0]), np.cos(angle[:, 1]), np.sin(angle[:, 1])])
    trials = smoothed(samples, Shape(2, 50))[2]
    assert [t.setting for t in trials if t.chosen] == ["1 ×"]


def test_left_out_samples_are_judged_by_surfaces_that_never_saw_them():
    """With noise alone, what is left of samples that were fitted is less."""
    rng = np.random.default_rng(5)
    samples = np.column_stack([rng.uniform(-1, 1, (600, 2)), 0.05 * rng.normal(size=600)])
    serving = Serving([QUADRATIC], np.zeros(600, np.int64), 2, 1)
    squares = held_out_squares(serving, samples, 0)
    assert len(squares) == 3
    assert squares[0].mean() > (serving.fit(samples, samples).shifts ** 2).sum(1).mean()
