"""Bad input to a skill: an error of the library's own that says what was given, never one from inside."""

import numpy as np
import pytest

from manifold import clouds
from manifold.conftest import curves, fit
from skillfold import SkillfoldError, SkillManifold, StateSpace
from skillfold.errors import DisconnectedError, InputError

X = np.zeros(3)
CLOUD = clouds.draw_sphere(100, np.random.default_rng(0))

STATES = {
    "text": "abc",
    "no states": None,
    "a number": 3.0,
    "too few coordinates": [1.0, 2.0],
    "too many": np.zeros((4, 4)),
    "ragged rows": [[1.0, 2.0, 3.0], [1.0]],
    "NaN": [0.0, np.nan, 0.0],
    "infinity": [[0.0, 0.0, 0.0], [0.0, 0.0, -np.inf]],
    "complex": np.array([1j, 0.0, 0.0]),
    "far beyond all numbers of use": [1e300, 0.0, 0.0],
    "objects": [{}, {}, {}],
}
QUESTIONS = {
    "project": lambda skill, x: skill.project(x),
    "project near": lambda skill, x: skill.project(X, near=x),
    "leaf": lambda skill, x: skill.project(x, method="leaf"),
    "distance": lambda skill, x: skill.distance(x),
    "distance_gradient": lambda skill, x: skill.distance_gradient(x),
    "contains": lambda skill, x: skill.contains(x),
    "inside": lambda skill, x: skill.inside(x),
    "tangent": lambda skill, x: skill.tangent(x),
    "plan start": lambda skill, x: skill.plan(x, X),
    "plan goal": lambda skill, x: skill.plan(X, x),
    "plan via": lambda skill, x: skill.plan(X, X, via=x),
    "geodesic_distance": lambda skill, x: skill.geodesic_distance(X, x),
}


OPTIONAL = ("plan via", "project near")  # None means left out there


@pytest.mark.parametrize(
    ("question", "state"), [(q, s) for q in QUESTIONS for s in STATES if s != "no states" or q not in OPTIONAL]
)
def test_states_that_are_none(sphere, question, state):
    with pytest.raises(InputError):
        QUESTIONS[question](sphere, STATES[state])


@pytest.mark.parametrize(
    ("ask", "says"),
    [
        (lambda s: s.distance([0.0, 0.0]), r"\(\.\.\., 3\) of x0, x1, x2.*\(2,\)"),
        (lambda s: s.distance([[0, 0, 0], [0, np.nan, 0]]), r"\(1, 1\) is nan"),
        (lambda s: s.plan(np.zeros((2, 3)), X), r"start: expected one state \(3,\).*\(2, 3\)"),
        (lambda s: s.plan(X, np.zeros((1, 3))), "goal: expected one state"),
        (lambda s: s.plan(X, X, 2), "points=2"),
        (lambda s: s.plan(X, X, 3, via=[X]), "points=3"),
        (lambda s: s.plan(X, X, 20.0), "points=20.0"),
        (lambda s: s.plan(X, X, True), "points=True"),
        (lambda s: s.plan(X, X, "many"), "points='many'"),
        (lambda s: s.plan(X, X, route="fast"), "route='fast'.*geodesic, demonstrated"),
        (lambda s: s.plan(X, X, method="fast"), "method='fast'.*anchored, leaf"),
        (lambda s: s.plan(X, X, route="demonstrated"), "two or more whole recordings"),
        (lambda s: s.plan(X, X, via=[[0.0, 1.0]]), "3"),
        (lambda s: s.project(X, method="fast"), "method='fast'.*anchored, leaf"),
        (lambda s: s.project(np.zeros((2, 3)), near=np.zeros((3, 3))), r"\(2, 3\)"),
        (lambda s: s.project(X, method="leaf", rate=np.nan), "rate=nan"),
        (lambda s: s.project(X, method="leaf", rate="a"), "rate='a'"),
        (lambda s: s.project(X, method="leaf", rate=-0.1), "rate=-0.1"),
        (lambda s: s.project(X, method="leaf", steps=-1), "steps=-1"),
        (lambda s: s.project(X, method="leaf", steps=1.5), "steps=1.5"),
        (lambda s: s.contains(X, "near"), "tolerance='near'"),
        (lambda s: s.contains(X, np.nan), "tolerance=nan"),
        (lambda s: s.contains(X, 10**400), "tolerance=1000"),
        (lambda s: s.sample(-1), "-1"),
        (lambda s: s.sample(2.5), "2.5"),
        (lambda s: s.sample("a"), "'a'"),
        (lambda s: s.sample(True), "True"),
        (lambda s: s.sample(3, seed=-1), "seed=-1"),
        (lambda s: s.sample(3, seed=1.5), "seed=1.5"),
        (lambda s: s.geodesic_distance(np.zeros((2, 3)), np.zeros((3, 3))), r"\(2, 3\)"),
    ],
)
def test_messages_say_what_was_given(sphere, ask, says):
    with pytest.raises(InputError, match=says):
        ask(sphere)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"dim": 0}, "dim=0; expected a whole number from 1 to 2"),
        ({"dim": 3}, "dim=3"),
        ({"dim": 1.5}, "dim=1.5"),
        ({"dim": True}, "dim=True"),
        ({"dim": "2"}, "dim='2'"),
        ({"kernels": 0}, "kernels=0; .* from 1 to 100"),
        ({"kernels": 101}, "kernels=101"),
        ({"ridge": 0}, "ridge=0; expected a"),
        ({"ridge": -1.0}, "ridge=-1"),
        ({"ridge": np.nan}, "ridge=nan"),
        ({"ridge": "a"}, "ridge='a'"),
        ({"neighbors": 0}, "neighbors=0"),
        ({"neighbors": 100}, "neighbors=100"),
        ({"seed": -1}, "seed=-1"),
        ({"seed": 0.5}, "seed=0.5"),
        ({"seed": None}, "seed=None"),
        ({"jobs": 0}, "jobs=0"),
        ({"jobs": "all"}, "jobs='all'"),
        ({"space": StateSpace.linear(2)}, "2 coordinates"),
        ({"space": "linear"}, "StateSpace"),
    ],
)
def test_options_that_cannot_be(options, says):
    with pytest.raises(InputError, match=says):
        SkillManifold.fit(CLOUD, **{"dim": 2, "kernels": 5, "ridge": 1e-5, "jobs": 1, **options})


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (None, "Recordings: got None"),
        (3.0, "Recordings: got 3"),
        ("demos.csv", "Demonstrations.load"),
        ([], "No recordings"),
        (CLOUD[:, :1], "two or more coordinates"),
        (CLOUD[:5], "5 distinct samples of 3 coordinates; 6 at least"),
        (np.ones((50, 3)), "nothing moves"),
        (np.where(CLOUD > 0.9, np.nan, CLOUD), "value nan"),
        ([curves()[0], curves()[1][:, :2]], "2"),
    ],
)
def test_data_that_cannot_be_learnt_from(data, says):
    with pytest.raises(InputError, match=says):
        SkillManifold.fit(data, jobs=1)


def test_data_that_falls_apart_names_its_parts_in_its_own_units():
    with pytest.raises(DisconnectedError, match=r"2 parts: 100 samples; 100 samples") as error:
        fit(np.vstack([CLOUD, CLOUD + 100.0]), 2)
    words = str(error.value).replace(",", " ").split()
    gap = float(words[words.index("gap") + 2])
    assert 160 < gap < 175  # 100 √3, less what the spheres take


def test_every_error_is_a_skillfold_error(sphere):
    assert issubclass(InputError, SkillfoldError)
    assert issubclass(DisconnectedError, SkillfoldError)
    with pytest.raises(SkillfoldError):
        sphere.distance("x")


@pytest.mark.parametrize("options", [{"dim": np.int64(2)}, {"kernels": np.int32(5)}, {"neighbors": 6}, {"ridge": 1}])
def test_numbers_of_every_kind_are_numbers(options):
    assert SkillManifold.fit(CLOUD, **{"dim": 2, "kernels": 5, "ridge": 1e-5, "jobs": 1, **options}).dim == 2


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.longdouble, np.int8])
def test_tolerances_of_every_kind_are_numbers(sphere, kind):
    assert sphere.contains([1.5, 0.0, 0.0], kind(1))


def test_numpy_whole_numbers_are_whole_numbers(sphere):
    x = sphere.sample(np.int64(2))
    assert len(sphere.plan(x[0], x[1], np.int64(12)).path.states) == 12


@pytest.mark.parametrize("via", [None, [], np.empty((0, 3))])
def test_no_via_points_are_none(sphere, via):
    x = sphere.sample(2)
    assert len(sphere.plan(x[0], x[1], 12, via=via).path.states) == 12


def test_integers_and_lists_are_states(sphere):
    assert sphere.distance([1, 0, 0]) == sphere.distance(np.array([1.0, 0.0, 0.0]))
    assert sphere.distance([[1, 0, 0]]).shape == (1,)


def test_a_recording_given_twice_is_no_crash():
    skill = fit([curves()[0], curves()[0]], 1, 5)
    assert skill.distance(curves()[0]).max() < 0.01


def test_a_straight_line_and_a_flat_plane_can_be_learnt():
    t = np.linspace(0, 1, 60)
    line = fit(np.outer(t, [1.0, 2.0, 3.0]), 1, 5)
    np.testing.assert_allclose(line.distance(np.outer([0.3, 0.7], [1.0, 2.0, 3.0])), 0.0, atol=1e-6)
    u = np.random.default_rng(0).uniform(-1, 1, (150, 2))
    plane = fit(np.column_stack([u, u @ [0.5, -0.25]]), 2, 5)
    assert plane.distance([0.1, 0.2, 0.05 - 0.05 + 1.0]) == pytest.approx(1.0 / np.sqrt(1 + 0.25 + 0.0625), rel=1e-4)
