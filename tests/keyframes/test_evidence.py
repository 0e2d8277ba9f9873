"""Densities with mean and covariance integrated out, against SciPy's Student t."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import betaln
from scipy.stats import multivariate_t

from skillfold.keyframes.evidence import FREEDOM, HITS, MISSES, Prior, next_shown, shown, sums_of

MIDDLE = Rotation.from_rotvec([0.3, -2.0, 0.5])


@pytest.fixture
def rows():
    """Positions and quaternions of any sign, not far from each other."""
    rng = np.random.default_rng(4)
    turns = (MIDDLE * Rotation.from_rotvec(rng.normal(0, 0.05, (8, 3)))).as_quat(scalar_first=True)
    return rng.normal(0, 0.1, (8, 3)), turns * rng.choice([-1.0, 1.0], (8, 1))


def prior_of(rows):
    return Prior.of(sums_of(*rows).sum(0))


def together(prior, rows, chosen):
    return prior.places(sums_of(*rows)[chosen].sum(0)[None, None])


def student(rows, new, spread):
    """Density of a further row, by SciPy."""
    n, mean = len(rows), rows.mean(0)
    scatter = FREEDOM * spread**2 * np.eye(3) + (rows - mean).T @ (rows - mean)
    freedom = FREEDOM + n - 3
    return multivariate_t.logpdf(new, mean, scatter * (n + 1) / (n * freedom), freedom)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_further_keyframe(rows, count):
    prior = prior_of(rows)
    positions, turns = rows
    found = prior.further(together(prior, rows, slice(count)), positions[count:], turns[count:])[0, :, 0]
    mean = Rotation.from_quat(turns[:count], scalar_first=True).mean()
    vectors = (mean.inv() * Rotation.from_quat(turns, scalar_first=True)).as_rotvec()
    wanted = student(positions[:count], positions[count:], prior.spread[0])
    wanted = wanted + student(vectors[:count], vectors[count:], prior.spread[1])
    np.testing.assert_allclose(found, wanted, atol=0.05)  # 2 sin(θ/2) is not quite θ


def test_the_first_keyframe_may_be_anywhere(rows):
    prior = prior_of(rows)
    nothing = prior.places(np.zeros((1, 1, 29)))
    np.testing.assert_allclose(prior.further(nothing, *rows), -prior.volume)
    assert prior.evidence(nothing) == 0.0


def test_evidence_is_the_product_of_further_keyframes(rows):
    """Exactly so for positions; rotations turn about another mean each time."""
    positions, turns = rows
    same = positions, np.tile(turns[:1], (8, 1))
    prior = prior_of(rows)
    steps = [
        prior.further(together(prior, same, slice(i)), same[0][i : i + 1], same[1][i : i + 1]).item()
        for i in range(8)
    ]
    np.testing.assert_allclose(prior.evidence(together(prior, same, slice(8))), sum(steps), rtol=1e-10)


def test_signs_of_quaternions_do_not_matter(rows):
    prior, flipped = prior_of(rows), (rows[0], -rows[1])
    np.testing.assert_allclose(sums_of(*rows), sums_of(*flipped))
    places = together(prior, rows, slice(4))
    np.testing.assert_allclose(prior.further(places, *rows), prior.further(places, *flipped))


def test_all_keyframes_in_one_place_leave_a_volume():
    prior = Prior.of(sums_of(np.zeros((5, 3)), np.tile([1.0, 0, 0, 0], (5, 1))).sum(0))
    assert np.isfinite(prior.volume) and (prior.spread > 0).all()


def test_which_demonstrations_show_a_place():
    hits = np.arange(8)
    np.testing.assert_allclose(shown(hits, 7), betaln(HITS + hits, MISSES + 7 - hits) - betaln(HITS, MISSES))
    hit, miss = next_shown(hits, 7)
    np.testing.assert_allclose(np.exp(hit) + np.exp(miss), 1.0)
    np.testing.assert_allclose(shown(hits, 7) + hit, shown(hits + 1, 8))
    np.testing.assert_allclose(shown(hits, 7) + miss, shown(hits, 8))
