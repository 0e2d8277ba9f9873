"""Phases at which demonstrations are read: laws, curves known to be late, curves that say nothing."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skillfold.manifold.route_phases import at_phases, registered
from skillfold.motion import Array

SHARE = np.linspace(0.0, 1.0, 101)


def wave(share: Array, lift: float = 1.0) -> Array:
    """A curve (n_phases, 2) of length about 3, of unit size."""
    return np.column_stack([2.0 * share - 1.0, lift * np.sin(np.pi * share) ** 2])


def late(by: float) -> Array:
    """The same curve, half-way late by a share of it, or early."""
    return wave(SHARE - by * np.sin(np.pi * SHARE) ** 2)


def spread(curves: Array) -> float:
    return float(np.sqrt(curves.var(axis=0).sum(axis=1).mean()))


def test_curves_that_are_late_are_read_later() -> None:
    curves = np.stack([late(by) for by in (-0.08, -0.02, 0.03, 0.07)])
    assert spread(registered(curves)) < 0.4 * spread(curves)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 6), st.integers(1, 4))
def test_curves_keep_ends_and_order(seed: int, n: int, n_dims: int) -> None:
    rng = np.random.default_rng(seed)
    curves = rng.normal(size=(n, 1, n_dims)) + np.cumsum(rng.normal(0.05, 0.1, (n, 101, n_dims)), axis=1)
    # Read along, a coordinate that tells the share shows at which shares curves are read.
    read = registered(np.concatenate([curves, np.tile(SHARE[:, None], (n, 1, 1))], axis=2))
    assert np.array_equal(read[:, [0, -1], :-1], curves[:, [0, -1]])
    assert (np.diff(read[..., -1], axis=1) >= -1e-15).all()  # but for rounding
    assert np.allclose(read[..., -1].mean(axis=0), SHARE, atol=0.05)


def test_turned_and_reversed_curves_are_read_alike() -> None:
    curves = np.stack([late(-0.05), late(0.02), 1.1 * late(0.06)])
    turn, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(2, 2)))
    np.testing.assert_allclose(registered(curves @ turn), registered(curves) @ turn, atol=1e-12)
    np.testing.assert_allclose(registered(curves[:, ::-1])[:, ::-1], registered(curves), atol=1e-9)


@pytest.mark.parametrize("curves", [np.stack([wave(SHARE)] * 3), np.ones((3, 101, 2)), np.zeros((2, 9, 1))])
def test_nothing_to_learn_changes_nothing(curves: Array) -> None:
    np.testing.assert_allclose(registered(curves), curves, atol=1e-12)


def test_parallel_curves_stay() -> None:
    """What lies across the way is no reason to be early or late."""
    straight = np.column_stack([2.0 * SHARE - 1.0, np.zeros(101)])
    bulge = np.column_stack([np.zeros(101), 0.1 * np.sin(np.pi * SHARE)])
    curves = np.stack([straight, straight + bulge, straight - bulge])
    assert np.abs(registered(curves) - curves).max() < 5e-3


def test_several_ways_say_next_to_nothing() -> None:
    one, other = late(0.05), late(-0.05) * [1.0, -1.0]
    alike = np.stack([late(0.05), late(-0.05)])
    ways = np.stack([one, other])
    moved = [np.abs(registered(curves) - curves)[:, 20:80, 0].mean() for curves in (alike, ways)]
    assert moved[1] < 0.2 * moved[0]


def test_phases_between_are_interpolated() -> None:
    curves = np.stack([wave(SHARE), 2.0 * wave(SHARE)])
    read = at_phases(curves, np.array([[0.0, 0.505, 1.0]] * 2))
    np.testing.assert_allclose(read[1], 2.0 * read[0])
    np.testing.assert_allclose(read[0, 1], curves[0, 50:52].mean(axis=0))
