import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skillfold as sf
from skillfold.errors import RecordingError, SkillfoldError

WALK = "t,x,y\n0,1,2\n1,3,4\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "b.csv").write_text(WALK)
    (tmp_path / "a.CSV").write_text("y,x\n6,5\n8,7\n")
    (tmp_path / "notes.txt").write_text("no recording")
    np.savez(tmp_path / "c.npz", states=np.array([[9.0, 9], [8, 8]]), names=["y", "x"])
    return tmp_path


def test_a_folder_is_read_in_order_of_name_and_columns_by_name(folder):
    demos = sf.Demonstrations.load(folder)
    assert [d.label for d in demos] == ["a", "b", "c"]
    assert demos.names == ("y", "x")
    assert demos[1].states.tolist() == [[2, 1], [4, 3]]
    assert demos[0].times is None and demos[1].times is not None


def test_a_list_of_files_and_folders_and_equal_labels(folder):
    demos = sf.Demonstrations.load([folder / "b.csv", str(folder)])
    assert [d.label for d in demos] == ["0:b", "1:a", "2:b", "3:c"]


def test_columns_that_differ_are_told(folder):
    (folder / "d.csv").write_text("x,z\n1,2\n3,4\n")
    with pytest.raises(RecordingError, match=r"d.csv: columns x, z; expected y, x as in .*a.CSV"):
        sf.Demonstrations.load(folder)


def test_spaces_that_differ_are_told(tmp_path):
    for name, space in (("a", sf.StateSpace.linear(1)), ("b", sf.StateSpace.continuous(1))):
        sf.Demonstrations([[[0], [1]]], space=space).save(tmp_path / f"{name}.npz")
    with pytest.raises(RecordingError, match=r"b.npz: .*1 continuous.*a.npz has .*1 linear"):
        sf.Demonstrations.load(tmp_path)
    assert len(sf.Demonstrations.load(tmp_path, space=sf.StateSpace.linear(1))) == 2


@pytest.mark.parametrize(
    ("path", "told"),
    [
        ("gone.csv", "gone.csv: no such file"),
        ("notes.txt", "unknown suffix '.txt'; possible: .csv, .npz"),
        ("empty", "no recordings in this folder"),
        ("a\0b.csv", "a\\\\x00b.csv|no such file|null"),
        ("x" * 5000, "no such file|cannot be opened"),
    ],
)
def test_paths_without_recordings_are_told(folder, path, told):
    (folder / "empty").mkdir()
    with pytest.raises(RecordingError, match=told):
        sf.Demonstrations.load(folder / path)


@pytest.mark.parametrize("times", [1.0, "soon"])
def test_times_that_are_no_list_are_told(tmp_path, times):
    np.savez(tmp_path / "a.npz", states=np.eye(2), times=np.array(times))
    with pytest.raises(RecordingError, match="times of shape"):
        sf.Demonstrations.load(tmp_path / "a.npz")


@pytest.mark.parametrize("path", [7, None, [], [None], [["a.csv"]], b"a.csv", "~nobody_of_this_name/a.csv"])
def test_what_is_no_path_is_told(path):
    with pytest.raises(RecordingError):
        sf.Demonstrations.load(path)


@pytest.mark.parametrize(
    ("path", "told"),
    [
        ("demos.txt", "unknown suffix '.txt'"),
        ("gone/demos.csv", "cannot be written"),
        ("gone/demos.npz", "cannot be"),
    ],
)
def test_places_to_write_that_do_not_work(tmp_path, path, told):
    with pytest.raises(RecordingError, match=told):
        sf.Demonstrations(np.eye(2)).save(tmp_path / path)


@given(st.text(max_size=20))
def test_any_text_as_a_path(path):
    try:
        sf.Demonstrations.load(path + "?nothing")
    except SkillfoldError as error:
        assert str(error)
