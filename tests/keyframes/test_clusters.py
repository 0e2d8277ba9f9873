"""Keyframes to places in order: found again, and the same whatever the order, place and signs of what is given."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from keyframes.skills import any_motion, demonstrations, moved
from skillfold.experiments.keyframe_learning import recovered
from skillfold.keyframes.clusters import EXTRA, cluster
from skillfold.keyframes.estimation import estimate


def means(demos, found):
    groups = [
        np.concatenate([demo[labels == k] for demo, labels in zip(demos, found.labels, strict=True)])
        for k in range(found.chosen)
    ]
    return [estimate(group).mean for group in groups]


def same(first, second):
    return all(np.array_equal(a, b) for a, b in zip(first.labels, second.labels, strict=True))


@pytest.mark.parametrize(("missing", "extra"), [(0.0, 0.0), (0.15, 0.15)])
def test_most_skills_are_recovered(missing, extra):
    found = []
    for seed in range(5):
        truth, demos = demonstrations(seed, missing=missing, extra=extra)
        found.append(recovered(truth, means(demos, cluster(demos))))
    assert sum(found) >= 4


@pytest.mark.parametrize("count", [1, 2, 6])
def test_skills_of_other_lengths(count):
    truth, demos = demonstrations(5, count=count)
    assert recovered(truth, means(demos, cluster(demos)))


def test_labels_of_whole_demonstrations_count_up():
    _, demos = demonstrations(1)
    for labels in cluster(demos).labels:
        np.testing.assert_array_equal(labels, np.arange(4))


def test_a_place_visited_twice_is_two_keyframes():
    rng = np.random.default_rng(0)
    pose = np.array([[0.0, 0, 0, 1, 0, 0, 0], [0.4, 0, 0, 1, 0, 0, 0], [0.0, 0, 0, 1, 0, 0, 0]])
    demos = [pose + np.hstack([rng.normal(0, 0.01, (3, 3)), np.zeros((3, 4))]) for _ in range(5)]
    demos.append(demos[0][1:])
    found = cluster(demos)
    assert found.chosen == 3
    np.testing.assert_array_equal(found.labels[-1], [1, 2])


def test_an_astray_keyframe_belongs_to_none():
    _, demos = demonstrations(1)
    astray = np.array([[2.0, 2.0, 2.0, 0.5, 0.5, 0.5, 0.5]])
    demos[3] = np.vstack([demos[3][:2], astray, demos[3][2:]])
    found = cluster(demos)
    np.testing.assert_array_equal(found.labels[3], [0, 1, EXTRA, 2, 3])


@settings(max_examples=5, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.15]))
def test_order_signs_and_rigid_motion(seed, share):
    """What is found does not depend on them; the evidence neither."""
    rng = np.random.default_rng(seed)
    _, demos = demonstrations(seed, 5, share, share, 3)
    order, (turn, shift) = rng.permutation(len(demos)), any_motion(seed)
    other = [moved(demos[i], turn, shift) * [1, 1, 1, -1, -1, -1, -1] for i in order]
    first, second = cluster(demos), cluster(other)
    assert first.chosen == second.chosen
    np.testing.assert_allclose(dict(first.table)[first.chosen], dict(second.table)[first.chosen], rtol=1e-6)
    for i, labels in zip(order, second.labels, strict=True):
        np.testing.assert_array_equal(first.labels[i], labels)


def test_same_seed_same_bits_and_places_increase():
    _, demos = demonstrations(3, missing=0.15, extra=0.15)
    first, second = cluster(demos, seed=4), cluster(demos, seed=4)
    assert same(first, second) and first.table == second.table
    for labels in first.labels:
        assert (np.diff(labels[labels != EXTRA]) > 0).all()


def test_the_number_asked_for():
    _, demos = demonstrations(2)
    for number in (1, 3, 4):
        found = cluster(demos, number)
        assert found.chosen == number and [k for k, _ in found.table] == [number]
        assert {int(k) for labels in found.labels for k in labels} - {EXTRA} == set(range(number))
