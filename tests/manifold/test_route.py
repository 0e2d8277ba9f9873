"""The route that whole demonstrations take: laws, known families, part-way ends, via points, degenerate data."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from skillfold.errors import InputError, SkillFileError
from skillfold.manifold.route import Route, RouteAnswer, node_rows
from skillfold.manifold.route_location import ISOTROPIC, between_columns, in_order, misfit, surprise
from skillfold.manifold.route_models import (
    CORRECTED_MEAN,
    DETERMINED,
    MODELS,
    USUAL,
    USUAL_WHOLE,
    kernel,
    left_out_errors,
    predict,
    weigh,
)
from skillfold.manifold.route_phases import at_phases, by_arc_length
from skillfold.motion import Array

PHASE = np.linspace(0.0, 1.0, 400)[:, None]


def arch(a: float, b: float) -> Array:
    """A curve whose shape depends on its ends a and b (heights at x = 0 and x = 2)."""
    height = a * (1 - PHASE) + b * PHASE + (0.5 + 1.5 * (2 * a - b)) * np.sin(np.pi * PHASE)
    return np.hstack([2 * PHASE, height])


def arches(n: int, seed: int = 0) -> list[Array]:
    return [arch(*ends) for ends in np.random.default_rng(seed).uniform(-0.2, 0.2, (n, 2))]


def spirals(n: int, n_dims: int = 3, seed: int = 0) -> list[Array]:
    """Smooth curves with noise in shape and ends, in any number of dimensions."""
    rng = np.random.default_rng(seed)
    base = np.cos(PHASE * (1 + np.arange(n_dims)) * 2) * 2
    bumps = [np.ones_like(PHASE), PHASE, np.sin(3 * PHASE), np.sin(5 * PHASE)]
    return [base + sum(0.1 * bump * rng.normal(size=n_dims) for bump in bumps) for _ in range(n)]


def fitted(recordings: list[Array]) -> Route:
    route = Route.fit(recordings)
    assert route is not None
    return route


def gap(path: Array, truth: Array) -> float:
    """Mean distance at equal arc length."""
    return float(np.linalg.norm(by_arc_length(path, 200) - by_arc_length(truth, 200), axis=1).mean())


def corrected_mean(recordings: list[Array], start: Array, goal: Array) -> Array:
    mean = np.mean([by_arc_length(recording, 200) for recording in recordings], axis=0)
    phase = np.linspace(0.0, 1.0, 200)[:, None]
    return mean + (1 - phase) * (start - mean[0]) + phase * (goal - mean[-1])


def assert_sound(answer: RouteAnswer, start: Array, goal: Array, points: int = 50) -> None:
    assert answer.states.shape == (points, len(start)) and answer.spread.shape == (points,)
    assert np.isfinite(answer.states).all() and np.isfinite(answer.spread).all()
    assert (answer.states[0] == start).all() and (answer.states[-1] == goal).all()
    assert (answer.spread >= 0).all() and answer.spread[0] == answer.spread[-1] == 0
    assert np.isfinite(answer.supported)


# ---------------------------------------------------------------- what is learnt


@pytest.mark.parametrize("n", [5, 7, 10])
def test_shape_follows_the_ends(n: int) -> None:
    recordings = arches(n)
    route = fitted(recordings)
    assert route.model == DETERMINED
    ratios = []
    for truth in arches(15, seed=1):
        answer = route.between(truth[0], truth[-1], 100)
        ratios.append(gap(answer.states, truth) / gap(corrected_mean(recordings, truth[0], truth[-1]), truth))
    assert np.median(ratios) < 0.15


@pytest.mark.parametrize("n", [3, 4, 6])
def test_ends_decide_between_several_ways(n: int) -> None:
    rng = np.random.default_rng(0)

    def way(side: float) -> Array:
        start = side * (1 + 0.05 * rng.normal())
        return np.hstack([PHASE * 3, start * np.cos(PHASE * np.pi / 2) - 1.5 * side * np.sin(np.pi * PHASE)])

    recordings = [way(side) for side in (1, -1, 1, -1, 1, -1)[:n]]
    truth = way(1)
    answer = fitted(recordings).between(truth[0], truth[-1], 100)
    assert gap(answer.states, truth) < 0.1 * gap(corrected_mean(recordings, truth[0], truth[-1]), truth)


def test_noise_gives_the_usual_model_and_an_honest_spread() -> None:
    recordings = spirals(12)
    route = fitted(recordings)
    assert route.model == USUAL
    pulls = []
    for truth in spirals(20, seed=5)[1:]:
        answer = route.between(truth[0], truth[-1], 100)
        away = np.linalg.norm(answer.states - by_arc_length(truth, 100), axis=1)
        pulls.append(away[30:70] / answer.spread[30:70])
    assert 0.4 < np.sqrt(np.mean(np.square(pulls))) < 2.0


@pytest.mark.parametrize("n", [2, 3, 4])
def test_few_demonstrations(n: int) -> None:
    recordings = spirals(n)
    truth = spirals(n + 1)[-1]
    answer = fitted(recordings).between(truth[0], truth[-1])
    assert_sound(answer, truth[0], truth[-1])
    assert gap(answer.states, truth) < 1.5 * gap(corrected_mean(recordings, truth[0], truth[-1]), truth)


def test_too_few_demonstrations() -> None:
    assert Route.fit([]) is None
    assert Route.fit(arches(1)) is None


# ---------------------------------------------------------------- ends, via points, part-way


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(-1e3, 1e3), min_size=6, max_size=6), st.integers(2, 80))
def test_ends_are_exact_wherever_they_are(numbers: list[float], points: int) -> None:
    start, goal = np.array(numbers[:3]), np.array(numbers[3:])
    assert_sound(SPIRALS.between(start, goal, points), start, goal, points)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(-3, 3), min_size=3, max_size=12), st.integers(6, 60))
def test_via_points_are_passed_in_order(numbers: list[float], points: int) -> None:
    via = np.array(numbers[: len(numbers) // 3 * 3]).reshape(-1, 3)
    start, goal = spirals(1)[0][[0, -1]]
    answer = SPIRALS.between(start, goal, points, via)
    assert_sound(answer, start, goal, points)
    rows = iter(answer.states[1:-1])
    assert all(any((row == state).all() for row in rows) for state in via)


def test_a_via_point_helps() -> None:
    ratios = []
    for truth in spirals(10, seed=7):
        ends_only = SPIRALS.between(truth[0], truth[-1], 100)
        via = SPIRALS.between(truth[0], truth[-1], 100, truth[[200]])
        ratios.append(gap(via.states, truth) / gap(ends_only.states, truth))
    assert np.exp(np.mean(np.log(ratios))) < 0.75


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize(("first", "last"), [(80, 300), (120, 399), (0, 250), (200, 320)])
def test_part_way_ends_are_located(first: int, last: int, backwards: bool) -> None:
    truth = arches(9)[4]
    recordings = arches(9)[:4] + arches(9)[5:]
    lengths = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(truth, axis=0), axis=1))])
    phases = lengths[[first, last]] / lengths[-1]
    stretch = truth[first : last + 1]
    if backwards:
        stretch, phases = stretch[::-1], phases[::-1]
    answer = fitted(recordings).between(stretch[0], stretch[-1], 100)
    assert answer.reversed == backwards
    assert abs(answer.start_phase - phases[0]) < 0.08 and abs(answer.goal_phase - phases[1]) < 0.08
    whole = corrected_mean(recordings, stretch[0], stretch[-1])
    assert gap(answer.states, stretch) < 0.25 * gap(whole, stretch)


def test_whole_motions_win() -> None:
    """Left-out demonstrations are whole motions, though they start outside what was shown."""
    for recordings in (arches(8), spirals(8), spirals(8, 2, seed=3)):
        for i, truth in enumerate(recordings):
            answer = fitted(recordings[:i] + recordings[i + 1 :]).between(truth[0], truth[-1])
            assert (answer.start_phase, answer.goal_phase, answer.reversed) == (0.0, 1.0, False)


@pytest.mark.parametrize("turns", [1, 2])
def test_closed_and_crossing_shapes_are_whole(turns: int) -> None:
    rng = np.random.default_rng(0)
    angle = 2 * np.pi * PHASE

    def loop() -> Array:
        return np.hstack([np.sin(angle), np.sin(turns * angle) + np.cos(angle)]) + 0.05 * rng.normal(size=2)

    recordings, truth = [loop() for _ in range(6)], loop()
    answer = fitted(recordings).between(truth[0], truth[-1], 100)
    assert (answer.start_phase, answer.goal_phase, answer.reversed) == (0.0, 1.0, False)
    assert gap(answer.states, truth) < 0.1
    # A via point tells that the loop is meant the other way round.
    quarter, three_quarters = truth[100], truth[300]
    there = fitted(recordings).between(truth[0], truth[-1], 100, np.array([quarter, three_quarters]))
    back = fitted(recordings).between(truth[0], truth[-1], 100, np.array([three_quarters, quarter]))
    assert not there.reversed and back.reversed
    assert gap(back.states, truth[::-1]) < 0.15


def test_support_tells_how_far_the_ends_are() -> None:
    start, goal = spirals(1)[0][[0, -1]]
    near = SPIRALS.between(start, goal).supported
    far = SPIRALS.between(start + 3.0, goal).supported
    assert near < 2 < 5 < far


def test_noise_of_a_common_start_is_not_extrapolated() -> None:
    rng = np.random.default_rng(0)
    recordings = [r - (1 - PHASE) * (r[0] - 1e-6 * rng.normal(size=3)) for r in spirals(8)]
    mean = np.mean(recordings, axis=0)
    start, goal = np.array([0.3, 0.2, -0.1]), mean[-1]
    answer = fitted(recordings).between(start, goal, 100)
    assert gap(answer.states, corrected_mean(recordings, start, goal)) < 0.3


# ---------------------------------------------------------------- laws

SPIRALS = fitted(spirals(8))
QUERIES = [
    pytest.param(0, 399, [], id="whole"),
    pytest.param(120, 330, [], id="part-way"),
    pytest.param(330, 120, [], id="backwards"),
    pytest.param(0, 399, [150, 250], id="via"),
]


@pytest.mark.parametrize(("first", "last", "via"), QUERIES)
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), log_scale=st.floats(-6, 6))
def test_similarities_commute(first: int, last: int, via: list[int], seed: int, log_scale: float) -> None:
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    shift, factor = rng.normal(size=3), 10.0**log_scale

    def move(states: Array) -> Array:
        return factor * (states @ turn.T + shift)

    truth = spirals(1, seed=9)[0]
    plain = SPIRALS.between(truth[first], truth[last], 40, truth[via])
    moved = fitted([move(r) for r in spirals(8)]).between(move(truth[first]), move(truth[last]), 40, move(truth[via]))
    np.testing.assert_allclose(moved.states, move(plain.states), rtol=0, atol=1e-9 * factor)
    np.testing.assert_allclose(moved.spread, factor * plain.spread, rtol=1e-6, atol=1e-9 * factor)
    assert moved.start_phase == plain.start_phase and moved.goal_phase == plain.goal_phase
    assert moved.reversed == plain.reversed


@pytest.mark.parametrize(("first", "last", "via"), QUERIES)
def test_order_of_demonstrations_does_not_matter(first: int, last: int, via: list[int]) -> None:
    truth = spirals(1, seed=9)[0]
    plain = SPIRALS.between(truth[first], truth[last], 40, truth[via])
    other = fitted(spirals(8)[::-1]).between(truth[first], truth[last], 40, truth[via])
    np.testing.assert_allclose(other.states, plain.states, rtol=0, atol=1e-9)


def test_same_input_same_bits_and_round_trip() -> None:
    start, goal = arches(1, seed=3)[0][[0, -1]]
    route, again = fitted(arches(7)), fitted(arches(7))
    back = Route.from_arrays(route.arrays())
    assert back.model == route.model
    answer = route.between(start, goal)
    for other in (again.between(start, goal), back.between(start, goal)):
        assert (other.states == answer.states).all() and (other.spread == answer.spread).all()
        assert (other.start_phase, other.supported) == (answer.start_phase, answer.supported)
    for name, array in route.arrays().items():
        assert (back.arrays()[name] == array).all()


@pytest.mark.parametrize(
    "damage",
    [
        {"curves": np.zeros((3, 101))},
        {"curves": np.zeros((1, 101, 2))},
        {"curves": np.zeros((7, 0, 2)), "squared_spread": np.zeros(0)},
        {"centre": np.zeros(3)},
        {"centre": np.array([np.nan, 0.0])},
        {"scale": np.array(0.0)},
        {"squared_spread": np.ones(5)},
        {"model": np.ones(3)},
        {"model": np.array([1, 1, 0.5, 0.5, 0.0, 1, 1])},
        {"model": np.array([1, 1, 0.5, 0.5, 1.5, -1, 1])},
    ],
)
def test_damaged_arrays_are_refused(damage: dict[str, Array]) -> None:
    arrays = fitted(arches(7)).arrays() | damage
    with pytest.raises(SkillFileError):
        Route.from_arrays(arrays)
    with pytest.raises(SkillFileError):
        Route.from_arrays({name: a for name, a in arrays.items() if name not in damage})


# ---------------------------------------------------------------- degenerate data


@pytest.mark.parametrize("n", [2, 3, 5, 8])
@pytest.mark.parametrize(
    "change",
    [
        pytest.param(lambda r: r + 1e6, id="far away"),
        pytest.param(lambda r: r * 1e-6, id="tiny"),
        pytest.param(lambda r: r * np.array([1.0, 0.0, 1.0]), id="one coordinate constant"),
        pytest.param(lambda r: r - r[-1], id="one common goal"),
        pytest.param(lambda r: r - r[-1] - (1 - PHASE) * (r[0] - r[-1] - 1.0), id="common ends"),
        pytest.param(lambda r: spirals(1)[0], id="all the same"),
        pytest.param(lambda r: np.repeat(r[:1], 20, axis=0), id="at rest"),
        pytest.param(lambda r: np.full((5, 3), 1e6 / 3), id="all at rest in one place"),
        pytest.param(lambda r: r[:1], id="one sample"),
        pytest.param(lambda r: r[[0, 399]], id="two samples"),
        pytest.param(lambda r: np.repeat(r[::7], 9, axis=0), id="pauses"),
        pytest.param(lambda r: np.concatenate([r, r[::-1]]), id="there and back"),
    ],
)
def test_degenerate_recordings(n: int, change) -> None:
    recordings = [change(r) for r in spirals(n)]
    route = fitted(recordings)
    size = np.ptp(np.concatenate(recordings), axis=0).max() or 1.0
    start, goal = recordings[0][0], recordings[-1][-1]
    middle = recordings[1][len(recordings[1]) // 2]
    for a, b in [(start, goal), (start + 0.1 * size, goal - 0.1 * size), (goal, start), (middle, goal)]:
        assert_sound(route.between(a, b), a, b)
        assert_sound(route.between(a, b, via=middle[None] + 0.01 * size), a, b)
    answer = route.between(start, goal)
    assert np.abs(answer.states - recordings[0].mean(axis=0)).max() < 5 * size


@pytest.mark.parametrize("n_dims", [1, 2, 7, 12])
def test_any_number_of_dimensions(n_dims: int) -> None:
    truth = spirals(1, n_dims, seed=2)[0]
    answer = fitted(spirals(7, n_dims)).between(truth[0], truth[-1], 30)
    assert_sound(answer, truth[0], truth[-1], 30)


def test_resting_noise_takes_no_phase() -> None:
    rng = np.random.default_rng(0)
    moving = np.hstack([PHASE, PHASE**2])
    resting = np.repeat(moving[-1:], 2000, axis=0) + 1e-4 * rng.normal(size=(2000, 2))
    curve = by_arc_length(np.concatenate([moving, resting]), 101)
    assert np.abs(curve - by_arc_length(moving, 101)).max() < 0.05


@pytest.mark.parametrize("at", [0, 150, 399])
def test_pauses_are_no_part_of_the_way(at: int) -> None:
    moving = spirals(1)[0]
    paused = np.insert(moving, [at] * 3000, moving[at], axis=0)
    np.testing.assert_array_equal(by_arc_length(paused, 101), by_arc_length(moving, 101))


# ---------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"start": [0.0, 1.0]}, "start: expected 3"),
        ({"goal": [0.0, 1.0, np.nan]}, "goal: expected 3 finite"),
        ({"via": np.zeros((2, 2))}, r"via\[0\]: expected 3"),
        ({"points": 1}, "2 given states"),
        ({"points": 4, "via": np.zeros((3, 3))}, "5 given states"),
    ],
)
def test_bad_queries(arguments: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        SPIRALS.between(**({"start": [0.0] * 3, "goal": [1.0] * 3} | arguments))


def test_too_few_phases() -> None:
    with pytest.raises(InputError, match="n_phases"):
        Route.fit(arches(3), n_phases=5)


# ---------------------------------------------------------------- parts against plain readings


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 3), st.integers(2, 3), st.integers(4, 7), st.integers(0, 10**6))
def test_in_order_against_all_choices(b: int, m: int, n_phases: int, seed: int) -> None:
    costs = np.random.default_rng(seed).uniform(size=(b, m, n_phases))
    columns, total = in_order(costs)
    for k in range(b):
        sums = [
            (sum(costs[k, row, c] for row, c in enumerate(chosen)), chosen)
            for chosen in itertools.combinations(range(n_phases), m)
        ]
        assert columns[k].tolist() == list(min(sums)[1])
        assert total[k] == pytest.approx(min(sums)[0])


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(0.01, 0.99), max_size=6), st.integers(8, 60))
def test_node_rows_increase(between: list[float], points: int) -> None:
    phases = np.array([0.0, *sorted(set(between)), 1.0])
    rows = node_rows(phases, points)
    assert rows[0] == 0 and rows[-1] == points - 1 and (np.diff(rows) > 0).all()


def test_misfit_of_one_demonstration_is_the_squared_distance() -> None:
    squared = np.random.default_rng(0).uniform(size=(1, 2, 9))
    np.testing.assert_allclose(misfit(squared, 0.5), squared[0] / 0.5)


def test_surprise_is_the_gaussian_likelihood_of_a_shrunk_covariance() -> None:
    rng = np.random.default_rng(0)
    # Equal errors at all phases, so that averaging over phases changes nothing.
    errors = np.repeat(rng.normal(size=(6, 1, 3)), 30, axis=1)
    gaps = rng.normal(size=(2, 30, 3))
    summed = errors[:, 0].T @ errors[:, 0]
    isotropic = (1.01 * np.trace(summed) / 18 + 1e-4 / 3) * np.eye(3)
    law = multivariate_normal(cov=(summed + ISOTROPIC * isotropic) / (6 + ISOTROPIC))
    np.testing.assert_allclose(surprise(gaps, errors), -2 * law.logpdf(gaps) - 3 * np.log(2 * np.pi), rtol=1e-9)


@settings(max_examples=50, deadline=None)
@given(st.sets(st.integers(1, 28), max_size=8), st.integers(0, 10**6))
def test_between_columns_keeps_the_order(inner: set[int], seed: int) -> None:
    columns = np.array([0, *sorted(inner), 29])
    refined = between_columns(np.random.default_rng(seed).uniform(0, 9, (len(columns), 30)), columns)
    assert refined[0] == 0 and refined[-1] == 29 and (np.diff(refined) > 0).all()


def test_between_columns_is_the_expected_phase() -> None:
    wanted, grid = 17.3, np.arange(40)
    costs = np.tile((grid - wanted) ** 2 / 4.0, (3, 1))
    assert between_columns(costs, np.array([0, 17, 39]))[1] == pytest.approx(wanted, abs=1e-3)


def test_a_via_point_beside_the_route_is_located_by_how_errors_go_together() -> None:
    """Demonstrations that swing out are also ahead there: a state beside the route is ahead of its foot on it."""

    def swung(side: float) -> Array:
        along = PHASE + 0.12 * side * np.sin(np.pi * PHASE)
        return np.hstack([3 * along, 0.5 * side * np.sin(np.pi * along)])

    rng = np.random.default_rng(0)
    route = fitted([swung(side) for side in rng.normal(size=12)])
    truth = swung(1.0)
    given = route.between(truth[0], truth[-1], 101, truth[[200]])
    ends_only = route.between(truth[0], truth[-1], 101)
    assert gap(given.states, truth) < 0.2 * gap(ends_only.states, truth)


def test_at_phases_reads_between_rows() -> None:
    curves = np.random.default_rng(0).normal(size=(3, 11, 2))
    phases = np.random.default_rng(1).uniform(size=(3, 7))
    grid = np.linspace(0, 1, 11)
    plain = [[[np.interp(p, grid, c[:, d]) for d in range(2)] for p in row] for c, row in zip(curves, phases)]  # noqa: B905
    np.testing.assert_allclose(at_phases(curves, phases), plain)


@pytest.mark.parametrize("model", MODELS)
def test_weights_solve_the_kriging_system(model) -> None:
    rng = np.random.default_rng(0)
    own = rng.normal(size=(6, 4))
    own -= own.mean(axis=0)
    wanted = rng.normal(size=4)
    weights, variance, q = weigh(model, own, wanted)
    assert weights.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(q @ np.ones(6), 0, atol=1e-9)
    if not model.kriged:
        return
    scale = np.sqrt((own**2).sum() / 6)
    system = np.ones((7, 7))
    system[:6, :6] = kernel(model, own / scale, own / scale) + model.nugget * np.eye(6)
    system[6, 6] = 0
    k = np.append(kernel(model, wanted[None] / scale, own / scale)[0], 1.0)
    solution = np.linalg.solve(system, k)
    np.testing.assert_allclose(weights, solution[:6], atol=1e-9)
    itself = kernel(model, wanted[None] / scale, wanted[None] / scale)[0, 0] + model.nugget
    assert variance == pytest.approx(itself - solution @ k)


@pytest.mark.parametrize("n", [3, 5, 25])
def test_left_out_errors_are_those_of_plain_predictions(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    curves = np.stack([by_arc_length(recording, 21) for recording in spirals(n)])
    curves[:, 0] = curves[0, 0]  # all start at home
    nodes = np.array([0, 20])
    plain = []
    for model in MODELS:
        logs = []
        for i in np.unique(np.linspace(0, n - 1, 20).astype(int)):
            states, _ = predict(model, np.delete(curves, i, axis=0), nodes, curves[i, nodes])
            logs.append(np.log(np.linalg.norm(states - curves[i], axis=1).mean()))
        plain.append(np.mean(logs))
    np.testing.assert_allclose(left_out_errors(MODELS, curves), plain, atol=1e-9)
    monkeypatch.setattr("skillfold.manifold.route_models.AT_ONCE", 1)
    np.testing.assert_allclose(left_out_errors(MODELS, curves), plain, atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_conditions_that_tell_nothing_weigh_all_alike(model) -> None:
    weights, variance, q = weigh(model, np.zeros((5, 4)), np.zeros(4))
    np.testing.assert_allclose(weights, 0.2)
    # A mean of five is off by the fifth of a variance, and what it is to predict by one.
    np.testing.assert_allclose(variance * q.diagonal(), 1.2 * 0.8)


def test_ends_of_whole_motions_are_believed_less() -> None:
    route = replace(fitted(spirals(6)), model=USUAL)
    truth = spirals(1, seed=3)[0]

    def expected(model, shares: Array, states: Array) -> Array:
        curves = at_phases(route.curves, np.tile(shares, (6, 1)))
        asked = (states - route.centre) / route.scale
        return predict(model, curves, np.array([0, 100]), asked)[0] * route.scale + route.centre

    whole = route.between(truth[0], truth[-1], 101)
    assert (whole.start_phase, whole.goal_phase) == (0.0, 1.0)
    plain = expected(USUAL_WHOLE, np.linspace(0, 1, 101), truth[[0, -1]])
    np.testing.assert_allclose(whole.states, plain, atol=1e-9)


def test_left_out_residuals_by_one_matrix() -> None:
    rng = np.random.default_rng(0)
    own, values = rng.normal(size=(6, 4)), rng.normal(size=6)
    own -= own.mean(axis=0)
    scale = np.sqrt((own**2).sum() / 6)
    _, _, q = weigh(USUAL, own, own[0])
    rest = np.arange(1, 6)
    system = np.ones((6, 6))
    system[:5, :5] = kernel(USUAL, own[rest] / scale, own[rest] / scale) + USUAL.nugget * np.eye(5)
    system[5, 5] = 0
    solution = np.linalg.solve(system, np.append(kernel(USUAL, own[:1] / scale, own[rest] / scale)[0], 1.0))
    assert (q @ values)[0] / q[0, 0] == pytest.approx(values[0] - solution[:5] @ values[rest])


def test_corrected_mean_is_the_plainest_model() -> None:
    recordings = spirals(6)
    route = replace(fitted(recordings), model=CORRECTED_MEAN)
    start, goal = spirals(1, seed=4)[0][[0, -1]]
    curves = route.curves * route.scale + route.centre
    states, _ = predict(CORRECTED_MEAN, curves, np.array([0, 100]), np.stack([start, goal]))
    mean, phase = curves.mean(axis=0), np.linspace(0, 1, 101)[:, None]
    plain = mean + (1 - phase) * (start - mean[0]) + phase * (goal - mean[-1])
    np.testing.assert_allclose(states, plain, atol=1e-12)
    np.testing.assert_allclose(route.between(start, goal, 101).states, plain, atol=1e-12)
