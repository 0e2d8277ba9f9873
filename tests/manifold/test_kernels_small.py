"""Kernels of small linear algebra against NumPy; and that no kernel goes without a twin."""

from importlib import import_module
from pathlib import Path
from re import search

import numpy as np
import pytest

from manifold import twins
from manifold.kernels import small

MODULES = [
    "small",
    "neighbours",
    "tangents",
    "surface",
    "scratch",
    "newton",
    "projection",
    "leaf",
    "judging",
    "acceleration",
    "geodesic",
    "walking",
    "trees",
    "pushes",
    "detours",
    "springs",
]
SIZES = [(1, 2), (1, 5), (2, 3), (3, 7), (4, 4)]


@pytest.fixture(params=SIZES, ids=str)
def rows_and_rng(request):
    rng = np.random.default_rng(request.param[1])
    d, D = request.param
    return np.ascontiguousarray(np.linalg.qr(rng.normal(size=(D, d)))[0].T), rng


@pytest.mark.parametrize("name", MODULES)
def test_every_kernel_is_tested(name):
    module = import_module(f"skillfold.manifold.kernels.{name}")
    kernels = {
        n for n, f in vars(module).items() if hasattr(f, "py_func") and f.py_func.__module__ == module.__name__
    }
    text = (Path(__file__).parent / f"test_kernels_{name}.py").read_text(encoding="utf-8")
    assert kernels
    assert {kernel for kernel in kernels if not search(rf"\b{name}(_memory)?\.{kernel}\(", text)} == set()


def test_norm(rows_and_rng):
    vector = rows_and_rng[1].normal(size=7)
    assert small.norm(vector) == pytest.approx(np.linalg.norm(vector), abs=1e-14)


def test_components(rows_and_rng):
    rows, rng = rows_and_rng
    vector, out = rng.normal(size=rows.shape[1]), np.empty(len(rows))
    small.components(rows, vector, out)
    np.testing.assert_allclose(out, rows @ vector, atol=1e-14)


def test_square_and_copy(rows_and_rng):
    vector = rows_and_rng[1].normal(size=7)
    out = np.empty(7)
    small.copy(vector, out)
    np.testing.assert_array_equal(out, vector)
    assert small.square(vector) == pytest.approx((vector**2).sum(), rel=1e-14)


def test_clear(rows_and_rng):
    """Row by row, what lies along those before goes; what is left is told."""
    rows, rng = rows_and_rng
    basis = np.vstack([rows, rng.normal(size=rows.shape[1])])
    last = basis[-1].copy()
    left = small.clear(basis, len(rows))
    expected = last - rows.T @ rows @ last
    np.testing.assert_allclose(basis[-1], expected, atol=1e-13)
    assert left == pytest.approx((expected**2).sum(), abs=1e-13)


def test_take_off(rows_and_rng):
    """What is taken off and what is left are the whole, by Pythagoras."""
    rows, rng = rows_and_rng
    basis = np.vstack([rows, rng.normal(size=rows.shape[1])])
    last = basis[-1].copy()
    assert small.take_off(basis, len(rows)) == pytest.approx(((rows @ last) ** 2).sum(), rel=1e-12)
    np.testing.assert_allclose(basis[-1], last - rows.T @ rows @ last, atol=1e-13)


@pytest.mark.parametrize("share", [1.0, 1e-6, 0.0])
def test_mend(rows_and_rng, share):
    """A row that is nearly along those before is kept, one that vanishes is an axis; both across those before."""
    rows, rng = rows_and_rng
    across = rng.normal(size=rows.shape[1])
    across -= rows.T @ rows @ across
    if len(rows) == rows.shape[1]:
        rows, across = rows[:-1], rows[-1]
    basis = np.vstack([rows, share * across])
    left, kept = small.mend(basis, len(rows), 1.0)
    assert kept == (share > 0.0)
    assert left == pytest.approx((basis[-1] ** 2).sum(), rel=1e-9)
    np.testing.assert_allclose(rows @ basis[-1], 0.0, atol=1e-14)
    if kept:
        np.testing.assert_allclose(basis[-1], share * across, atol=1e-14)


def test_keep_along(rows_and_rng):
    rows, rng = rows_and_rng
    vector = rng.normal(size=rows.shape[1])
    found = vector.copy()
    small.keep_along(rows, found, np.empty(len(rows)))
    np.testing.assert_allclose(found, rows.T @ rows @ vector, atol=1e-14)


@pytest.mark.parametrize(("d", "D"), SIZES)
@pytest.mark.parametrize("seed", range(5))
def test_orthonormalise(d, D, seed):
    rng = np.random.default_rng(seed)
    basis = rng.normal(size=(d, D)) * 10.0 ** rng.uniform(-8, 8, (d, 1))
    expected, full_rank = twins.orthonormalise(basis)
    assert small.orthonormalise(basis) == full_rank
    np.testing.assert_allclose(basis, expected, atol=1e-10)
    np.testing.assert_allclose(basis @ basis.T, np.eye(d), atol=1e-14)


@pytest.mark.parametrize(
    "basis",
    [
        [[0.0, 0.0, 0.0]],
        [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
        [[1.0, 2.0, 3.0], [-2.0, -4.0, -6.0], [0.5, 1.0, 1.5]],
        [[0.0, 3.0, 0.0], [0.0, 1.0, 0.0]],
    ],
)
def test_orthonormalise_puts_axes_in_for_dependent_rows(basis):
    basis = np.array(basis)
    expected, full_rank = twins.orthonormalise(basis)
    assert not full_rank
    assert not small.orthonormalise(basis)
    np.testing.assert_allclose(basis, expected, atol=1e-12)
    np.testing.assert_allclose(basis @ basis.T, np.eye(len(basis)), atol=1e-14)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_orthonormalise_ends_on_values_that_are_not_finite(value):
    basis = np.array([[1.0, value, 0.0], [0.0, 1.0, 0.0]])
    assert not small.orthonormalise(basis)


@pytest.mark.parametrize("d", [1, 2, 3, 5])
@pytest.mark.parametrize("m", [1, 4])
def test_solve_in_place(d, m):
    rng = np.random.default_rng(10 * d + m)
    matrix, right = rng.normal(size=(d, d)), rng.normal(size=(d, m))
    matrix[0, 0] = 0.0 if d > 1 else matrix[0, 0]  # pivots must be looked for
    expected = np.linalg.solve(matrix, right)
    small.solve_in_place(matrix.copy(), right)
    np.testing.assert_allclose(right, expected, atol=1e-10)
