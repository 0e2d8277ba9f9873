import io
import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import skillfold as sf
from skillfold.errors import RecordingError, SkillfoldError

ON_DISK = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
RNG = np.random.default_rng(0)
BLOCK = RNG.normal(size=(3, 5, 2))


def load(tmp_path, **entries):
    np.savez(tmp_path / "walk.npz", **entries)
    return sf.Demonstrations.load(tmp_path / "walk.npz")


def test_a_block_of_recordings(tmp_path):
    demos = load(tmp_path, states=BLOCK, times=np.arange(5.0), names=["x", "y"])
    assert demos.names == ("x", "y") and [d.label for d in demos] == ["walk:0", "walk:1", "walk:2"]
    assert np.array_equal(np.stack([d.states for d in demos]), BLOCK)
    assert all(d.times.tolist() == [0, 1, 2, 3, 4] for d in demos)


def test_numbered_recordings_of_different_lengths(tmp_path):
    demos = load(tmp_path, states_10=BLOCK[0], states_2=BLOCK[1, :3], times_2=np.arange(3.0))
    assert demos.lengths.tolist() == [3, 5]
    assert demos[0].times is not None and demos[1].times is None


def test_one_plain_recording(tmp_path):
    assert load(tmp_path, states=BLOCK[0])[0].label == "walk"
    assert load(tmp_path, states=BLOCK, times=np.tile(np.arange(5.0), (3, 1)))[2].times[-1] == 4


def test_scalar_last_names_are_reordered(tmp_path):
    states = np.array([[0.0, 0, 0, 1], [1, 0, 0, 0]])
    demos = load(tmp_path, states=states, names=["qx", "qy", "qz", "qw"])
    assert demos.names == ("qw", "qx", "qy", "qz") and demos.states.tolist() == [[1, 0, 0, 0], [0, 1, 0, 0]]


@st.composite
def demonstrations(draw):
    space = draw(st.sampled_from([sf.StateSpace.pose(), sf.StateSpace.continuous(2), sf.StateSpace.angles(1, -9, 9)]))
    rng = np.random.default_rng(draw(st.integers(0, 99)))
    parts = [
        space.normalize(rng.normal(size=(n, space.n_dims)))
        for n in draw(st.lists(st.integers(2, 5), min_size=1, max_size=3))
    ]
    times = [draw(st.none() | st.just(np.cumsum(rng.uniform(0.1, 1, len(p))))) for p in parts]
    return sf.Demonstrations(parts, times=times, space=space)


@ON_DISK
@given(demonstrations())
def test_every_bit_comes_back(tmp_path, demos):
    demos.save(tmp_path / "all.npz")
    again = sf.Demonstrations.load(tmp_path / "all.npz")
    assert again.space == demos.space and again.names == demos.names
    for a, b in zip(again, demos, strict=True):
        assert a.label == b.label and a.states.tobytes() == b.states.tobytes()
        assert (a.times is None) == (b.times is None)
        assert a.times is None or a.times.tobytes() == b.times.tobytes()


@pytest.mark.parametrize(
    ("entries", "told"),
    [
        ({"state": BLOCK}, "unknown entry 'state'; possible: states"),
        ({"names": ["x", "y"]}, r"no states \(entries: names\)"),
        ({}, r"no states \(entries: none\)"),
        ({"states": BLOCK, "states_0": BLOCK[0]}, "both 'states' and 'states_0'"),
        ({"states": BLOCK[0, 0]}, r"shape \(2,\)"),
        ({"states": BLOCK[:0]}, r"shape \(0, 5, 2\)"),
        ({"states_0": BLOCK}, r"shape \(3, 5, 2\); expected \(n_steps"),
        ({"states_0": BLOCK[0], "times_1": [1, 2]}, "'times_1' does not belong"),
        ({"states": BLOCK, "times": np.zeros((2, 5))}, r"times of shape \(2, 5\) for 3 recordings"),
        ({"states": BLOCK, "times": np.zeros(5)}, r"states\[0\], row 1 .*'time': value 0 after 0"),
        (
            {"states": np.where(BLOCK[1, 2, 1] == BLOCK, np.nan, BLOCK)},
            r"states\[1\], row 2 .*column '1': value nan",
        ),
        ({"states": np.array([[["a", "b"], ["c", "d"]]])}, r"row 0, column 0 .*value .*'a'"),
        ({"states": BLOCK, "names": ["x", "y", "z"]}, "2 columns; expected 3: x, y, z"),
        ({"states": BLOCK, "names": ["x", "x"]}, "'x' appears twice"),
        ({"states": BLOCK, "names": [1, 2]}, "names of shape .*expected a list of text"),
        ({"states": BLOCK, "labels": ["a"]}, "1 labels for 3"),
        ({"states": BLOCK, "space": "{"}, "space: "),
        ({"states": BLOCK, "space": json.dumps({"kinds": []})}, "space: .*expected a dict"),
        ({"states": np.array([{}, object()])}, "no NPZ of plain numbers"),
    ],
)
def test_what_is_wrong_is_told(tmp_path, entries, told):
    with pytest.raises(RecordingError, match=told):
        load(tmp_path, **entries)


def test_a_suffix_in_capitals_stays(tmp_path):
    sf.Demonstrations(BLOCK).save(tmp_path / "all.NPZ")
    assert len(sf.Demonstrations.load(tmp_path / "all.NPZ")) == 3


def test_a_lone_array_and_a_pickle_are_no_npz(tmp_path):
    file = tmp_path / "walk.npz"
    with file.open("wb") as out:
        np.save(out, BLOCK)
    with pytest.raises(RecordingError, match="single array"):
        sf.Demonstrations.load(file)
    with file.open("wb") as out:
        np.save(out, np.array([{}]), allow_pickle=True)
    with pytest.raises(RecordingError, match=r"walk.npz: no NPZ of plain numbers"):
        sf.Demonstrations.load(file)


def _bytes():
    stream = io.BytesIO()
    np.savez_compressed(stream, states=BLOCK, names=np.array(["x", "y"]))
    return stream.getvalue()


WHOLE = _bytes()


@ON_DISK
@given(st.integers(0, len(WHOLE) - 1))
def test_a_truncated_file_is_refused(tmp_path, n):
    (tmp_path / "walk.npz").write_bytes(WHOLE[:n])
    with pytest.raises(RecordingError, match=r"walk.npz: .*truncated"):
        sf.Demonstrations.load(tmp_path / "walk.npz")


@ON_DISK
@given(st.lists(st.tuples(st.integers(0, len(WHOLE) - 1), st.integers(0, 255)), min_size=1, max_size=4))
def test_a_damaged_file_is_only_ever_refused(tmp_path, changes):
    data = bytearray(WHOLE)
    for place, value in changes:
        data[place] = value
    (tmp_path / "walk.npz").write_bytes(bytes(data))
    try:
        sf.Demonstrations.load(tmp_path / "walk.npz")
    except SkillfoldError as error:
        assert "walk.npz" in str(error)


@ON_DISK
@given(st.binary(max_size=100))
def test_random_bytes_are_refused(tmp_path, data):
    (tmp_path / "walk.npz").write_bytes(data)
    with pytest.raises(RecordingError, match=r"walk.npz"):
        sf.Demonstrations.load(tmp_path / "walk.npz")
