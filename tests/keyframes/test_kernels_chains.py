"""Membership in chains of ellipsoids, part by part, against NumPy and SciPy."""

import numpy as np
import pytest

from keyframes import envelopes as twins
from manifold.kernels import callable_of
from skillfold.keyframes.kernels import chains as _chains

chains = callable_of(_chains)


@pytest.fixture(scope="module", params=[2, 3, 8])
def drawn(request):
    """A chain of so many stations, its table, and scaled coordinates in and about it."""
    rng = np.random.default_rng(5)
    chain = twins.random_region(rng, request.param)
    poses = twins.near(chain, 40, rng)
    return chain, chain.compiled().arguments, poses, chain.chart.to_chart(poses) * twins.UNITS


def segments_of(chain):
    return chain.compiled().owner.arrays[_chains.SEGMENTS]


def test_scaled(drawn):
    _, table, poses, ys = drawn
    out = np.empty(6)
    for pose, y in zip(poses, ys, strict=True):
        chains.scaled(pose, table, out)
        np.testing.assert_allclose(out, y, atol=1e-15)


def test_block_of_square_and_worse(drawn):
    chain, _, _, ys = drawn
    n = len(chain.covariances) - 1
    rows = segments_of(chain)
    for i, y in enumerate(ys):
        k, t = i % n, i / len(ys)
        s = (k + t) / n
        mean, sigma = twins.scaled_station(chain, s)
        v = (y - mean).reshape(2, 3)
        wanted = [v[b] @ np.linalg.solve(sigma[b], v[b]) for b in range(2)]
        blocks = [chains.block_of(rows[k], b, y) for b in range(2)]
        found = [chains.square(block, t) for block in blocks]
        np.testing.assert_allclose([value for value, _ in found], wanted, rtol=1e-8)
        h = 1e-6
        slopes = [(chains.square(b, t + h)[0] - chains.square(b, t - h)[0]) / (2 * h) for b in blocks]
        np.testing.assert_allclose([slope for _, slope in found], slopes, rtol=1e-6, atol=1e-6)
        assert chains.worse(*blocks, t) == (t, *found[int(np.argmax(wanted))])


def test_crossing():
    """Tangents of (t - 0.3)² meet half-way, those of |t - 0.3| at its tip, but never next to an end."""
    low, high = (0.0, 0.09, -0.6), (1.0, 0.49, 1.4)
    assert chains.crossing(low, high) == pytest.approx((0.5, -0.21))
    assert chains.crossing((0.0, 0.3, -1.0), (1.0, 0.7, 1.0)) == pytest.approx((0.3, 0.0))
    assert chains.crossing((0.0, 1.0, -1e6), (1.0, 1.0, 1e-6)) == pytest.approx((0.1, 1.0), abs=1e-5)


def test_lowest_is_the_least_of_a_segment(drawn):
    chain, _, _, ys = drawn
    n = len(chain.covariances) - 1
    for i, y in enumerate(ys):
        k = i % n
        row = segments_of(chain)[k]
        blocks = chains.block_of(row, 0, y), chains.block_of(row, 1, y)
        wanted = twins.least(lambda t, k=k, y=y: twins.square_at(chain, y, (k + min(t, 1 - 1e-15)) / n), 1)
        value, t = chains.lowest(*blocks, np.inf)
        assert value == pytest.approx(wanted, rel=1e-8)
        assert value == chains.worse(*blocks, t)[1]
        assert chains.lowest(*blocks, 0.5 * wanted)[0] >= 0.5 * wanted


def test_place_beyond_and_segment_at(drawn):
    chain, table, _, ys = drawn
    start, axis = chain.ends[0] * twins.UNITS, chain.axis * twins.UNITS
    for y in ys[:10]:
        for block, part in enumerate((slice(0, 3), slice(3, 6))):
            wanted = (y - start)[part] @ axis[part] / (axis[part] @ axis[part])
            assert chains.place(y, table, block) == pytest.approx(wanted, rel=1e-12)
    assert [chains.beyond(s, 1, 4) for s in (-1.0, 0.25, 0.3, 0.75)] == pytest.approx([1.25, 0, 0, 0.25])
    places = (-0.1, 0.0, 0.24, 0.26, 0.99, 1.0, 7.0, np.nan)
    assert [chains.segment_at(s, 4) for s in places] == [0, 0, 0, 1, 3, 3, 3, 0]


def test_membership_of(drawn):
    """Every segment counts, however far from the first guess; and s is where the least value is taken."""
    chain, table, _, ys = drawn
    for y in ys:
        value, s = chains.membership_of(y, table)
        assert value == pytest.approx(twins.membership(chain, y), rel=1e-8)
        assert value == pytest.approx(twins.square_at(chain, y, s), rel=1e-8)
