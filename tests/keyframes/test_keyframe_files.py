"""Saved skills of keyframes: the same bits back, and damaged or hostile files refused."""

import hashlib
import io
import json
import zipfile

import numpy as np
import pytest

from keyframes.skills import demonstrations
from skillfold.errors import SkillFileError
from skillfold.keyframes.skill import KeyframeSkill

SEAL = 64


@pytest.fixture(scope="module")
def skill():
    return KeyframeSkill.fit(demonstrations(11, extra=0.1)[1])


@pytest.fixture
def saved(skill, tmp_path):
    skill.save(tmp_path / "skill.npz")
    return tmp_path / "skill.npz"


def members(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def resealed(path, parts):
    """A file of these members with a right checksum, as an attacker would make it."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, data in parts.items():
            archive.writestr(name, data)
        archive.comment = b"0" * SEAL
    body = buffer.getvalue()[:-SEAL]
    path.write_bytes(body + hashlib.sha256(body).hexdigest().encode())


def npy(array):
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, np.asanyarray(array))
    return buffer.getvalue()


def loaded(data):
    return np.load(io.BytesIO(data), allow_pickle=False)


def refused(path):
    try:
        KeyframeSkill.load(path)
    except SkillFileError:
        return True
    return False


def test_what_is_loaded_is_what_was_saved(skill, saved, tmp_path):
    again = KeyframeSkill.load(saved)
    assert repr(again) == repr(skill) and again.selection == skill.selection and again.names == skill.names
    for a, b in zip(again.gaussians, skill.gaussians, strict=True):
        for name in ("mean", "covariance", "gates"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    for a, b in zip(again.labels + again.keyframes, skill.labels + skill.keyframes, strict=True):
        np.testing.assert_array_equal(a, b)
    again.save(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == saved.read_bytes()


def test_a_loaded_skill_can_be_refined(skill, saved):
    more = demonstrations(11)[1][:3]
    first, second = skill.refined(more), KeyframeSkill.load(saved).refined(more)
    np.testing.assert_array_equal(first.gaussians[0].covariance, second.gaussians[0].covariance)


def test_every_flipped_byte_is_noticed(saved):
    body = bytearray(saved.read_bytes())
    for place in range(0, len(body), 97):
        body[place] ^= 0xFF
        saved.write_bytes(bytes(body))
        assert refused(saved), place
        body[place] ^= 0xFF


def test_resealed_flips_never_crash(saved):
    body = bytearray(saved.read_bytes()[:-SEAL])
    for place in range(0, len(body), 53):
        body[place] ^= 0xFF
        saved.write_bytes(bytes(body) + hashlib.sha256(body).hexdigest().encode())
        refused(saved)
        body[place] ^= 0xFF


WRONG = {
    "another rank": lambda a: a[None],
    "nothing": lambda a: np.empty((0,) * max(1, a.ndim)),
    "one row less": lambda a: a[:-1],
    "complex": lambda a: a.astype(complex),
    "text": lambda a: a.astype(str),
    "single precision": lambda a: a.astype(np.float32),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_arrays_of_another_shape_or_type_are_refused(saved, wrong):
    parts = members(saved)
    for name in parts:
        changed = parts if name == "header.npy" else {**parts, name: npy(WRONG[wrong](loaded(parts[name])))}
        if (name, wrong) in (("header.npy", wrong), ("selection.npy", "one row less")):
            continue
        resealed(saved, changed)
        assert refused(saved), name


def test_every_array_is_needed(saved):
    parts = members(saved)
    for name in parts:
        resealed(saved, {n: data for n, data in parts.items() if n != name})
        assert refused(saved), name


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_none_are_refused(saved, value):
    parts = members(saved)
    for name in (name for name, data in parts.items() if loaded(data).dtype == np.float64):
        array = loaded(parts[name])
        array[(0,) * array.ndim] = value
        resealed(saved, {**parts, name: npy(array)})
        assert refused(saved), name


CONTENT = {
    "labels beyond": ("labels", lambda a: a + 100),
    "labels below": ("labels", lambda a: a - 2),
    "lengths of more": ("lengths", lambda a: a + 1),
    "lengths that wrap": ("lengths", lambda a: np.concatenate([[-3, a[0] + a[1] + 3], a[2:]])),
    "no keyframes at all": ("counts", lambda a: 0 * a),
    "gates below zero": ("gates", lambda a: -a),
    "covariances below zero": ("covariances", lambda a: -a),
    "tied covariances": ("covariances", lambda a: a + 1e-3),
    "long quaternions": ("means", lambda a: 2 * a),
    "long quaternions of keyframes": ("keyframes", lambda a: 2 * a),
    "keyframes far away": ("keyframes", lambda a: a + np.array([1e9, 0, 0, 0, 0, 0, 0])),
    "numbers that are none": ("selection", lambda a: a + 0.5),
}


@pytest.mark.parametrize(("name", "change"), CONTENT.values(), ids=CONTENT)
def test_content_that_does_not_fit_is_refused(saved, name, change):
    parts = members(saved)
    resealed(saved, {**parts, f"{name}.npy": npy(change(loaded(parts[f"{name}.npy"])))})
    assert refused(saved)


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("kind", [None, "skill manifold", 1]),
        ("version", [None, 0, 2, "1", True]),
        ("names", [None, "abcdefg", ["a"], [1] * 7]),
        ("coverage", [None, 0, 2, "x", True, [0.9]]),
        ("interpolation", [None, "cubic", 1]),
        ("notes", [None, 3, [3]]),
    ],
)
def test_headers_with_wrong_values_are_refused(saved, key, values):
    parts = members(saved)
    header = json.loads(str(loaded(parts["header.npy"])))
    for value in values:
        resealed(saved, {**parts, "header.npy": npy(np.array(json.dumps({**header, key: value})))})
        assert refused(saved), value
