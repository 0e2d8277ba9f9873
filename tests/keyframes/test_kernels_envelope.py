"""Projection into chains of ellipsoids, part by part, against NumPy and SciPy."""

import numpy as np
import pytest

from keyframes import envelopes as twins
from manifold.kernels import callable_of
from skillfold.keyframes.kernels import envelope as _envelope

envelope = callable_of(_envelope)


@pytest.fixture(scope="module", params=[2, 4])
def drawn(request):
    """A chain of so many stations, its table, and poses and their scaled coordinates in and about it."""
    rng = np.random.default_rng(6)
    chain = twins.random_region(rng, request.param)
    poses = twins.near(chain, 16, rng)
    return chain, chain.compiled().arguments, poses, chain.chart.to_chart(poses) * twins.UNITS


def test_part_mixed_and_less():
    rng = np.random.default_rng(0)
    row = rng.normal(size=12)
    assert envelope.part(row, 0) + envelope.part(row, 1) == tuple(row)
    a, b = tuple(row[:6]), tuple(row[6:])
    assert envelope.mixed(a, b, 0.25) == pytest.approx(0.75 * row[:6] + 0.25 * row[6:])
    assert envelope.less(a, b) == pytest.approx(row[:6] - row[6:])


def test_ends_of_away_from_slice_and_back(drawn):
    """Of each block: distance and slope along a segment, and the way into the slice; and of both together."""
    chain, table, _, ys = drawn
    n = len(chain.covariances) - 1
    for i, y in enumerate(ys):
        k, t = i % n, 0.9 * i / len(ys)
        blocks = envelope.ends_of(y, k, table)
        mean, sigma = twins.scaled_station(chain, (k + t) / n)
        v = (y - mean).reshape(2, 3)
        inside = [twins.nearest_in_ellipsoid(sigma[b], v[b]) for b in range(2)]
        for b, part in enumerate((blocks[:4], blocks[4:])):
            value, slope, *way = envelope.away(*part, t)
            np.testing.assert_allclose(way, v[b] - inside[b], atol=1e-9)
            assert value == pytest.approx(np.dot(way, way), abs=1e-15)
            h = 1e-5
            wanted = (envelope.away(*part, t + h)[0] - envelope.away(*part, t - h)[0]) / (2 * h)
            assert slope == pytest.approx(wanted, rel=1e-4, abs=1e-9)
            np.testing.assert_allclose(envelope.back(*part, t, 1.0), inside[b] - v[b], atol=1e-8)
        at, value, slope = envelope.from_slice(blocks, t)
        parts = [envelope.away(*part, t) for part in (blocks[:4], blocks[4:])]
        assert (at, value, slope) == pytest.approx((t, parts[0][0] + parts[1][0], parts[0][1] + parts[1][1]))


def test_between():
    """Tangents of |t - 0.3| meet at its tip, the line through both slopes of (t - 0.3)² is level at its bottom."""
    assert envelope.between((0.0, 0.3, -1.0), (1.0, 0.7, 1.0), False) == pytest.approx((0.3, 0.0))
    assert envelope.between((0.0, 0.09, -0.6), (1.0, 0.49, 1.4), True) == pytest.approx((0.3, -0.21))
    assert envelope.between((0.0, 1.0, -1e6), (1.0, 1.0, 1e-6), False) == pytest.approx(
        (_envelope.LEAST, 1.0), abs=1e-5
    )


def test_nearest_slice_farther_and_nearest_segment(drawn):
    """The least of each segment; what is left out is farther; and the least of all."""
    chain, table, _, ys = drawn
    n = len(chain.covariances) - 1
    for y in [y for y in ys if twins.membership(chain, y) > 1][:6]:
        distances = []
        for k in range(n):
            value, t = envelope.nearest_slice(envelope.ends_of(y, k, table), float(k % 2), np.inf)
            wanted = twins.least(lambda t, k=k, y=y: twins.slice_distance(chain, y, (k + min(t, 1 - 1e-15)) / n), 1)
            assert np.sqrt(value) == pytest.approx(wanted, rel=1e-8, abs=1e-9)
            assert np.sqrt(value) == pytest.approx(twins.slice_distance(chain, y, (k + t) / n), rel=1e-8, abs=1e-9)
            distances.append(value)
        for k in range(n):
            assert not envelope.farther(y, k, table, distances[k] * (1 + 1e-9))
        assert envelope.farther(y + 9.0, 0, table, 1.0)
        k, t = envelope.nearest_segment(y, 0.3, table)
        wanted = np.sqrt(min(distances))
        assert twins.slice_distance(chain, y, (k + t) / n) == pytest.approx(wanted, rel=1e-8, abs=1e-9)


def test_in_chart():
    """Turns of at most half a turn stay; longer ones come back along the way from the mean."""
    limit = _envelope.HALF_TURN
    turn, mean = np.array([0.3, 0.1, -0.2]), np.array([0.1, -0.1, 0.05])
    assert envelope.in_chart(tuple(turn), tuple(mean)) == tuple(turn)
    found = np.array(envelope.in_chart(tuple(3 * turn), tuple(mean)))
    assert np.linalg.norm(found) == pytest.approx(limit, rel=1e-12)
    way = 3 * turn - mean
    assert np.linalg.norm(np.cross(found - mean, way)) < 1e-15
    assert 0 < (found - mean) @ way < way @ way


def test_drawn_in(drawn):
    chain, table, _, ys = drawn
    for y in [y for y in ys if twins.membership(chain, y) > 1]:
        pose = np.empty(7)
        distance = envelope.drawn_in(y, 0.5, table, np.empty(6), pose)
        inside = chain.chart.to_chart(pose) * twins.UNITS
        assert distance == pytest.approx(np.linalg.norm(inside - y), rel=1e-9)
        assert twins.membership(chain, inside) == pytest.approx(1, abs=1e-7)


def test_excess_and_projected_agree_with_memberships_and_projections(drawn):
    chain, table, poses, _ = drawn
    squares, places = np.empty(len(poses)), np.empty(len(poses))
    envelope.memberships(poses, table, squares, places)
    out, distances, one = np.empty_like(poses), np.empty(len(poses)), np.empty(7)
    envelope.projections(poses, table, out, distances)
    for i, pose in enumerate(poses):
        assert envelope.excess(pose, table) == pytest.approx(np.sqrt(squares[i]) - 1, abs=1e-14)
        excess, moved = envelope.projected(pose, one, table)
        assert (excess, moved) == pytest.approx((np.sqrt(squares[i]) - 1, distances[i]), abs=1e-14)
        np.testing.assert_allclose(one, out[i], atol=1e-14)
        s = places[i]
        assert squares[i] == pytest.approx(
            twins.square_at(chain, chain.chart.to_chart(pose) * twins.UNITS, s), rel=1e-7
        )
