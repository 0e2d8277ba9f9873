"""Soft-envelopes: laws, oracles and what they refuse."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import sqrtm
from scipy.spatial.transform import Rotation

from keyframes import envelopes as twins
from skillfold.errors import InputError
from skillfold.keyframes import stations
from skillfold.keyframes.charts import LENGTH
from skillfold.keyframes.envelope import SoftEnvelope
from skillfold.keyframes.gaussians import PoseGaussian

few = settings(deadline=None, max_examples=25)


def kinds(parent, child):
    """One of each: full, reduced, of optimal transport, widened."""
    full = SoftEnvelope.between(parent, child)
    return (
        full,
        full.reduced(75.0),
        SoftEnvelope.between(parent, child, "bures").reduced(90.0, 0.3),
        full.widened(2.0),
    )


@few
@given(twins.pairs(thin=1e-3))
def test_projections_are_inside_and_stay(case):
    parent, child, rng = case
    for envelope in kinds(parent, child):
        poses = np.concatenate([twins.near(envelope, 15, rng), twins.random_poses(15, rng)])
        inside = envelope.project(poses)
        assert envelope.contains(inside).all()
        np.testing.assert_array_equal(envelope.project(inside), inside)
        distances = envelope.distance(poses)
        np.testing.assert_array_equal(distances == 0, envelope.contains(poses))
        assert envelope.contains(poses, distances.max()).all()
        np.testing.assert_array_equal(envelope.distance(inside), 0)


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_no_scale_puts_projections_outside(seed):
    """Lengths from a tenth of a millimetre to ten metres, turns from a tenth of a milliradian to ten radians."""
    rng = np.random.default_rng(seed)
    size, angle, thin, far = 10 ** rng.uniform([-4, -4, -4, -2], [1, 1, 0, 1])
    covariances = np.zeros((2, 6, 6))
    for covariance in covariances:
        covariance[:3, :3] = twins.spd(rng, size * thin ** rng.uniform(size=3))
        covariance[3:, 3:] = twins.spd(rng, angle * thin ** rng.uniform(size=3))
    parent, child = (
        PoseGaussian([*rng.normal(size=3) * far, *twins.random_gaussian(rng).mean[3:]], c) for c in covariances
    )
    for envelope in kinds(parent, child):
        poses = np.concatenate([twins.random_poses(10, rng, far), twins.near(envelope, 10, rng, size)])
        assert envelope.contains(envelope.sample(10, 1)).all()
        assert envelope.contains(envelope.project(poses)).all()
        assert np.isfinite(envelope.distance(poses)).all()


@few
@given(twins.pairs())
def test_samples_and_means_are_inside(case):
    parent, child, _ = case
    s = np.linspace(0, 1, 7)
    for envelope in kinds(parent, child):
        means, covariances = envelope.at(s)
        assert covariances.shape == (7, 2, 3, 3)
        np.testing.assert_allclose(envelope.membership(means)[0], 0, atol=1e-12)
        if np.linalg.norm(envelope.axis) > 1e-3:
            np.testing.assert_allclose(envelope.place(means), s, atol=1e-5)
        assert envelope.contains(envelope.sample(50, seed=4)).all()
        np.testing.assert_array_equal(envelope.sample(5, seed=4), envelope.sample(5, seed=4))


@few
@given(twins.pairs())
def test_the_ends_are_the_gaussians(case):
    parent, child, rng = case
    for interpolation in ("linear", "bures"):
        envelope = SoftEnvelope.between(parent, child, interpolation)
        means, covariances = envelope.at([0.0, 1.0])
        for end, gaussian in enumerate((parent, child)):
            mean, gated = gaussian.about(envelope.chart)
            np.testing.assert_allclose(envelope.chart.to_chart(means[end]), mean, atol=1e-12)
            np.testing.assert_allclose(covariances[end], gated, rtol=1e-9, atol=1e-15)
        goal = envelope.slice(1.0)
        assert envelope.contains(goal.sample(30, seed=1)).all()
        poses = twins.near(goal, 20, rng)
        alone = [twins.square_at(goal, y, 0.0) for y in goal.chart.to_chart(poses) * twins.UNITS]
        np.testing.assert_allclose(goal.membership(poses)[0], alone, rtol=1e-8)


@few
@given(twins.pairs())
def test_the_full_linear_envelope_is_convex_in_the_chart(case):
    """As v'Σ⁻¹v is convex in v and Σ together: half-way between two poses inside is inside."""
    parent, child, rng = case
    envelope = SoftEnvelope.between(parent, child)
    y = envelope.chart.to_chart(envelope.project(twins.near(envelope, 80, rng, 0.1)))
    share = rng.uniform(size=(40, 1))
    between = share * y[:40] + (1 - share) * y[40:]
    assert (envelope.membership(envelope.chart.to_pose(between))[0] <= 1 + 1e-9).all()


@few
@given(twins.pairs())
def test_reduced_is_within_full_within_widened(case):
    parent, child, rng = case
    for interpolation in ("linear", "bures"):
        full = SoftEnvelope.between(parent, child, interpolation)
        poses = np.concatenate([twins.near(full, 40, rng), full.sample(40, 2)])
        squares = full.membership(poses)[0]
        for reduced in (full.reduced(60.0), full.reduced(85.0, 0.5)):
            assert (reduced.membership(poses)[0] >= squares * (1 - 1e-9)).all()
        np.testing.assert_allclose(full.widened(4.0).membership(poses)[0], squares / 4, rtol=1e-8, atol=1e-14)
        np.testing.assert_allclose(full.reduced(100.0).membership(poses)[0], squares, rtol=1e-12)
        np.testing.assert_allclose(full.reduced(60.0, 1.0).membership(poses)[0], squares, rtol=1e-2, atol=1e-9)
        distances = [full.widened(f).distance(poses) for f in (0.5, 1.0, 2.0)]
        assert (np.diff(distances, axis=0) <= 1e-9).all()


@few
@given(twins.pairs())
def test_a_rigid_motion_of_everything_and_the_signs_of_quaternions_change_nothing(case):
    parent, child, rng = case
    turn, shift = twins.rotations(1, rng)[0], rng.normal(size=3)
    flip = np.repeat([1, -1], [3, 4])
    envelope = SoftEnvelope.between(parent, child).reduced(85.0)
    poses = twins.near(envelope, 25, rng)
    squares, distances = envelope.membership(poses)[0], envelope.distance(poses)
    other = SoftEnvelope.between(twins.moved(parent, turn, shift), twins.moved(child, turn, shift)).reduced(85.0)
    there = twins.moved_poses(poses, turn, shift)
    np.testing.assert_allclose(other.membership(there)[0], squares, rtol=1e-6)
    np.testing.assert_allclose(other.distance(there), distances, atol=1e-8)
    turned = PoseGaussian(parent.mean * flip, parent.covariance, parent.gates)
    again = SoftEnvelope.between(turned, child).reduced(85.0)
    np.testing.assert_allclose(again.membership(poses * flip)[0], squares, rtol=1e-6)
    np.testing.assert_allclose(again.distance(poses * flip), distances, atol=1e-8)


@few
@given(twins.pairs())
def test_the_other_way_round_it_is_the_same(case):
    parent, child, rng = case
    there, back = SoftEnvelope.between(parent, child), SoftEnvelope.between(child, parent)
    poses = twins.near(there, 20, rng)
    np.testing.assert_allclose(there.membership(poses)[0], back.membership(poses)[0], rtol=1e-6)


@settings(deadline=None, max_examples=6)
@given(twins.pairs())
def test_membership_and_distance_are_what_general_solvers_find(case):
    parent, child, rng = case
    envelope = SoftEnvelope.between(parent, child)
    poses = twins.near(envelope, 4, rng, 0.1)
    for pose, y in zip(poses, envelope.chart.to_chart(poses) * twins.UNITS, strict=True):
        assert envelope.membership(pose)[0] == pytest.approx(twins.membership(envelope, y), rel=1e-8)
        found, wanted = envelope.distance(pose), twins.solved_distance(envelope, y)
        assert found <= wanted + 2e-8
        assert found == pytest.approx(wanted, abs=1e-5)


def test_bures_is_the_way_of_optimal_transport():
    """Against the formula with general matrix roots, at the stations; and thinner half-way than the linear one."""
    first = np.array([twins.spd(np.random.default_rng(i), [0.1, 0.02, 0.05]) for i in range(2)])
    last = np.array([twins.spd(np.random.default_rng(i), [0.3, 0.05, 0.02]) for i in range(2, 4)])
    found = stations.bures(first, last)
    np.testing.assert_allclose(found[[0, -1]], [first, last], atol=1e-15)
    for s in (0.25, 0.5, 0.75):
        for b in range(2):
            root = sqrtm(first[b] @ last[b]).real
            wanted = (1 - s) ** 2 * first[b] + s**2 * last[b] + s * (1 - s) * (root + root.T)
            np.testing.assert_allclose(found[int(s * stations.BURES_SEGMENTS), b], wanted, atol=1e-13)
    half = found[stations.BURES_SEGMENTS // 2]
    assert (np.linalg.eigvalsh(0.5 * (first + last) - half) > -1e-15).all()


def of_widths(position, rotation, where=0.0):
    covariance = np.diag(np.concatenate([np.square(position), np.square(rotation)]))
    return PoseGaussian((where, 0, 0, 1, 0, 0, 0), covariance, np.array([1.0, 1.0]), 7)


def test_as_many_directions_are_kept_as_parent_or_child_need():
    """Ranked in metres, a radian as 0.15 m, rotations among positions."""
    parent = of_widths([0.1, 0.01, 0.01], [0.01, 0.01, 0.01])
    child = of_widths([0.01, 0.1, 0.01], [0.1 / LENGTH, 0.01, 0.01], 0.2)
    ends = [g.about(SoftEnvelope.between(parent, child).chart)[1] for g in (parent, child)]
    assert [stations.count_kept(end, 85.0) for end in ends] == [1, 2]
    assert [stations.count_kept(ends[0], alpha) for alpha in (1e-9, 99.999, 100.0)] == [1, 6, 6]
    reduced = SoftEnvelope.between(parent, child).reduced(85.0, 0.04)
    start, end = (np.sqrt(np.linalg.eigvalsh(covariances)) for covariances in reduced.covariances[[0, -1]])
    np.testing.assert_allclose(start[0], [0.002, 0.01, 0.1], rtol=1e-9)
    np.testing.assert_allclose(start[1], [0.002, 0.002, 0.002], rtol=1e-9)
    np.testing.assert_allclose(end[0], [0.002, 0.002, 0.1], rtol=1e-9)
    np.testing.assert_allclose(end[1], [0.002, 0.002, 0.1 / LENGTH], rtol=1e-9)


@few
@given(twins.pairs(thin=0.01))
def test_reduced_envelopes_are_never_torn(case):
    """However thin: along the means all is inside, and neighbours' means lie within half a gate, or there are 65."""
    parent, child, _ = case
    reduced = SoftEnvelope.between(parent, child).reduced(60.0, 1e-3)
    assert reduced.contains(reduced.at(np.linspace(0, 1, 500))[0]).all()
    n = len(reduced.covariances) - 1
    step = (reduced.axis / n).reshape(2, 3)
    gap = max(step[b] @ np.linalg.solve(c[b], step[b]) for c in reduced.covariances for b in range(2))
    assert n == stations.MOST_SEGMENTS or gap <= stations.OVERLAP * 1.2


def test_reduction_squeezes_what_is_not_principal():
    rng = np.random.default_rng(3)
    parent, child = of_widths([0.1, 0.01, 0.01], [0.01] * 3), of_widths([0.1, 0.01, 0.01], [0.01] * 3, 0.3)
    reduced = SoftEnvelope.between(parent, child).reduced(85.0)
    y = np.zeros((200, 6))
    y[:, 0] = rng.uniform(0, 0.3, 200)
    for c, kept in ((0, True), (1, False), (2, False), (3, False)):
        aside = y.copy()
        aside[:, c] += 0.009
        assert reduced.contains(reduced.chart.to_pose(aside)).all() == kept


@pytest.mark.parametrize("angle", [3.1, np.pi])
def test_gaussians_half_a_turn_apart_are_refused(angle):
    turned = np.append(np.zeros(3), Rotation.from_rotvec([0, angle, 0]).as_quat(scalar_first=True))
    child = PoseGaussian(turned, np.eye(6) * 1e-3)
    with pytest.raises(InputError, match=r"turned 1(78|80)° .*expected at most 172°: add a keyframe"):
        SoftEnvelope.between(of_widths([0.1] * 3, [0.1] * 3), child)


def test_gates_wider_than_half_a_turn():
    """Rotations have coordinates within half a turn only; samples and projections keep to these."""
    rng = np.random.default_rng(0)
    parent, child = of_widths([0.1] * 3, [9.0, 2.0, 0.1]), of_widths([0.1] * 3, [0.1, 9.0, 4.0], 0.3)
    for envelope in kinds(parent, child):
        assert envelope.contains(envelope.sample(300, 1)).all()
        poses = twins.random_poses(300, rng, 0.3)
        inside = envelope.project(poses)
        assert envelope.contains(inside).all()
        np.testing.assert_array_equal(envelope.project(inside), inside)


def test_an_envelope_of_no_length():
    gaussian = of_widths([0.1, 0.05, 0.01], [0.1, 0.2, 0.3])
    rng = np.random.default_rng(1)
    for envelope in kinds(gaussian, gaussian):
        poses = twins.near(envelope, 50, rng)
        assert envelope.contains(envelope.project(poses)).all()
        assert np.isfinite(envelope.distance(poses)).all()
    full = SoftEnvelope.between(gaussian, gaussian)
    np.testing.assert_array_equal(full.contains(poses), gaussian.contains(poses))


def test_repr():
    envelope = SoftEnvelope.between(of_widths([0.1] * 3, [0.1] * 3), of_widths([0.1] * 3, [0.1] * 3, 0.4))
    assert repr(envelope) == "SoftEnvelope(0.4 m and 0 rad long, linear, 2 stations, alpha 100, gates × 1)"
    assert repr(envelope.widened(2).widened(2)).endswith("gates × 4)")
    assert "alpha 50" in repr(envelope.reduced(50))


ENVELOPE = SoftEnvelope.between(of_widths([0.1] * 3, [0.1] * 3), of_widths([0.1] * 3, [0.1] * 3, 0.4))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: SoftEnvelope.between(None, ENVELOPE.child), "parent"),
        (lambda: SoftEnvelope.between(ENVELOPE.parent, np.eye(6)), "child"),
        (lambda: SoftEnvelope.between(ENVELOPE.parent, ENVELOPE.child, "cubic"), "interpolation"),
        (lambda: SoftEnvelope.between(ENVELOPE.parent, ENVELOPE.child, ["linear"]), "interpolation"),
        (lambda: ENVELOPE.reduced(0), "alpha"),
        (lambda: ENVELOPE.reduced(101), "alpha"),
        (lambda: ENVELOPE.reduced("most"), "alpha"),
        (lambda: ENVELOPE.reduced(85, 0), "kappa"),
        (lambda: ENVELOPE.reduced(85, np.nan), "kappa"),
        (lambda: ENVELOPE.widened(-1), "factor"),
        (lambda: ENVELOPE.widened(np.inf), "factor"),
        (lambda: ENVELOPE.widened(None), "factor"),
        (lambda: ENVELOPE.at([0, np.nan]), "s"),
        (lambda: ENVELOPE.contains([[0, 0]]), "poses"),
        (lambda: ENVELOPE.project(np.full(7, np.nan)), "poses"),
        (lambda: ENVELOPE.covariances_at(np.nan), "s"),
        (lambda: ENVELOPE.means_at("middle"), "s"),
        (lambda: ENVELOPE.sample("ten"), "count"),
        (lambda: ENVELOPE.sample(3, seed=-1), "seed"),
        (lambda: ENVELOPE.sample(3, seed=None), "seed"),
        (lambda: ENVELOPE.slice(np.nan), "s"),
        (lambda: ENVELOPE.slice([0, 1]), "s"),
    ],
)
def test_what_cannot_be_used_is_named(make, words):
    with pytest.raises(InputError, match=f"^{words}: .*expected") as caught:
        make()
    assert "\n" not in str(caught.value)
