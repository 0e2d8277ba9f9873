import math
import sys

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import skillfold as sf
from skillfold.errors import InputError, MissingExtraError, RecordingError, SkillfoldError

LINE = np.column_stack([np.linspace(0, 1, 11), np.zeros(11)])
T = np.linspace(0, 2, 11)


def wave(n, turns=1.0, shift=0.0):
    s = np.linspace(0, 1, n)
    return np.column_stack([s + shift, np.sin(2 * math.pi * turns * s)])


@st.composite
def paths(draw, n_dims=2, min_steps=2):
    n = draw(st.integers(min_steps, 12))
    states = draw(arrays(np.float64, (n, n_dims), elements=st.floats(-1e3, 1e3, width=32)))
    assume(np.ptp(states, axis=0).max() > 1e-3)
    return states


# Building


def test_one_array_a_list_and_a_block_are_recordings():
    assert len(sf.Demonstrations(LINE)) == 1
    several = sf.Demonstrations([LINE, wave(7)], times=[T, None], names=["x", "y"], labels=["a", "b"])
    assert several.lengths.tolist() == [11, 7] and several.states.shape == (18, 2)
    assert several[1].times is None and several[0].times is not None
    assert [d.label for d in several] == ["a", "b"]
    block = sf.Demonstrations(np.stack([LINE, LINE]), times=T)
    assert block.ends.shape == (2, 2, 2) and block.n_dims == 2
    assert repr(several) == "Demonstrations(2 of 7–11 states, x, y; StateSpace(2 linear), no times)"
    assert repr(block) == "Demonstrations(2 of 11 states, x0, x1; StateSpace(2 linear), timed)"
    assert repr(block[0]) == "Demonstration('0': 11 states of 2 coordinates, 2 s)"


def test_what_is_given_is_copied_and_kept_from_changes():
    states = LINE.copy()
    demos = sf.Demonstrations(states)
    states[:] = 7
    assert demos.states.max() == 1
    with pytest.raises(ValueError, match="read-only"):
        demos[0].states[0] = 1
    with pytest.raises(AttributeError):
        demos.names = ("a",)  # type: ignore[misc]


def test_integers_short_floats_and_nested_lists_are_numbers_too():
    assert sf.Demonstrations([[[0, 1], [2, 3]]]).states.dtype == np.float64
    assert sf.Demonstrations(np.arange(6, dtype=np.float16).reshape(3, 2)).states.dtype == np.float64


def spoiled(row, column, value):
    states = LINE.copy().astype(object if isinstance(value, str) else float)
    states[row, column] = value
    return states


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"recordings": spoiled(3, 1, np.nan)}, "demonstration '0', row 3 .*column '1': value nan; .*finite"),
        (
            {"recordings": [LINE, spoiled(4, 0, np.inf)], "names": ["x", "y"]},
            "'1', row 4 .*column 'x': value inf",
        ),
        ({"recordings": spoiled(3, 1, 1e200)}, "row 3.*value 1e\\+200.*below 1e\\+100"),
        ({"recordings": spoiled(5, 1, "fast")}, "row 5, column 1 .*value 'fast'; expected a number"),
        ({"recordings": [[[0, 1], [2]]]}, "row 1 .*has 1 values, row 0 has 2"),
        ({"recordings": [[[0, 1], [2, None]]]}, "row 1, column 1 .*value None"),
        ({"recordings": LINE * 1j}, "value .*j; expected a number"),
        ({"recordings": np.ma.masked_less(LINE, 0.5)}, "masked"),
        ({"recordings": LINE[:1]}, "1 samples; expected two"),
        ({"recordings": LINE[:0]}, "0 samples; expected two"),
        ({"recordings": np.zeros((5, 0))}, "no coordinates"),
        ({"recordings": [LINE[:, 0]]}, r"shape \(11,\).*x\[:, None\]"),
        ({"recordings": LINE[:, 0]}, "expected an array"),
        ({"recordings": "demos.csv"}, r"'demos.csv'.*Demonstrations.load\(path\)"),
        ({"recordings": []}, "No recordings"),
        ({"recordings": [LINE, wave(5)[:, :1]]}, "'1': 1 columns, but demonstration '0' has 2"),
        ({"recordings": np.ones((4, 2))}, r"nothing moves; all 4 samples are \[1.0, 1.0\]"),
        ({"recordings": LINE, "names": ["x"]}, "2 columns; expected 1: x"),
        ({"recordings": LINE, "names": ["x", "x"]}, "'x' appears twice"),
        ({"recordings": LINE, "names": ["x", ""]}, "name 2 is ''"),
        ({"recordings": LINE, "names": "xy"}, "'xy'.*list"),
        ({"recordings": LINE, "labels": ["a", "b"]}, "one for each of the 1 recordings"),
        ({"recordings": [LINE, LINE], "labels": ["a", "a"]}, "label 'a' appears twice"),
        ({"recordings": LINE, "times": T[:5]}, "5 times for 11 states"),
        ({"recordings": LINE, "times": T[::-1]}, "row 1 .*'time': value 1.8 after 2; .*increase"),
        ({"recordings": LINE, "times": np.where(T == 1, np.nan, T)}, "row 5 .*'time': value nan"),
        ({"recordings": LINE, "times": 0.1}, "times: got 0.1"),
        ({"recordings": [LINE, LINE], "times": [T]}, "times: expected one for each of the 2"),
        ({"recordings": LINE, "space": sf.StateSpace.pose()}, "has 7 coordinates, the recordings 2: x0, x1"),
        ({"recordings": LINE, "space": 2}, "expected a StateSpace"),
        (
            {"recordings": LINE * 180, "space": sf.StateSpace.angles(2, -3, 3)},
            "'x0': value 18 outside.*-3 to 3.*radians",
        ),
        (
            {"recordings": np.eye(4), "names": ["qx", "qy", "qz", "qw"]},
            "scalar first.*qw, qx",
        ),
    ],
)
def test_bad_input_is_told_with_its_place(arguments, told):
    with pytest.raises(RecordingError, match=told):
        sf.Demonstrations(**arguments)


SCRAPS = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=3) | st.complex_numbers(),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.tuples(inner, inner)
        | st.dictionaries(st.text(max_size=2), inner, max_size=2)
    ),
    max_leaves=15,
)


@given(SCRAPS, SCRAPS, SCRAPS, SCRAPS)
def test_anything_at_all_is_taken_or_refused_in_words(recordings, times, names, labels):
    with_defaults = {"times": times, "names": names, "labels": labels}
    for arguments in ({}, with_defaults):
        try:
            sf.Demonstrations(recordings, **arguments)
        except SkillfoldError as error:
            assert str(error)


@given(SCRAPS, SCRAPS, SCRAPS)
def test_any_times_names_and_labels_beside_good_recordings(times, names, labels):
    for arguments in ({"times": times}, {"names": names}, {"labels": labels}):
        try:
            sf.Demonstrations([LINE, LINE], **arguments)
        except SkillfoldError as error:
            assert str(error)


# Consistency


def turning(n=21, flip=()):
    half = np.linspace(0, 1.2, n)
    states = np.column_stack([np.cos(half), np.sin(half), *np.zeros((2, n))])
    states[list(flip)] *= -1
    return states


def test_quaternion_signs_agree_along_and_across():
    demos = sf.Demonstrations(
        [turning(), turning(flip=range(0, 21, 2)), -turning(15)],
        names=["tool_qw", "tool_qx", "tool_qy", "tool_qz"],
    )
    assert demos.space == sf.StateSpace.quaternion()
    assert np.array_equal(demos[0].states, demos[1].states)
    assert (np.sum(demos[2].states * demos[0].states[0], axis=1) > 0).all()


def test_quaternions_are_normalised_when_near_and_refused_when_far():
    near = sf.Demonstrations(turning() * 1.005, space=sf.StateSpace.quaternion())
    np.testing.assert_allclose(np.linalg.norm(near.states, axis=1), 1)
    far = turning()
    far[4] *= 1.1
    with pytest.raises(RecordingError, match=r"row 4 .*columns x0, x1, x2, x3: quaternion .*of length 1.1; .*0.01"):
        sf.Demonstrations(far, space=sf.StateSpace.quaternion())


def test_continuous_angles_are_unwrapped_along_and_aligned_across():
    space = sf.StateSpace.continuous(1)
    turn = np.linspace(3, 9, 30)[:, None]
    demos = sf.Demonstrations([space.wrap(turn), space.wrap(turn) + 4 * math.pi], space=space)
    for d in demos:
        np.testing.assert_allclose(d.states, turn, atol=1e-9)


@given(paths(6), paths(6))
def test_building_again_from_what_was_built_changes_no_bit(a, b):
    space = sf.StateSpace.continuous(2) + sf.StateSpace.quaternion()
    for states in (a, b):
        states[:, 2] += 2e3
    recordings = [space.normalize(a), space.normalize(b)]
    try:
        once = sf.Demonstrations(recordings, space=space)
        # Of a recording that hardly moves but for full turns, unwrapping may leave none.
        again = sf.Demonstrations([d.states for d in once], space=space)
    except RecordingError as error:
        assert "nothing moves" in str(error)
        return
    assert np.array_equal(again.states, once.states)


# Resampling and alignment


@given(paths(3), st.integers(2, 30), st.sampled_from(["arc length", "time"]))
def test_resampling_keeps_the_ends_and_stays_within(states, n, by):
    times = np.cumsum(np.linspace(0.5, 1.5, len(states)))
    demos = sf.Demonstrations(states, times=times)
    try:
        short = demos.resample(n, by)
    except RecordingError as error:  # the two ends of a closed path are one point
        assert "nothing moves" in str(error)
        return
    assert short.lengths.tolist() == [n]
    assert np.array_equal(short.ends, demos.ends)
    assert (short.states >= states.min(axis=0) - 1e-9).all() and (short.states <= states.max(axis=0) + 1e-9).all()
    assert short[0].times is not None and short[0].times[[0, -1]].tolist() == times[[0, -1]].tolist()


def test_resampling_is_even_and_hardly_changes_the_second_time():
    once = sf.Demonstrations(wave(4000)).resample(400)
    steps = np.linalg.norm(np.diff(once.states, axis=0), axis=1)
    assert np.ptp(steps) < 0.02 * steps.mean()
    np.testing.assert_allclose(once.resample(400).states, once.states, atol=1e-3)


def test_resampling_by_time_is_even_in_time():
    uneven = np.linspace(0, 1, 11) ** 2 * 2
    demos = sf.Demonstrations(np.column_stack([uneven, 0 * uneven]), times=uneven).resample(21, by="time")
    np.testing.assert_allclose(demos.states[:, 0], np.linspace(0, 2, 21), atol=1e-12)
    np.testing.assert_allclose(demos[0].times, np.linspace(0, 2, 21), atol=1e-12)


def test_a_pause_takes_no_length():
    paused = np.repeat(LINE, 4, axis=0)
    np.testing.assert_allclose(sf.Demonstrations(paused).resample(11).states, LINE, atol=1e-12)


def test_resampled_quaternions_are_units():
    coarse = sf.Demonstrations(turning(3), space=sf.StateSpace.quaternion()).resample(50)
    np.testing.assert_allclose(np.linalg.norm(coarse.states, axis=1), 1, atol=1e-12)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda d: d.resample(1), "n_steps=1; .*two at least"),
        (lambda d: d.resample(2.5), "n_steps=2.5"),
        (lambda d: d.resample(5, by="speed"), "'speed'; possible: 'arc length', 'time'"),
        (lambda d: d.resample(5, by="time"), "by='time' needs times.*'0' has none"),
        (lambda d: d.with_velocity(), r"with_velocity\(\) needs times"),
        (lambda d: d.with_phase(0), "scale=0"),
        (lambda d: d.with_phase("big"), "scale='big'"),
        (lambda d: d.with_phase(10**400), "scale=1000"),
        (lambda d: d.with_phase(math.nan), "scale=nan"),
        (lambda d: d.with_phase().with_phase(), "'phase' appears twice"),
        (lambda d: d.align(3), "No demonstration 3; there are 1"),
        (lambda d: d.leave_out(0), "only one"),
        (lambda d: d.select(["z"]), "No column 'z'; possible: x0, x1"),
        (lambda d: d.select([]), "at least one"),
    ],
)
def test_mistaken_calls_are_told(call, told):
    with pytest.raises(InputError, match=told):
        call(sf.Demonstrations(wave(9)))


def test_warping_brings_recordings_to_one_pace():
    s = np.linspace(0, 1, 120)
    slow_start = np.column_stack([s**2, np.sin(2 * math.pi * s**2)])
    demos = sf.Demonstrations([wave(100), slow_start], times=[np.arange(100.0), np.arange(120.0)]).align()
    assert demos.lengths.tolist() == [100, 100]
    assert np.abs(demos[0].states - demos[1].states).max() < 0.05
    assert np.array_equal(demos[0].times, demos[1].times)
    assert np.array_equal(demos[1].states[[0, -1]], slow_start[[0, -1]])


def test_warping_one_coordinate_and_orientations():
    one = sf.Demonstrations([wave(50)[:, 1:], wave(70)[:, 1:]]).align(1)
    assert one.lengths.tolist() == [70, 70]
    turned = sf.Demonstrations([turning(20), turning(33)], space=sf.StateSpace.quaternion()).align()
    np.testing.assert_allclose(np.linalg.norm(turned.states, axis=1), 1, atol=1e-12)


def test_warping_without_the_compiled_part_is_the_same(monkeypatch):
    from dtaidistance import dtw

    demos = sf.Demonstrations([wave(20), wave(26, shift=0.1)])
    compiled = demos.align().states
    monkeypatch.setattr(dtw, "dtw_cc", None)
    np.testing.assert_allclose(demos.align().states, compiled)


def test_a_missing_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "dtaidistance", None)
    with pytest.raises(MissingExtraError, match=r"skillfold\[dtw\]"):
        sf.Demonstrations([LINE, LINE]).align()


# Velocity, phase, columns


def test_velocities_are_per_second():
    demos = sf.Demonstrations(LINE, times=T, names=["x", "y"]).with_velocity()
    assert demos.names == ("x", "y", "x_velocity", "y_velocity")
    np.testing.assert_allclose(demos.states[:, 2], 0.5)
    assert demos.space == sf.StateSpace.linear(4)


def test_velocities_beyond_numbers_are_refused():
    with pytest.raises(RecordingError, match=r"x_velocity.*value"):
        sf.Demonstrations(LINE * 1e60, times=T * 1e-60, names=["x", "y"]).with_velocity()


def test_phase_runs_from_zero_to_its_scale():
    demos = sf.Demonstrations([wave(30), wave(50)])
    for two in (2, 2.0, np.float16(2), np.int8(2)):
        assert demos.with_phase(two).states[[0, -1], -1].tolist() == [0, 2]
    assert demos.with_phase().states[-1, -1] == pytest.approx(3 * demos.radius)
    assert demos.with_phase().names == ("x0", "x1", "phase")


def test_selecting_and_leaving_out():
    demos = sf.Demonstrations([LINE, wave(5), wave(9)], names=["x", "y"], labels=["a", "b", "c"])
    assert demos.select("x").names == ("x",)
    assert demos.select([1, "x"]).states.tolist() == demos.states[:, ::-1].tolist()
    assert [d.label for d in demos.leave_out(-2)] == ["a", "c"]


# Crossings


def test_a_loop_crosses_itself_once_where_it_does():
    s = np.linspace(-1.3, 1.3, 150)
    loop = np.column_stack([s**3 - s, s**2])  # crosses itself at (0, 1), for s = -1 and 1
    (crossing,) = sf.Demonstrations([wave(50), loop]).crossings()
    assert crossing.demonstration == 1
    np.testing.assert_allclose(crossing.state, [0, 1], atol=0.02)
    np.testing.assert_allclose(s[list(crossing.rows)], [-1, 1], atol=0.03)
    assert crossing.angle == pytest.approx(math.pi / 2, abs=0.2) and crossing.gap < 0.03
    assert not sf.Demonstrations(loop).with_phase().crossings()


def shapes():
    s = np.linspace(0, 1, 300)
    circle = np.column_stack([np.cos(2 * math.pi * s), np.sin(2 * math.pi * s)])
    rng = np.random.default_rng(0)
    return {
        "wave": wave(200, 3),
        "circle": circle,
        "circle twice": np.vstack([circle, circle]),
        "there and back": np.vstack([LINE, LINE[::-1]]),
        "trembling": wave(1000) + rng.normal(scale=0.01, size=(1000, 2)),
        "trembling at rest": np.vstack([wave(200), wave(200)[-1] + rng.normal(scale=0.003, size=(300, 2))]),
        "corner": np.array([[0.0, 0], [1, 0], [1, 1]]),
        "two samples": LINE[[0, -1]],
        "point cloud": rng.normal(size=(500, 2)),
        "helix": np.column_stack([np.cos(20 * s), np.sin(20 * s), s]),
    }


@pytest.mark.parametrize("name", shapes())
def test_what_does_not_cross_is_not_said_to(name):
    assert sf.Demonstrations(shapes()[name]).crossings() == []


class Tensor:
    """As other libraries have them: no sequence, no NumPy array, but it can be one."""

    def __init__(self, values):
        self.values, self.ndim = values, values.ndim

    def __array__(self, dtype=None, copy=None):
        return self.values


@pytest.mark.parametrize("given", [wave(20), np.stack([wave(20), wave(20, shift=0.1)])], ids=["one", "several"])
def test_tensors_of_other_libraries_are_arrays(given):
    one, other = sf.Demonstrations(given), sf.Demonstrations(Tensor(given))
    assert len(one) == len(other)
    np.testing.assert_array_equal(one.states, other.states)
