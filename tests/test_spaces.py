import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from skillfold.errors import InputError, SkillFileError
from skillfold.spaces import KINDS, StateSpace

MIXED = StateSpace.linear(2) + StateSpace.continuous(2) + StateSpace.quaternion() + StateSpace.angles(1, -3, 3)
NUMBERS = st.floats(-100, 100)


@st.composite
def spaces(draw):
    parts = st.sampled_from(
        [StateSpace.linear(1), StateSpace.angles(2, -1, 1), StateSpace.continuous(1), StateSpace.quaternion()]
    )
    first, *rest = draw(st.lists(parts, min_size=1, max_size=4))
    return sum(rest, first)


@st.composite
def states_in(draw, space, shape=()):
    values = draw(arrays(np.float64, (*shape, space.n_dims), elements=NUMBERS))
    for block in space.quaternions:
        values[..., block[0]] += np.where(np.linalg.norm(values[..., block], axis=-1) < 1e-3, 1.0, 0.0)
    return space.normalize(values)


@st.composite
def space_and_states(draw, *shapes):
    space = draw(spaces())
    return space, *(draw(states_in(space, shape)) for shape in shapes)


@given(space_and_states((3,), ()))
def test_difference_leads_from_one_state_to_the_other(case):
    space, b, a = case
    step = space.difference(a, b)
    assert step.shape == b.shape
    same = space.align(a + step, b)
    np.testing.assert_allclose(same, b, atol=1e-9)
    np.testing.assert_allclose(space.distance(a, b), np.linalg.norm(step, axis=-1))
    turning = np.array(space.kinds) == "continuous"
    assert (np.abs(step[..., turning]) <= math.pi + 1e-9).all()


@given(space_and_states((2,), (2,)))
def test_distance_is_symmetric_and_zero_between_two_ways_to_write_a_state(case):
    space, a, b = case
    np.testing.assert_allclose(space.distance(a, b), space.distance(b, a), atol=1e-9)
    other = a.copy()
    other[..., np.array(space.kinds) == "continuous"] += 6 * math.pi
    other[..., space.quaternions] *= -1
    np.testing.assert_allclose(space.distance(a, other), 0, atol=1e-9)


@given(space_and_states((2,), (2,)))
def test_align_is_idempotent_and_never_farther(case):
    space, a, b = case
    once = space.align(a, b)
    np.testing.assert_allclose(space.align(once, b), once, atol=1e-9)
    assert (np.linalg.norm(once - b, axis=-1) <= np.linalg.norm(a - b, axis=-1) + 1e-9).all()


@given(space_and_states((6,)))
def test_unwrap_leaves_no_jump_and_changes_no_bit_the_second_time(case):
    space, states = case
    smooth = space.unwrap(states)
    assert np.array_equal(space.unwrap(smooth), smooth)
    assert np.array_equal(smooth[0], states[0])
    np.testing.assert_allclose(space.distance(states, smooth), 0, atol=1e-9)
    np.testing.assert_allclose(space.difference(smooth[:-1], smooth[1:]), np.diff(smooth, axis=0), atol=1e-8)


@given(space_and_states((2, 5)))
def test_unwrap_treats_a_batch_like_each_of_it(case):
    space, states = case
    assert np.array_equal(space.unwrap(states), np.stack([space.unwrap(s) for s in states]))


@given(space_and_states((4,)))
def test_normalize_makes_units_once_and_for_all(case):
    space, states = case
    lengths = np.linalg.norm(states[:, space.quaternions], axis=-1)
    np.testing.assert_allclose(lengths, 1, atol=1e-12)
    assert np.array_equal(space.normalize(states), states)


@given(arrays(np.float64, 4, elements=st.floats(-1e300, 1e300)).filter(lambda q: np.abs(q).max() > 0))
def test_normalize_bears_any_size(q):
    assert np.linalg.norm(StateSpace.quaternion().normalize(q)) == pytest.approx(1)


@given(arrays(np.float64, 3, elements=st.floats(-1e6, 1e6)))
def test_wrap_stays_within_half_a_turn(angles):
    space = StateSpace.continuous(3)
    wrapped = space.wrap(angles)
    assert ((wrapped >= -math.pi) & (wrapped < math.pi)).all()
    assert np.array_equal(space.wrap(wrapped), wrapped)
    np.testing.assert_allclose(space.distance(wrapped, angles), 0, atol=1e-9)


@pytest.mark.parametrize("angle", [math.pi, -math.pi, -1e-20, np.nextafter(math.pi, 4), np.nextafter(-math.pi, -4)])
def test_wrap_at_the_seam(angle):
    assert -math.pi <= StateSpace.continuous(1).wrap([angle])[0] < math.pi


def test_a_path_over_the_seam_and_through_both_signs_has_no_jump():
    turn = np.linspace(0, 4 * math.pi, 50)
    half = turn / 2
    states = np.column_stack(
        [(turn + math.pi) % (2 * math.pi) - math.pi, np.cos(half), *np.zeros((2, 50)), np.sin(half)]
    )
    states[1::2, 1:] *= -1
    space = StateSpace.continuous(1) + StateSpace.quaternion()
    smooth = space.unwrap(states)
    np.testing.assert_allclose(smooth[:, 0], turn, atol=1e-9)
    np.testing.assert_allclose(smooth[:, 1], np.cos(half), atol=1e-9)


def test_contains_knows_limits_units_and_numbers():
    space = StateSpace.angles(1, -1, 2) + StateSpace.quaternion()
    good = [0.0, 1, 0, 0, 0]
    bad = [
        [2.1, 1, 0, 0, 0],
        [0, 1, 1, 0, 0],
        [np.nan, 1, 0, 0, 0],
        [0, 1e300, 1e300, 0, 0],
        [0, np.nan, 0, 0, 0],
    ]
    assert space.contains([good, *bad]).tolist() == [True] + [False] * 5
    assert space.contains([2.05, 1, 0, 0, 0], tolerance=0.1)


def test_constructors_and_select():
    pose = StateSpace.pose()
    assert pose.kinds == ("linear",) * 3 + ("quaternion",) * 4
    assert repr(pose) == "StateSpace(3 linear, 1 quaternion)"
    assert StateSpace.angles(2, [-1, -2], 3).lower == (-1, -2)
    assert pose.select([3, 4, 5, 6, 0]).kinds == ("quaternion",) * 4 + ("linear",)
    assert pose.select([0]).is_flat and not pose.is_flat
    with pytest.raises(InputError, match="one quaternion"):
        pose.select([0, 3])
    with pytest.raises(InputError, match="one quaternion"):
        pose.select([4, 3, 5, 6])
    with pytest.raises(TypeError):
        pose + 3


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: StateSpace(()), "at least one"),
        (lambda: StateSpace(("round",)), "'round'.*linear, angle, continuous, quaternion"),
        (lambda: StateSpace(("quaternion",) * 3), "fours.*got 3"),
        (lambda: StateSpace.linear(0), "above 0, got 0"),
        (lambda: StateSpace.angles(2, 1, 1), "coordinate 0: lower 1 is not below upper 1"),
        (lambda: StateSpace.angles(2, [1, 2, 3]), "3 lower and 2 upper limits for 2"),
        (lambda: StateSpace(("continuous",), (0,)), "is continuous: only linear"),
        (lambda: StateSpace.angles(1, math.nan), "no|not a usable number"),
        (lambda: StateSpace.linear(2).difference([1, 2, 3], [1, 2]), r"\(\.\.\., 2\).*shape \(3,\)"),
        (lambda: StateSpace.linear(1).distance("a", [1]), "numbers"),
        (lambda: StateSpace.linear(2).align(np.zeros((3, 2)), np.zeros((4, 2))), "do not broadcast"),
        (lambda: StateSpace.linear(2).unwrap([1, 2]), r"\(n_steps, 2\)"),
        (lambda: StateSpace.quaternion().normalize(np.zeros(4)), "all zeros"),
    ],
)
def test_mistakes_are_told(make, told):
    with pytest.raises(InputError, match=told):
        make()


@given(spaces())
def test_json_round_trip(space):
    assert StateSpace.from_json(json.loads(json.dumps(space.to_json()))) == space


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.sampled_from(KINDS),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.sampled_from(["kinds", "lower", "upper"]), inner),
    max_leaves=12,
)
ALMOST = st.fixed_dictionaries(
    {
        "kinds": st.lists(st.sampled_from(KINDS) | JSON, max_size=5) | JSON,
        "lower": st.lists(st.none() | st.floats() | st.just(10**400) | JSON, max_size=5) | JSON,
        "upper": st.lists(st.none() | st.floats() | JSON, max_size=5) | JSON,
    }
)


@given(JSON | ALMOST)
def test_hostile_json_is_only_ever_refused(data):
    try:
        space = StateSpace.from_json(data)
    except SkillFileError as error:
        assert "space" in str(error)
    else:
        assert StateSpace.from_json(space.to_json()) == space


def test_a_space_is_a_frozen_value():
    assert StateSpace.linear(2) + StateSpace.linear(1) == StateSpace.linear(3)
    assert hash(MIXED) == hash(StateSpace.from_json(MIXED.to_json()))
    with pytest.raises(AttributeError):
        MIXED.kinds = ()  # type: ignore[misc]
