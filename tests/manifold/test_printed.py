"""The paper as printed, and the fast solvers of the same conditions against it, on section V-A's arm."""

import numpy as np
import pytest

from skillfold.experiments.reaching import inside_grid
from skillfold.experiments.three_link import REACHING, optimal
from skillfold.manifold import printed


@pytest.fixture(scope="module")
def pairs():
    rng = np.random.default_rng(3)
    starts, goals = (optimal(inside_grid(4, rng), REACHING) for _ in range(2))
    return list(zip(starts, goals, strict=True))


def rmse(a, b):
    return np.sqrt(((a - b) ** 2).mean())


def nearest_samples(skill, states):
    anchors = skill.model.centre + skill.model.scale * skill.model.anchors @ skill.model.kept.T
    return anchors[np.linalg.norm(states[:, None] - anchors, axis=2).argmin(1)]


@pytest.mark.parametrize("points", [3, 10, 25])
def test_solving_both_conditions_at_once_gives_the_path_of_the_descent(arm, pairs, points):
    for start, goal in pairs:
        first = arm.plan(start, goal, points)
        solved = arm.plan(start, goal, points, method="leaf")
        walked, iterations = printed.descend(arm.tangent, first.path.states)
        assert iterations < printed.LIMIT
        assert solved.converged
        assert rmse(walked[1:-1], solved.path.states[1:-1]) < 1e-6
        if points > 3:  # and it is another path than the one tied to the data
            assert rmse(walked, first.path.states) > 1e-5
            assert solved.iterations < iterations / 10


def test_both_gradients_vanish_on_the_solver_s_path(arm, pairs):
    path = arm.plan(*pairs[0], 25, method="leaf").path.states
    basis = arm.tangent(path[1:-1])
    pull = np.einsum("nca,nc->na", basis, printed.length_gradient(path))
    lift = printed.manifold_gradient(arm.tangent, path)
    lift -= np.einsum("nca,nea,ne->nc", basis, basis, lift)
    assert np.abs(pull).max() < 1e-8
    assert np.abs(lift).max() < 1e-8


def test_the_descent_diverges_beyond_its_largest_step(arm, pairs):
    """Second derivatives of both errors reach 8: a step of 2 / 8 is the limit (0.24 converges, see above)."""
    first = arm.plan(*pairs[0], 10).path.states
    kinked = first.copy()
    kinked[1:-1:2] += 1e-3
    near, _ = printed.descend(arm.tangent, kinked, step=0.24, limit=300)
    away, _ = printed.descend(arm.tangent, kinked, step=0.27, limit=300)
    settled, _ = printed.descend(arm.tangent, first)
    assert rmse(near, settled) < 1e-5
    assert not rmse(away, settled) < 0.1


def test_gradients_are_those_of_their_errors():
    """By finite differences, on a field that is the same everywhere."""
    rng = np.random.default_rng(0)
    basis = np.linalg.qr(rng.normal(size=(4, 2)))[0]
    path = rng.normal(size=(6, 4))

    def tangent(states):
        return np.broadcast_to(basis, (*states.shape[:-1], 4, 2))

    def off_manifold(path):
        steps = np.diff(path, axis=0)
        return ((steps - steps @ basis @ basis.T) ** 2).sum()

    def length(path):
        return (np.diff(path, axis=0) ** 2).sum()

    for error, gradient in (
        (off_manifold, printed.manifold_gradient(tangent, path)),
        (length, printed.length_gradient(path)),
    ):
        for i in range(4):
            for c in range(4):
                moved = np.zeros_like(path)
                moved[i + 1, c] = 1e-6
                slope = (error(path + moved) - error(path - moved)) / 2e-6
                assert gradient[i, c] == pytest.approx(slope, abs=1e-7)


def test_the_printed_projection_and_the_leaf_method_agree(arm):
    rng = np.random.default_rng(0)
    states = optimal(inside_grid(20, rng), REACHING) + 0.2 * rng.normal(size=(20, 3))
    near = nearest_samples(arm, states)
    walked = printed.project(arm.tangent, states, near)
    assert rmse(walked, arm.project(states, method="leaf")) < 1e-6
    assert rmse(walked, arm.project(states, near=near, method="leaf")) < 1e-6
    # What is left of the way to the state is normal to the field.
    left = np.einsum("nca,nc->na", arm.tangent(walked), states - walked)
    assert np.abs(left).max() < 1e-9


def test_the_printed_projection_depends_on_where_it_starts_and_the_anchored_one_does_not(arm):
    state = optimal(np.array([[0.45, 0.0]]), REACHING) + 0.1
    starts = nearest_samples(arm, optimal(inside_grid(6, np.random.default_rng(0)), REACHING))
    leaves = printed.project(arm.tangent, np.repeat(state, 6, 0), starts)
    anchored = arm.project(np.repeat(state, 6, 0), near=starts)
    assert np.ptp(leaves, axis=0).max() > 1e-5
    assert np.ptp(anchored, axis=0).max() < 1e-8


def test_algorithm_1_as_printed_is_the_straight_line_and_asks_no_tangent(pairs):
    def never(states):
        raise AssertionError("the printed algorithm reached its geodesic step")

    for start, goal in pairs:
        path = printed.first_path_as_printed(never, start, goal, 0.07)
        straight = start + np.linspace(0, 1, len(path))[:, None] * (goal - start)
        np.testing.assert_allclose(path, straight, atol=1e-12)
        assert len(path) > 3
        assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() < 0.07


def test_algorithm_1_mended_stays_nearer_the_manifold_than_the_straight_line(arm, pairs):
    spacing = 0.5 * arm.model.step * arm.model.scale
    for start, goal in pairs:
        path = printed.first_path(arm.tangent, start, goal, spacing)
        straight = start + np.linspace(0, 1, len(path))[:, None] * (goal - start)
        np.testing.assert_array_equal(path[[0, -1]], [start, goal])
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
        assert np.sort(steps)[-2] <= spacing * (1 + 1e-9)  # all but the one where the sides meet
        assert steps.max() <= 1.5 * spacing
        assert arm.distance(path).max() < arm.distance(straight).max()


def test_algorithm_1_mended_ends_where_leaves_do_not_meet():
    """Straight leaves, the ends on different ones: it stops when they get no closer."""

    def tangent(states):
        return np.broadcast_to([[1.0], [0.0]], (*states.shape[:-1], 2, 1))

    path = printed.first_path(tangent, np.zeros(2), np.array([1.0, 1.0]), 0.1)
    assert len(path) < 20
    assert np.isfinite(path).all()
