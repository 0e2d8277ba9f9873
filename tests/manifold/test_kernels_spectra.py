"""Eigenvectors of many small matrices against NumPy's."""

import numpy as np
import pytest

from skillfold.manifold.kernels.spectra import principal_rows


def turned(values, rng):
    """Symmetric matrices (M, D, D) with eigenvalues (M, D)."""
    frames = np.linalg.qr(rng.normal(size=(*values.shape, values.shape[1])))[0]
    matrices = np.einsum("mac,mc,mbc->mab", frames, values, frames)
    return (matrices + np.swapaxes(matrices, 1, 2)) / 2


def check(matrices):
    """Rows are orthonormal, turn the matrices into diagonals, and these are the eigenvalues in descending order."""
    rows = principal_rows(matrices)
    expected = np.linalg.eigvalsh(matrices)[:, ::-1]
    size = np.abs(expected).max(1)[:, None, None]
    diagonal = rows @ matrices @ np.swapaxes(rows, 1, 2)
    assert (np.abs(diagonal - expected[:, :, None] * np.eye(matrices.shape[1])) <= 1e-13 * size).all()
    unit = np.broadcast_to(np.eye(matrices.shape[1]), matrices.shape)
    np.testing.assert_allclose(rows @ np.swapaxes(rows, 1, 2), unit, atol=1e-13)
    return rows


@pytest.mark.parametrize("D", [1, 2, 3, 4, 7, 12, 30])
def test_rows_are_eigenvectors(D):
    rng = np.random.default_rng(D)
    matrices = turned(rng.normal(size=(50, D)) ** 2 * 10.0 ** rng.uniform(-8, 8, (50, 1)), rng)
    rows = check(matrices)
    expected = np.swapaxes(np.linalg.eigh(matrices)[1][:, :, ::-1], 1, 2)
    gaps = np.linalg.eigvalsh(matrices)
    clear = (np.diff(gaps, axis=1) > 1e-3 * gaps[:, -1:]).all(1)
    signs = np.sign((rows * expected).sum(2, keepdims=True))
    np.testing.assert_allclose((rows * signs)[clear], expected[clear], atol=1e-9)


@pytest.mark.parametrize("D", [2, 3, 6, 12])
def test_equal_vanishing_and_negative_eigenvalues(D):
    rng = np.random.default_rng(D)
    values = np.zeros((5, D))
    values[1] = 1.0
    values[2, 0] = 3.0
    values[3] = np.where(np.arange(D) < 2, 1.0, 1e-9)
    values[4] = rng.normal(size=D)
    check(turned(values, rng))
    check(np.array([np.zeros((D, D)), np.eye(D), np.diag(np.arange(D, dtype=float)), np.ones((D, D))]))


def test_nothing_and_tiny_matrices():
    assert principal_rows(np.empty((0, 3, 3))).shape == (0, 3, 3)
    check(1e-60 * turned(np.random.default_rng(0).normal(size=(5, 4)) ** 2, np.random.default_rng(1)))
