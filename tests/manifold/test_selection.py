"""Cross-validation of the local surfaces and of the field: what is tried, what is left out, what is taken."""

import math

import numpy as np
import pytest
from joblib import parallel_config

import skillfold as sf
from manifold import clouds
from skillfold.manifold import selection, shapes
from skillfold.manifold.anchors import fit_surfaces, held_out_residuals, nearest_others
from skillfold.manifold.graph import align_frames, build_graph
from skillfold.manifold.selection import choose_field
from skillfold.manifold.shapes import LARGEST, Shape, candidate_shapes, choose_shapes, smoothness
from skillfold.manifold.table import Selection, Trial


def silent(stage, share):
    pass


@pytest.mark.parametrize(("n", "d"), [(50, 1), (200, 2), (1000, 3), (5, 1), (2000, 6)])
def test_candidates_have_enough_neighbours_for_their_terms(n, d):
    found = candidate_shapes(n, d, LARGEST)
    assert found
    assert len(set(found)) == len(found)
    for degree, neighbours in found:
        terms = math.comb(d + degree, degree)
        assert 1 <= neighbours <= min(n, LARGEST)
        assert neighbours > terms or found == [Shape(1, n)]
        assert degree <= 2 or terms <= shapes.MOST_TERMS


def test_where_hardly_any_samples_are_left_a_plane_through_all_is_tried():
    assert candidate_shapes(3, 4, LARGEST) == [Shape(1, 3)]


def test_the_shape_taken_predicts_left_out_samples_best_up_to_doubt():
    x = clouds.normalised(clouds.draw_sphere(400, np.random.default_rng(0)))
    found = choose_shapes(x, None, 2, (1, LARGEST), 0, 1, silent)
    trials = found.trials
    most = found.shapes[np.bincount(found.taken).argmax()]
    assert [t.setting for t in trials if t.chosen] == [f"degree {most.degree}, {most.neighbours} neighbours"]
    assert found.residual <= 1.1 * min(t.score for t in trials)
    assert min(s.degree for s in found.shapes) >= 2  # a sphere is bent everywhere
    possible = {f"degree {s.degree}, {s.neighbours} neighbours" for s in candidate_shapes(399, 2, LARGEST)}
    assert {t.setting for t in trials} <= possible
    assert len(trials) > 10


def test_scores_are_winsorised_held_out_residuals():
    """Of so few samples every one is predicted."""
    x = clouds.normalised(clouds.torus(90, np.random.default_rng(0)))
    trials = choose_shapes(x, None, 2, (1, 20), 0, 1, silent).trials
    everything = np.arange(90)
    for trial in trials:
        degree, neighbours = (int(word) for word in trial.setting.replace(",", "").split() if word.isdigit())
        others = nearest_others(x, everything, neighbours, None)
        squares = held_out_residuals(x, everything, others, 2, [degree])[0] ** 2
        expected = np.sqrt(np.minimum(squares, np.quantile(squares, shapes.WINSOR)).mean())
        assert trial.score == pytest.approx(expected, rel=1e-9)


def test_noise_asks_for_larger_neighbourhoods():
    rng = np.random.default_rng(0)
    x = clouds.draw_sphere(800, rng)
    noise = 0.05 * rng.normal(size=x.shape)
    quiet, noisy = (choose_shapes(clouds.normalised(y), None, 2, (1, LARGEST), 0, 1, silent) for y in (x, x + noise))

    def samples_a_coefficient(found):
        return np.mean([smoothness(found.shapes[i], 2) for i in found.taken])

    assert samples_a_coefficient(noisy) > 3 * samples_a_coefficient(quiet)


@pytest.mark.parametrize("noise", [0.01, 0.02, 0.05])
def test_samples_nearer_each_other_than_their_noise_are_averaged(noise):
    """On a circle in three dimensions; the nearest few would predict best, being near in the noise, too."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        circle = clouds.draw_circle(500, rng)
        skill = sf.SkillManifold.fit(circle + noise * rng.normal(size=circle.shape), dim=1, kernels=5, ridge=1e-5)
        off = skill.project(circle[:100])
        off = np.hypot(np.hypot(off[:, 0], off[:, 1]) - 1.0, off[:, 2])
        assert np.sqrt(np.mean(off**2)) < 0.5 * noise


def test_folds_take_smaller_neighbourhoods_than_flat_parts():
    """A noisy sheet that is flat but for a strip that waves."""
    ratios = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        u = rng.uniform(-1, 1, (1000, 2))
        x = np.column_stack([u, 0.3 * np.sin(16 * (u[:, 0] - 0.5)) * (u[:, 0] > 0.5)])
        x += 0.01 * rng.normal(size=(1000, 3))
        found = choose_shapes(x, None, 2, (1, LARGEST), 0, 1, silent)
        smooth = np.array([smoothness(shape, 2) for shape in found.shapes])
        flat, waves = (smooth[found.at(x, x[side])].mean() for side in (u[:, 0] < 0.2, u[:, 0] > 0.6))
        ratios.append(flat / waves)
    assert np.mean(ratios) > 1.25


def test_the_shape_picked_is_as_good_as_the_best_around_by_hand():
    rng = np.random.default_rng(1)
    places, candidates = rng.normal(size=(80, 2)), [Shape(1, 9), Shape(2, 36), Shape(1, 15)]
    squares = {shape: rng.chisquare(1, 80) for shape in candidates}
    squares[candidates[1]][places[:, 0] > 0] *= 6
    picked = shapes._pick(squares, places, 2)
    errors = np.array(list(squares.values()))
    for i in (0, 7, 33):
        near = np.linalg.norm(places - places[i], axis=1).argsort()[: shapes.AROUND]
        gaps = errors[:, near] - errors[errors[:, near].mean(1).argmin(), near]
        good = [g for g in range(3) if gaps[g].mean() <= shapes.DOUBTED * gaps[g].std() / np.sqrt(len(near))]
        assert picked[i] == max((candidates[g] for g in good), key=lambda s: smoothness(s, 2))


def test_one_shape_is_the_best_of_those_about_as_smooth_as_the_smoothest_that_is_as_good():
    rng = np.random.default_rng(2)
    noise, places = rng.chisquare(1, 400), np.zeros((400, 2))
    rough, best, smooth, biased = Shape(2, 60), Shape(3, 150), Shape(2, 100), Shape(1, 90)
    own = {rough: 0.0, best: 0.001, smooth: 0.02, biased: 1.0}  # of these only the last is clearly worse
    squares = {shape: noise + more * rng.uniform(0.5, 1.5, 400) for shape, more in own.items()}
    squares = {shape: errors + 0.5 * rng.normal(size=400) * (shape != biased) for shape, errors in squares.items()}
    good = shapes._as_good(squares, shapes.DOUBTED)
    top = max(smoothness(shape, 2) for shape in good)
    alike = [shape for shape in good if smoothness(shape, 2) * shapes.ALIKE >= top]
    assert biased not in good
    assert shapes._pick_one(squares, places, 2) == 400 * [min(alike, key=lambda shape: squares[shape].mean())]


def test_a_noisy_sheet_bent_alike_everywhere_gets_one_shape_of_wide_neighbourhoods():
    rng = np.random.default_rng(0)
    u = rng.uniform(-1, 1, (1000, 2))
    bent = 0.2 * (u**2).sum(1) + 0.05 * u[:, 0] ** 3
    x = clouds.normalised(np.column_stack([u, bent]) + 0.02 * rng.normal(size=(1000, 3)))
    found = choose_shapes(x, None, 2, (1, LARGEST), 0, 1, silent)
    assert len(found.shapes) == 1
    assert found.shapes[0].neighbours > shapes.MOST * 1000
    assert found.shapes[0].degree >= 2


def test_recordings_are_left_out_whole():
    """Held-out residuals then tell the spread between recordings, not the noise along one."""
    t = np.linspace(0, 1, 60)
    x = np.vstack([np.column_stack([t, np.sin(2 * t) + 0.1 * i]) for i in range(6)])
    by_recording = choose_shapes(x, np.repeat(np.arange(6), 60), 1, (1, 60), 0, 1, silent).residual
    by_sample = choose_shapes(x, None, 1, (1, 60), 0, 1, silent).residual
    assert by_recording > 0.02
    assert by_recording > by_sample


def test_folds_keep_recordings_together():
    edges = np.array([[0, 1], [1, 2], [3, 4], [4, 5], [6, 7]])
    groups = np.array([0, 0, 0, 1, 1, 1, 2, 2])
    np.testing.assert_array_equal(selection._folds(edges, groups, 0), [0, 0, 1, 1, 2])
    random = selection._folds(np.zeros((3000, 2), dtype=int), None, 0)
    assert set(random) == {0, 1, 2}
    assert np.bincount(random).min() > 900


@pytest.fixture(scope="module")
def prepared():
    x = clouds.normalised(clouds.torus(200, np.random.default_rng(0)))
    graph = build_graph(x, 6)
    neighbours = np.linalg.norm(x[:, None] - x, axis=2).argsort(1)[:, :15]
    return x, graph.edges, align_frames(fit_surfaces(x, x, neighbours, 2, 2).tangents, graph)


def test_what_is_given_is_not_chosen(prepared):
    features, ridge, trials = choose_field(*prepared, None, 7, 1e-3, 0, 1, silent)
    assert (len(features.centres), ridge, trials) == (7, 1e-3, [])


def test_the_field_taken_leaves_least_of_held_out_steps(prepared):
    stages = []
    features, ridge, trials = choose_field(*prepared, None, None, None, 0, 1, lambda *stage: stages.append(stage))
    taken = f"{len(features.centres)} kernels"
    expected = [f"{k} kernels, ridge 1e-05" for k in (5, 10, 20, 40)]
    assert [t.setting for t in trials] == [*expected, f"{taken}, ridge 1e-06", f"{taken}, ridge 0.0001"]
    best = min(trials, key=lambda t: t.score)
    assert [t for t in trials if t.chosen] == [best]
    assert best.setting == f"{taken}, ridge {ridge:g}"
    shares = [share for _, share in stages]
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert shares[-1] == 1.0


def test_where_the_number_of_kernels_is_given_the_ridge_alone_is_chosen(prepared):
    features, ridge, trials = choose_field(*prepared, None, 7, None, 0, 1, silent)
    assert [t.setting for t in trials] == [f"7 kernels, ridge {r}" for r in ("1e-05", "1e-06", "0.0001")]
    assert min(trials, key=lambda t: t.score).setting.endswith(f"ridge {ridge:g}")
    assert len(features.centres) == 7


def test_workers_change_nothing(prepared):
    one = choose_field(*prepared, None, None, None, 0, 1, silent)
    two = choose_field(*prepared, None, None, None, 0, 2, silent)
    assert one[1:] == two[1:]
    np.testing.assert_array_equal(one[0].centres, two[0].centres)


@pytest.mark.parametrize("backend", ["sequential", "loky"])
def test_a_backend_of_joblib_takes_over_and_chooses_alike(prepared, backend):
    """Linear algebra runs on fewer threads in other processes, and rounding grows along a descent."""
    plain = choose_field(*prepared, None, None, None, 0, 1, silent)
    with parallel_config(backend=backend, n_jobs=2):
        other = choose_field(*prepared, None, None, None, 0, 2, silent)
    assert plain[1] == other[1]
    for one, two in zip(plain[2], other[2], strict=True):
        assert (one.setting, one.chosen) == (two.setting, two.chosen)
        assert one.score == pytest.approx(two.score, rel=1e-4)
    np.testing.assert_array_equal(plain[0].centres, other[0].centres)


def test_the_table_prints_and_comes_back_from_json():
    table = Selection([Trial("dimension", "d = 1", 2.0, "gap", True), Trial("field", "5 kernels", 0.1, "off", False)])
    assert table.of("field") == (table[1],)
    assert Selection(Trial(*row) for row in table.to_json()) == table
    assert [line[:2] for line in repr(table).splitlines()[1:]] == ["* ", "  "]


def test_where_samples_are_dense_the_surfaces_reach_from_anchor_to_anchor():
    """Noise of dense samples: the nearest few predict each other well and show no surface."""
    rng = np.random.default_rng(4)
    x = clouds.draw_sphere(40_000, rng)
    skill = sf.SkillManifold.fit(x + 0.01 * rng.standard_normal(x.shape), dim=2, kernels=10)
    assert skill.noise == pytest.approx(0.01, rel=0.2)
    anchors = skill.model.centre + skill.model.scale * skill.model.anchors @ skill.model.kept.T
    assert np.median(np.abs(np.linalg.norm(anchors, axis=1) - 1)) < 0.3 * 0.01


@pytest.mark.parametrize("n", [8, 14, 30])
@pytest.mark.parametrize("given", [{}, {"kernels": 5}, {"ridge": 1e-5}, {"kernels": 5, "ridge": 1e-5}])
def test_few_samples_are_learnt_whatever_is_given(n, given):
    x = np.linspace(-1.0, 1.0, n)
    skill = sf.SkillManifold.fit(np.column_stack([x, x**2]), dim=1, **given)
    assert skill.dim == 1 and np.isfinite(skill.distance([0.1, 0.2]))
