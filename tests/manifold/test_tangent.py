"""Training of the tangent field against brute force and NumPy's least squares."""

import numpy as np
import pytest

from manifold import twins
from skillfold.experiments.point_sets import draw_sphere
from skillfold.experiments.synthetic import smooth_manifold
from skillfold.manifold import descent, training
from skillfold.manifold.anchors import fit_surfaces
from skillfold.manifold.features import Features
from skillfold.manifold.graph import align_frames, build_graph
from skillfold.manifold.kernels.alignment import across
from skillfold.manifold.skill import SkillManifold
from skillfold.manifold.tangent import begin, pose, regress, train
from skillfold.manifold.training import alignment, field_at_edges, smoothness_matrix


@pytest.fixture(scope="module")
def sphere():
    """Samples, edges, aligned frames and features of a sphere."""
    return prepared(draw_sphere(300, np.random.default_rng(0)), 2, 30)


def prepared(samples, dim, kernels):
    graph = build_graph(samples, 8)
    neighbours = np.linalg.norm(samples[:, None] - samples, axis=2).argsort(1)[:, :20]
    frames = align_frames(fit_surfaces(samples, samples, neighbours, dim, 2).tangents, graph)
    return samples, graph.edges, frames, Features.place(samples, kernels, 0)


def cost(posed, weights, eps):
    misfit = np.einsum("ace,ae->ce", field_at_edges(posed.values, weights), eps) - posed.steps
    return training.objective(posed, weights, eps, misfit)


def problem(samples, edges, frames, features, ridge):
    return pose(features, samples, edges, frames, ridge)[0]


@pytest.fixture(params=[(3, 2), (5, 2), (6, 3)], ids=str, scope="module")
def sheet(request):
    D, d = request.param
    return prepared(smooth_manifold(250, D, d, np.random.default_rng(D)), d, 15)


def test_smoothness_matrix_is_the_double_sum_over_edges_that_share_a_sample():
    rng = np.random.default_rng(0)
    edges = np.array([[0, 1], [1, 2], [0, 2], [2, 3], [3, 4], [1, 4]])
    values = rng.uniform(size=(len(edges), 4))
    weights = rng.normal(size=(4, 3))
    expected = 0.0
    for sample in range(5):
        here = [e for e in range(len(edges)) if sample in edges[e]]
        for place, e in enumerate(here):
            expected += sum((((values[e] - values[f]) @ weights) ** 2).sum() for f in here[place + 1 :])
    matrix = smoothness_matrix(values, edges, 5)
    assert np.trace(weights.T @ matrix @ weights) == pytest.approx(expected, rel=1e-10)
    assert np.linalg.eigvalsh(matrix).min() > -1e-12


@pytest.mark.parametrize("ridge", [1e-6, 1e-2, 3.0])
def test_alignment_is_the_ridge_solution(ridge):
    rng = np.random.default_rng(0)
    H, steps = rng.normal(size=(70, 2, 5)), rng.normal(size=(70, 5))
    found, misfit = (x.T for x in alignment(np.ascontiguousarray(H.transpose(1, 2, 0)), steps.T.copy(), ridge))
    for e in range(70):
        rows = np.vstack([H[e].T, np.sqrt(ridge) * np.eye(2)])
        expected = np.linalg.lstsq(rows, np.r_[steps[e], 0.0, 0.0], rcond=None)[0]
        np.testing.assert_allclose(found[e], expected, atol=1e-12)
    np.testing.assert_allclose(misfit, np.einsum("eac,ea->ec", H, found) - steps, atol=1e-12)


@pytest.mark.parametrize(("d", "D", "E"), [(1, 2, 5), (2, 3, 64), (3, 6, 150)])
def test_across_is_what_the_field_does_not_span(d, D, E):
    """The upper half of weighted (1 + added) I − H (H'H + λI)⁻¹ H'."""
    rng = np.random.default_rng(D)
    H, weights, out = rng.normal(size=(d, D, E)), rng.uniform(size=E), np.empty((D * (D + 1) // 2, E))
    across(H.copy(), 1e-2, 0.3, weights, out)
    for e in range(E):
        M = H[:, :, e].T
        expected = 1.3 * np.eye(D) - M @ np.linalg.inv(M.T @ M + 1e-2 * np.eye(d)) @ M.T
        np.testing.assert_allclose(out[:, e], weights[e] * expected[np.triu_indices(D)], atol=1e-12)


def test_weights_are_the_ridge_solution(sphere):
    samples, edges, frames, features = sphere
    posed = problem(samples, edges, frames, features, 1e-3)
    eps = np.random.default_rng(1).normal(size=(2, posed.steps.shape[1]))
    rows = np.einsum("ae,ke->eak", eps, posed.values).reshape(posed.steps.shape[1], -1)
    eigenvalues, vectors = np.linalg.eigh(posed.smoothness)
    root = np.sqrt(posed.ridge * np.maximum(eigenvalues, 0.0))[:, None] * vectors.T
    trace = (rows**2).sum() + 2 * (root**2).sum()
    penalties = [np.kron(np.eye(2), root), np.sqrt(training.JITTER * trace) * np.eye(60)]
    stacked = np.vstack([posed.steps.T, np.zeros((120, 3))])
    expected = np.linalg.lstsq(np.vstack([rows, *penalties]), stacked, rcond=None)[0].reshape(2, 30, 3)
    found = training.solve_weights(posed, eps)
    # Of the field: it is well determined where single weights of overlapping kernels are not.
    np.testing.assert_allclose(
        np.einsum("ke,akc->eac", posed.values, found), np.einsum("ke,akc->eac", posed.values, expected), atol=1e-6
    )


@pytest.mark.parametrize("ridge", [1e-6, 1e-4, 1e-2])
@pytest.mark.parametrize("start", ["frames", "random"])
def test_the_objective_never_rises(sphere, ridge, start):
    """No part of an iteration raises it: alignment, gauge balance, weights."""
    samples, edges, frames, features = sphere
    posed = problem(samples, edges, frames, features, ridge)
    rng = np.random.default_rng(0)
    weights = rng.normal(size=(2, 30, 3))
    if start == "frames":
        weights = regress(posed, pose(features, samples, edges, frames, ridge)[2])
    eps = alignment(field_at_edges(posed.values, weights), posed.steps, ridge)[0]
    values = [cost(posed, weights, eps)]
    for _ in range(15):
        weights, eps = training.balance(posed, weights, eps)
        values.append(cost(posed, weights, eps))
        weights = training.solve_weights(posed, eps)
        values.append(cost(posed, weights, eps))
        eps = alignment(field_at_edges(posed.values, weights), posed.steps, ridge)[0]
        values.append(cost(posed, weights, eps))
    assert (np.diff(values) <= 1e-9 * values[0]).all()
    assert values[-1] < 0.5 * values[0]


@pytest.mark.parametrize("ridge", [1e-6, 1e-4, 1e-2])
def test_the_descent_falls_in_every_iteration_to_a_stationary_point(sphere, ridge):
    samples, edges, frames, features = sphere
    posed = problem(samples, edges, frames, features, ridge)
    start = begin(features, samples, edges, frames, ridge)[2]
    weights, values, converged = descent.descend(posed, start, 300)
    assert converged
    assert (np.diff(values) < 0).all()
    before, after = (descent._point(posed, w).gradient for w in (start, weights))
    assert np.linalg.norm(after) < 0.3 * np.linalg.norm(before)


def test_the_descent_goes_farther_than_alternation(sheet):
    """As far as alternating least squares would in very many iterations."""
    samples, edges, frames, features = sheet
    posed = problem(samples, edges, frames, features, 1e-4)
    start = begin(features, samples, edges, frames, 1e-4)[2]
    weights = training.alternate(posed, start, 1000)
    eps = alignment(field_at_edges(posed.values, weights), posed.steps, 1e-4)[0]
    assert descent.descend(posed, start, 200)[1][-1] < 1.05 * cost(posed, weights, eps)


def test_the_gradient_is_that_of_the_objective_with_alignment_put_in(sheet):
    samples, edges, frames, features = sheet
    posed = problem(samples, edges, frames, features, 1e-2)
    rng = np.random.default_rng(0)
    shape = (2, 15, samples.shape[1])
    weights, direction = rng.normal(size=shape), rng.normal(size=shape)
    there, back = (descent._point(posed, weights + h * direction).value for h in (1e-5, -1e-5))
    slope = 2 * np.vdot(descent._point(posed, weights).gradient, direction) / posed.steps.shape[1]
    assert (there - back) / 2e-5 == pytest.approx(slope, rel=1e-5)


def test_the_metric_is_the_mean_curvature(sphere):
    samples, edges, frames, features = sphere
    posed = problem(samples, edges, frames, features, 1e-2)
    point = descent._point(posed, np.random.default_rng(0).normal(size=(2, 30, 3)))
    metric = descent.Metric.at(posed, point)
    field = field_at_edges(posed.values, point.weights)
    matrix = twins.mean_curvature(
        posed, field, point.eps, point.misfit, -(-posed.steps.shape[1] // descent.METRIC_EDGES)
    )
    matrix += training.JITTER * np.trace(matrix) * np.eye(90)
    right = np.random.default_rng(1).normal(size=(2, 30, 3))
    found = metric.solve(right).reshape(2, 90)
    np.testing.assert_allclose(found @ matrix, right.reshape(2, 90), atol=1e-3)


def test_objective_is_the_sum_it_says(sphere):
    samples, edges, frames, features = sphere
    posed = problem(samples, edges, frames, features, 0.1)
    rng = np.random.default_rng(0)
    weights, eps = rng.normal(size=(2, 30, 3)), rng.normal(size=(2, posed.steps.shape[1]))
    H = np.einsum("ke,akc->eca", posed.values, weights)
    pairs = 0.0
    for sample in range(len(samples)):
        here = H[: len(edges)][(edges == sample).any(1)]
        pairs += ((here[:, None] - here) ** 2).sum() / 2
    misfit = ((np.einsum("eca,ae->ce", H, eps) - posed.steps) ** 2).sum()
    expected = (misfit + 0.1 * ((eps**2).sum() + pairs)) / posed.steps.shape[1]
    assert cost(posed, weights, eps) == pytest.approx(expected, rel=1e-9)


def test_the_gauge_changes_no_product(sphere):
    samples, edges, frames, features = sphere
    posed = problem(samples, edges, frames, features, 1e-4)
    rng = np.random.default_rng(0)
    weights, eps = rng.normal(size=(2, 30, 3)), rng.normal(size=(2, posed.steps.shape[1])) * [[1.0], [5.0]]
    turned, scaled = training.balance(posed, weights, eps)
    before = np.einsum("ace,ae->ce", field_at_edges(posed.values, weights), eps)
    after = np.einsum("ace,ae->ce", field_at_edges(posed.values, turned), scaled)
    np.testing.assert_allclose(after, before, atol=1e-9 * np.abs(before).max())
    # The floor under the gauge's eigenvalues keeps the two penalties a little apart.
    assert (scaled**2).sum() == pytest.approx(np.trace(training.roughness(posed, turned)), rel=1e-2)


def test_field_spans_the_tangents_of_a_sphere(sphere):
    samples, edges, frames, features = sphere
    field = train(features, samples, edges, frames, 1e-5)
    x = draw_sphere(200, np.random.default_rng(5))
    basis = np.linalg.qr(field(x))[0]
    normal = np.abs(np.einsum("nc,nca->na", x, basis))
    # The sine of the angle between each tangent and the true tangent plane.
    assert np.median(normal) < 0.02
    assert np.quantile(normal, 0.95) < 0.1


def test_held_out_steps_are_spanned(sheet):
    samples, edges, frames, features = sheet
    held = np.random.default_rng(0).random(len(edges)) < 0.2
    field = train(features, samples, edges[~held], frames, 1e-5)
    a, b = samples[edges[held, 0]], samples[edges[held, 1]]
    residual = field.residual((a + b) / 2, b - a)
    assert np.sqrt((residual**2).mean()) < 0.1 * np.sqrt(((b - a) ** 2).sum(1).mean())


def test_the_flag_tells_whether_training_settled(sheet):
    samples, edges, frames, features = sheet
    short = train(features, samples, edges, frames, 1e-4, iterations=4)
    long = train(features, samples, edges, frames, 1e-4, iterations=4000)
    assert not short.converged
    assert long.converged
    assert long.objective < short.objective


def test_residual_is_what_an_orthonormal_basis_leaves(sphere):
    samples, edges, frames, features = sphere
    field = train(features, samples, edges, frames, 1e-5)
    x, steps = samples[:20], np.random.default_rng(0).normal(size=(20, 3))
    for i in range(20):
        fitted = np.linalg.lstsq(field(x[i]), steps[i], rcond=None)[0]
        expected = np.linalg.norm(steps[i] - field(x[i]) @ fitted)
        assert field.residual(x[i : i + 1], steps[i : i + 1])[0] == pytest.approx(expected, abs=1e-10)


def test_scale_does_not_matter(sphere):
    samples, edges, frames, features = sphere
    field = train(features, samples, edges, frames, 1e-4)
    larger = train(Features(100 * features.centres, 100 * features.width), 100 * samples, edges, frames, 1e-4)
    assert larger.objective == pytest.approx(field.objective, rel=1e-6)
    # Rounding grows along the descent.
    np.testing.assert_allclose(larger(100 * samples[:5]), 100 * field(samples[:5]), rtol=1e-3, atol=1e-2)


@pytest.mark.parametrize("other", ["constant", "random"])
def test_no_other_start_ends_clearly_lower(sphere, sheet, other):
    for samples, edges, frames, features in (sphere, sheet):
        posed, d = problem(samples, edges, frames, features, 1e-4), frames.shape[2]
        rows = np.random.default_rng(0).integers(posed.steps.shape[1], size=(d, len(features.centres)))
        constant = np.linalg.svd(samples - samples.mean(0), full_matrices=False)[2][:d, None]
        start = posed.steps.T[rows] if other == "random" else np.repeat(constant, rows.shape[1], axis=1)
        value = descent.descend(posed, training.alternate(posed, start, 3), 200)[1][-1]
        assert train(features, samples, edges, frames, 1e-4).objective < 1.05 * value


def test_a_dimension_too_large_stays_finite():
    t = np.linspace(0, 1, 60)
    samples, edges, frames, features = prepared(np.column_stack([t, 2 * t, -t]), 2, 5)
    field = train(features, samples, edges, frames, 1e-5)
    assert np.isfinite(field.weights).all()
    step = field.residual(samples[:5], samples[1:6] - samples[:5])
    np.testing.assert_allclose(step, 0.0, atol=1e-6)


def test_where_all_edges_lie_along_recordings_the_field_spans_the_directions_across_too():
    """Dense recordings side by side over a bent sheet: hardly a neighbour lies in another of them."""
    t = np.linspace(0, 1, 22)
    demos = [np.column_stack([t, np.full(22, y), 0.2 * np.sin(3 * t)]) for y in np.linspace(0, 1, 21)]
    for seed in range(3):
        skill = SkillManifold.fit(demos, dim=2, kernels=10, ridge=1e-5, jobs=1, seed=seed)
        x, y = np.random.default_rng(seed).uniform(size=(2, 300))
        normals = np.column_stack([-0.6 * np.cos(3 * x), 0.0 * x, np.ones(300)])
        tangents = skill.tangent(np.column_stack([x, y, 0.2 * np.sin(3 * x)]))
        assert np.abs(np.einsum("ncd,nc->nd", tangents, normals)).max() < 0.03
