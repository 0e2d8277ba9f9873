import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import skillfold as sf
from skillfold.errors import RecordingError, SkillfoldError

ON_DISK = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)


def load(tmp_path, text, name="walk.csv", **kwargs):
    file = tmp_path / name
    if isinstance(text, bytes):
        file.write_bytes(text)
    else:
        file.write_text(text, encoding="utf-8", newline="")
    return sf.Demonstrations.load(file, **kwargs)


def test_one_recording_with_times(tmp_path):
    demos = load(tmp_path, "t,x,y\n0,1,2\n0.5,3,4\n")
    assert demos.names == ("x", "y") and demos[0].label == "walk"
    assert demos.states.tolist() == [[1, 2], [3, 4]] and demos[0].times.tolist() == [0, 0.5]


def test_a_demo_column_tells_recordings_apart(tmp_path):
    demos = load(tmp_path, "x,demo,time\n1,b,0\n2,a,0\n3,b,1\n5,a,2\n")
    assert [d.label for d in demos] == ["b", "a"]
    assert demos[0].states.tolist() == [[1], [3]] and demos[1].times.tolist() == [0, 2]


@pytest.mark.parametrize(
    "text",
    [
        "x;y\n1;2\n3;4\n",
        "x\ty\r\n1\t2\r\n3\t4\r\n",
        "\ufeffx,y\n1,2\n3,4",
        '# x, "y"\n 1 , 2\n\n3,4\n,\n',
        "x,y\r1,2\r3,4\r",
        "x,y,\n1,2,\n3,4,\n",
        "x;y;\n1;2\n3;4\n",
        "x,y\n1,2,\n3,4,\n",
        "\n\nx,y\n1,2\n3,4\n",
    ],
)
def test_the_dialects_of_csv(tmp_path, text):
    demos = load(tmp_path, text)
    assert demos.names == ("x", "y") and demos.states.tolist() == [[1, 2], [3, 4]]


def test_names_tell_quaternions_and_scalar_last_is_reordered(tmp_path):
    first = load(tmp_path, "x,qw,qx,qy,qz\n0,1,0,0,0\n1,0,1,0,0\n")
    assert first.space == sf.StateSpace.linear(1) + sf.StateSpace.quaternion()
    last = load(tmp_path, "x,tool_qx,tool_qy,tool_qz,tool_qw,y\n0,0,0,0,1,7\n1,1,0,0,0,8\n")
    assert last.names == ("x", "tool_qw", "tool_qx", "tool_qy", "tool_qz", "y")
    assert last.states.tolist() == [[0, 1, 0, 0, 0, 7], [1, 0, 1, 0, 0, 8]]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("t,x\n0,1\n1,oops\n2,3\n", "walk.csv, row 3, column 'x': value 'oops'; expected a number"),
        ("t,x\n0,1\n1,nan\n2,3\n", "walk.csv, row 3, column 'x': value nan; expected a finite"),
        ("t,x\n0,1\n1,-inf\n2,3\n", "row 3, column 'x': value -inf"),
        ("t,x\n0,1\n1,\n2,3\n", "row 3, column 'x': value ''"),
        ("t,x\n0,1\n1,1_000\n", "row 3, column 'x': value '1_000'"),
        ("t,x\n0,1\n\n1,2,3\n", "row 4: 3 values; expected 2 as in the header: t, x"),
        ("t,x\n0,1\n2,2\n1,3\n", "row 4, column 'time': value 1 after 2; .*increase"),
        ("t,x\n0,1\ninf,2\n", "row 3, column 'time': value inf"),
        ("t,x\n0,1\n", "1 samples; expected two"),
        ("t,x\n", "0 samples; expected two"),
        ("", "empty; expected a header"),
        (" \n,,\n", "empty"),
        ("0,1\n1,2\n2,3\n", r"row 1: numbers \(0, 1\) where the header belongs"),
        ("x,x\n0,1\n1,2\n", "header: column 'x' appears twice"),
        ("x,\n0,1\n1,2\n", "header: column 2 is ''"),
        ("t,time,x\n0,0,1\n1,1,2\n", "'t' and 'time'; expected one"),
        ("t,demo\n0,1\n1,2\n", "no coordinates beside t, demo"),
        ("demo,x\n,1\n1,2\n", "row 2, column 'demo': value ''"),
        ("demo,x\na,1\na,2\nb,3\n", "demo 'b': 1 samples"),
        ("x,y\n1,2\n1,2\n", r"walk.csv: nothing moves; .*\[1.0, 2.0\]"),
        ("qw,qx,qy,qz\n1,0,0,0\n1,1,0,0\n", "row 3, columns qw, qx, qy, qz: quaternion .*length 1.414"),
        (b"\xff\xfe\x00\x93", "byte 0 is not UTF-8"),
        ('x,y\n"1,2\n3,4\n', "row 2: 1 values|row 3: 1 values"),
        ("x\n" + "9" * 200_000 + "\n1\n", "no CSV"),
    ],
)
def test_what_is_wrong_is_told_with_file_row_column_and_value(tmp_path, text, told):
    with pytest.raises(RecordingError, match=told) as caught:
        load(tmp_path, text)
    assert "walk.csv" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x;y\n1,5;2,5\n3;4\n", "'1,5'; expected a number with a decimal point"),
        ("x y\n1 2\n3 4\n", "'1 2'; expected a number; columns are parted by commas, semicolons or tabs"),
        ("x,y,\n1,,\n3,4,\n", "row 2, column 'y': value ''"),
    ],
)
def test_what_another_program_would_read_is_told_how_to_be_written(tmp_path, text, told):
    with pytest.raises(RecordingError) as caught:
        load(tmp_path, text)
    assert told in str(caught.value)


def test_round_trip(tmp_path):
    rng = np.random.default_rng(0)
    demos = sf.Demonstrations(
        [rng.normal(size=(5, 2)), rng.normal(size=(7, 2))],
        times=[np.arange(5) / 3, np.arange(7) / 7],
        names=["speed, forward", 'the "other"'],
        labels=["a", "b,c"],
    )
    demos.save(tmp_path / "all.csv")
    again = sf.Demonstrations.load(tmp_path / "all.csv")
    assert again.names == demos.names and [d.label for d in again] == ["a", "b,c"]
    assert np.array_equal(again.states, demos.states)
    assert all(np.array_equal(a.times, b.times) for a, b in zip(again, demos, strict=True))


@pytest.mark.parametrize(
    ("demos", "told"),
    [
        (sf.Demonstrations(np.eye(2), names=["x", "Time"]), "'Time'; CSV needs another name"),
        (sf.Demonstrations([np.eye(2), np.eye(2)], times=[[0, 1], None]), "times, others not"),
    ],
)
def test_what_a_csv_cannot_tell_apart_is_not_written(tmp_path, demos, told):
    with pytest.raises(RecordingError, match=told):
        demos.save(tmp_path / "all.csv")
    assert not (tmp_path / "all.csv").exists()


CELLS = st.sampled_from(["0", "1", "-2.5", "1e5", "nan", "", "x", "t", "demo", '"', "é", "1e999", "qw", " "])
TABLES = st.lists(st.lists(CELLS, min_size=1, max_size=4).map(",".join), max_size=6).map("\n".join)


@ON_DISK
@given(st.text(max_size=80) | TABLES | TABLES.map(lambda t: "t,x,y\n" + t))
def test_hostile_text_is_only_ever_refused(tmp_path, text):
    try:
        demos = load(tmp_path, text.encode("utf-8", "surrogatepass"))
    except SkillfoldError as error:
        assert "walk.csv" in str(error)
    else:
        assert np.isfinite(demos.states).all()


@ON_DISK
@given(st.binary(max_size=100))
def test_random_bytes_are_only_ever_refused(tmp_path, data):
    try:
        load(tmp_path, data)
    except SkillfoldError as error:
        assert "walk.csv" in str(error)


@pytest.mark.parametrize("name", ["timestamp", "Time [s]", "secs"])
def test_time_by_another_name_is_no_coordinate(tmp_path, name):
    with pytest.raises(RecordingError, match="time in seconds is called t") as error:
        load(tmp_path, f"{name},x,y\n0,1,2\n1,2,3\n")
    assert repr(name) in str(error.value)


def test_an_index_without_a_name_is_told(tmp_path):
    with pytest.raises(RecordingError, match=r"column 1 has no name.*index=False"):
        load(tmp_path, ",x,y\n0,1,2\n1,2,3\n")
