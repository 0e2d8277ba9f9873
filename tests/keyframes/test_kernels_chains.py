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


def test_block_of_and_square(drawn):
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
        np.testing.assert_allclose([value for value, _, _ in found], wanted, rtol=1e-8)
        h = 1e-5
        before, after = ([chains.square(b, t + side) for b in blocks] for side in (-h, h))
        for order in (0, 1):
            differences = [(b[order] - a[order]) / (2 * h) for a, b in zip(before, after, strict=True)]
            np.testing.assert_allclose([f[order + 1] for f in found], differences, rtol=1e-5, atol=1e-5)


def test_bottom_ahead_and_descent():
    """Of two parabolas' upper hull, against a search: at either bottom, at a crossing, and where they hardly bend."""
    assert chains.bottom((3.0, -2.0, 4.0)) == 0.5
    assert chains.ahead((3.0, -2.0, 4.0), 0.5) == 2.5
    assert chains.bottom((0.0, 1.0, 0.0)) == -chains.bottom((0.0, -1.0, 1e-9)) == -_chains.FARTHEST
    rng = np.random.default_rng(0)
    seen = set()
    for _ in range(300):
        pair = [(rng.uniform(0, 3), rng.normal() * 2, rng.uniform(0.5, 4) * 10 ** rng.normal()) for _ in range(2)]
        upper, lower = sorted(pair, reverse=True)
        step, gain = chains.descent(upper, lower)
        steps = [chains.bottom(upper), chains.bottom(lower)]
        seen.add(steps.index(step) if step in steps else 2)
        if _chains.FARTHEST in np.abs(steps):
            continue

        def hull(x, upper=upper, lower=lower):
            return max(chains.ahead(upper, x), chains.ahead(lower, x))

        assert upper[0] - gain == pytest.approx(hull(step), abs=1e-10)
        assert hull(step) == pytest.approx(twins.golden(hull, -4.0, 4.0), abs=1e-10)
    assert seen == {0, 1, 2}


def test_lowest_is_the_least_of_a_segment(drawn):
    chain, _, _, ys = drawn
    n = len(chain.covariances) - 1
    for i, y in enumerate(ys):
        k = i % n
        row = segments_of(chain)[k]
        blocks = chains.block_of(row, 0, y), chains.block_of(row, 1, y)
        wanted = twins.least(lambda t, k=k, y=y: twins.square_at(chain, y, (k + min(t, 1 - 1e-15)) / n), 1)
        for first in (0.0, 0.4, 1.0):
            value, t = chains.lowest(*blocks, first, np.inf)
            assert value == pytest.approx(wanted, rel=1e-8)
            assert value == max(chains.square(block, t)[0] for block in blocks)
            assert chains.lowest(*blocks, first, 0.5 * wanted)[0] >= 0.5 * wanted


@pytest.mark.parametrize("thin", [1e-3, 1e-6, 1e-9])
def test_lowest_where_one_end_is_very_thin(thin):
    rng = np.random.default_rng(8)
    for _ in range(20):
        a, b = rng.normal(size=(2, 6))
        ratios = np.array([1.0, 1.0, 1.0]) / thin
        position, rotation = ((*a[c] / thin**0.5, *b[c] / thin**0.5, *ratios) for c in (slice(0, 3), slice(3, 6)))
        wanted = twins.least(lambda t, p=position, r=rotation: max(chains.square(p, t)[0], chains.square(r, t)[0]), 1)
        assert chains.lowest(position, rotation, 0.0, np.inf)[0] == pytest.approx(wanted, rel=1e-7, abs=1e-9)


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
