"""Skill files whose checksum is right and whose content is not: always a SkillFileError, never a crash."""

import hashlib
import io
import json
import math
import zipfile

import numpy as np
import pytest

from skillfold import SkillManifold
from skillfold.errors import SkillFileError
from skillfold.manifold import storage

SEAL = 64


def members(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def sealed(body):
    return body + hashlib.sha256(body).hexdigest().encode()


def resealed(path, parts, compression=zipfile.ZIP_DEFLATED):
    """A file of these members with a right checksum, as an attacker would make it."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", compression) as archive:
        for name, data in parts.items():
            archive.writestr(name, data)
        archive.comment = b"0" * SEAL
    path.write_bytes(sealed(buffer.getvalue()[:-SEAL]))


def npy(array, pickles=False):
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, np.asanyarray(array), allow_pickle=pickles)
    return buffer.getvalue()


def raw_npy(header, data=b""):
    text = header.encode()
    text += b" " * (63 - (10 + len(text)) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + data


def loaded(data):
    return np.load(io.BytesIO(data), allow_pickle=False)


def loads_or_is_refused(path):
    try:
        SkillManifold.load(path)
    except SkillFileError:
        return False
    return True


def test_resealed_flips_never_crash(saved):
    """With a right checksum a flip may go unnoticed where it changes nothing; else it is refused, never a crash."""
    body = bytearray(saved.read_bytes()[:-SEAL])
    refused = 0
    directory = len(body) - 1600  # entries' flags, sizes and names
    for place in (*range(0, directory, 2503), *range(directory, len(body), 3)):
        body[place] ^= 0xFF
        saved.write_bytes(sealed(bytes(body)))
        refused += not loads_or_is_refused(saved)
        body[place] ^= 0xFF
    assert refused > 100


@pytest.mark.parametrize("compression", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA, zipfile.ZIP_DEFLATED])
def test_damaged_streams_of_every_compression_are_refused(saved, compression):
    resealed(saved, members(saved), compression)
    body = bytearray(saved.read_bytes()[:-SEAL])
    refused = 0
    for place in range(60, len(body) - 3000, 4003):
        body[place] ^= 0xFF
        saved.write_bytes(sealed(bytes(body)))
        refused += not loads_or_is_refused(saved)
        body[place] ^= 0xFF
    assert refused > 5


def test_resealed_as_it_was_it_loads(saved):
    resealed(saved, members(saved))
    assert isinstance(SkillManifold.load(saved), SkillManifold)


def hostile(path, name, data):
    parts = members(path)
    parts[name] = data
    resealed(path, parts)
    with pytest.raises(SkillFileError):
        SkillManifold.load(path)


def test_every_array_is_needed(saved):
    parts = members(saved)
    for name in parts:
        resealed(saved, {n: data for n, data in parts.items() if n != name})
        with pytest.raises(SkillFileError):
            SkillManifold.load(saved)


WRONG = {
    "another rank": lambda a: a[None],
    "nothing": lambda a: np.empty((0,) * max(1, a.ndim)),
    "complex": lambda a: a.astype(complex),
    "text": lambda a: a.astype(str),
    "a structure": lambda a: np.zeros(a.shape, [("a", "f8")]),
    "dates": lambda a: np.zeros(a.shape, "M8[s]"),
    "raw memory": lambda a: np.zeros(a.shape, "V8"),
    "single precision": lambda a: a.astype(np.float32),
    "other bytes": lambda a: a.astype(a.dtype.newbyteorder(">")) if a.dtype.itemsize > 1 else a[None],
    "pickles": None,
}
NUMBERS = {"NaN": np.nan, "infinity": np.inf}


@pytest.mark.parametrize("wrong", WRONG)
def test_arrays_of_another_shape_or_type_are_refused(saved, wrong):
    parts = members(saved)
    for name, data in parts.items():
        if name == "header.npy":
            continue
        array = loaded(data)
        with np.errstate(invalid="ignore"):
            changed = np.full(array.shape, None) if wrong == "pickles" else WRONG[wrong](array)
        if array.size == 0 and changed.shape == array.shape and changed.dtype == array.dtype:
            continue  # nothing of nothing: the same array
        resealed(saved, {**parts, name: npy(changed, pickles=True)})
        assert not loads_or_is_refused(saved), name


@pytest.mark.parametrize("value", NUMBERS)
def test_numbers_that_are_none_are_refused(saved, value):
    parts = members(saved)
    for name, data in parts.items():
        array = loaded(data)
        if array.dtype == np.float64 and array.size:
            array[(0,) * array.ndim] = NUMBERS[value]
            resealed(saved, {**parts, name: npy(array)})
            assert not loads_or_is_refused(saved), name


@pytest.mark.parametrize(
    "name", ["radii.npy", "precision.npy", "trust.npy", "route_scale.npy", "route_squared_spread.npy"]
)
@pytest.mark.parametrize("value", [0.0, -1.0])
def test_what_must_be_positive_is(saved, name, value):
    hostile(saved, name, npy(np.full(loaded(members(saved)[name]).shape, value)))


def test_edges_must_name_anchors(saved):
    edges = loaded(members(saved)["edges.npy"])
    for wrong in (edges - 1, edges + 10**6, edges.astype(np.int32), edges[:0], edges.T):
        hostile(saved, "edges.npy", npy(wrong))


def test_a_route_of_other_coordinates_is_refused(saved):
    parts = members(saved)
    for name in ("route_curves.npy", "route_centre.npy"):
        parts[name] = npy(loaded(parts[name])[..., :2])
    resealed(saved, parts)
    with pytest.raises(SkillFileError):
        SkillManifold.load(saved)


@pytest.mark.parametrize(
    "header",
    [
        "{'descr': '<f8', 'fortran_order': False, 'shape': (100000000000000,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (9223372036854775807, 3), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-1,), }",
        "{'descr': '<V0', 'fortran_order': False, 'shape': (5000000000,), }",
        "{'descr': '|O', 'fortran_order': False, 'shape': (1,), }",
        "{'descr': ('<f8', 3, 4), 'fortran_order': False, 'shape': (3,), }",
        "{'descr': [('a', '<f8'), ('a', '<f8')], 'fortran_order': False, 'shape': (3,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (3L,",
        "__import__('os').system('false')",
        "'''",
        "(" * 9000,
        "-" * 9000 + "1",
    ],
    ids=lambda header: header[:60],
)
def test_arrays_with_a_hostile_description_are_refused(saved, header):
    hostile(saved, "weights.npy", raw_npy(header, b"\0" * 64))


@pytest.mark.parametrize("data", [b"", b"hello", b"\x93NUMPY", b"\x93NUMPY\x09\x00" + b"\0" * 100])
def test_members_that_are_no_arrays_are_refused(saved, data):
    hostile(saved, "weights.npy", data)


def test_a_file_that_would_unpack_to_too_much_is_refused(saved, monkeypatch):
    monkeypatch.setattr("skillfold.archive.LARGEST", 1000)
    with pytest.raises(SkillFileError, match="unpacks to"):
        SkillManifold.load(saved)


def test_a_degree_of_too_many_terms_is_refused_before_they_are_made(saved, monkeypatch):
    """Degree 8 in 40 variables has 377 million monomials."""

    def counted(dim, degree):
        assert math.comb(dim + degree, degree) < 10**6
        return real(dim, degree)

    real = storage.monomials
    monkeypatch.setattr(storage, "monomials", counted)
    parts = members(saved)
    header = json.loads(str(loaded(parts["header.npy"])))
    header["degree"] = 8
    parts["header.npy"] = npy(np.array(json.dumps(header)))
    n, anchors = 41, loaded(parts["points.npy"]).shape[1]
    parts["kept.npy"], parts["points.npy"] = npy(np.eye(n)), npy(np.zeros((n, anchors)))
    parts["frames.npy"] = npy(np.broadcast_to(np.eye(n), (anchors, n, n)))
    parts["weights.npy"], parts["kernels.npy"] = npy(np.zeros((40, n, 2))), npy(np.zeros((n, 2)))
    resealed(saved, parts)
    with pytest.raises(SkillFileError):
        SkillManifold.load(saved)


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[1]",
        "3",
        "null",
        '"text"',
        "",
        "[" * 100_000,
        '{"kind": "skill manifold", "version": NaN}',
        '{"kind": 3}',
    ],
    ids=lambda text: text[:20],
)
def test_headers_that_are_none_are_refused(saved, text):
    hostile(saved, "header.npy", npy(np.array(text)))


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("kind", [None, "keyframe skill", 1]),
        ("version", [None, 0, 1, 3, "2", 1e400]),
        ("degree", [None, 0, -1, 9, 3, 1e400, 10**400, "x", [1]]),
        (
            "numbers",
            [None, [], {}, {"scale": 0, "step": 1, "tolerance": 1}, {"scale": 1, "step": -1, "tolerance": 1}],
        ),
        ("numbers", [{"scale": 1, "step": 1, "tolerance": 1e400}, {"scale": "x", "step": 1, "tolerance": 1}]),
        ("space", [None, [], {}, {"kinds": ["linear"] * 2, "lower": [None] * 2, "upper": [None] * 2}]),
        ("space", [{"kinds": ["odd"] * 3, "lower": [None] * 3, "upper": [None] * 3}]),
        ("names", [None, 3, ["x"], ["x"] * 4]),
        ("selection", [None, 3, [3], [["a", "b"]], [["a", "b", "x", "d", True]]]),
        ("noise", [None, -1, "x", 1e400, [], 10**400]),
        ("residual", [None, -1, "x", 1e400]),
        ("ridge", [None, -1, "x", 1e400]),
        ("converged", [None, "x", 2, []]),
        ("n_samples", [None, -1, 0, "x", 1.5, 1e400, []]),
        ("notes", [None, 3]),
    ],
)
def test_headers_with_wrong_values_are_refused(saved, key, values):
    parts = members(saved)
    header = json.loads(str(loaded(parts["header.npy"])))
    for value in values:
        resealed(saved, {**parts, "header.npy": npy(np.array(json.dumps({**header, key: value})))})
        assert not loads_or_is_refused(saved), value
