"""Sealed archives: arrays and a JSON header in one NPZ file that ends with the checksum of all before it.

NumPy reads the file like any NPZ; skillfold refuses one in which a single bit has changed. Nothing in it is run.
"""

import hashlib
import io
import json
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from skillfold.errors import SkillFileError

Arrays = dict[str, np.ndarray[Any, Any]]

HEADER = "header"
SEAL = 64  # hexadecimal digits of SHA-256, kept as the ZIP file's comment
LARGEST = 2_000_000_000  # bytes of all arrays together: no file may unpack to more
DATE = (1980, 1, 1, 0, 0, 0)  # of every entry: the same skill gives the same bytes


def write(path: str | PathLike[str], header: Mapping[str, Any], arrays: Mapping[str, Any]) -> None:
    """Write arrays and a header of plain JSON values; the same content gives the same bytes.

    Raises:
        SkillFileError: the file cannot be written.
    """
    text = np.array(json.dumps(header, sort_keys=True))
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, value in {HEADER: text, **arrays}.items():
            entry = io.BytesIO()
            np.lib.format.write_array(entry, np.asanyarray(value), allow_pickle=False)
            info = zipfile.ZipInfo(f"{name}.npy", DATE)
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, entry.getvalue())
        archive.comment = b"0" * SEAL
    body = buffer.getvalue()[:-SEAL]
    try:
        Path(path).write_bytes(body + _seal(body))
    except (OSError, TypeError, ValueError) as error:  # no path at all, or one with a zero byte
        raise SkillFileError(f"{path}: cannot be written: {_words(error)}.") from None


def read(path: str | PathLike[str], kind: str) -> tuple[dict[str, Any], Arrays]:
    """Header and arrays of a file that `write` made with header["kind"] == kind.

    Raises:
        SkillFileError: the file is missing, damaged, of another kind, or not such an archive.
    """
    header, arrays = _opened(path)
    if header.get("kind") != kind:
        raise SkillFileError(f"{path}: holds {header.get('kind')!r}, expected {kind!r}.")
    return header, arrays


def kind_of(path: str | PathLike[str]) -> str:
    """header["kind"] of a file that `write` made.

    Raises:
        SkillFileError: the file is missing, damaged, or not such an archive.
    """
    return str(_opened(path)[0].get("kind"))


def _opened(path: str | PathLike[str]) -> tuple[dict[str, Any], Arrays]:
    try:
        data = Path(path).read_bytes()
    except (OSError, TypeError, ValueError) as error:
        raise SkillFileError(f"{path}: cannot be read: {_words(error)}.") from None
    if len(data) <= SEAL or _seal(data[:-SEAL]) != data[-SEAL:]:
        raise SkillFileError(
            f"{path}: damaged, cut short, or not saved by skillfold: its checksum does not fit. Save it again."
        )
    with blaming(path, "not an archive of plain arrays"):
        arrays = _unpack(data)
        return _header(arrays.pop(HEADER, None)), arrays


@contextmanager
def blaming(path: Any, what: str) -> Iterator[None]:
    """Whatever goes wrong while a file's content is read becomes a `SkillFileError` that names the file.

    Hostile bytes make each library below fail in its own way (zlib, lzma, the parser of NumPy's headers, memory):
    a list of kinds would never be complete.
    """
    try:
        yield
    except Exception as error:
        raise SkillFileError(f"{path}: {what}: {_words(error)}.") from None


def _words(error: Exception) -> str:
    text = str(getattr(error, "strerror", None) or error) or type(error).__name__
    return text.removesuffix(".")


def _seal(body: bytes) -> bytes:
    return hashlib.sha256(body).hexdigest().encode()


def _unpack(data: bytes) -> Arrays:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        size = sum(info.file_size for info in archive.infolist())
        if size > LARGEST:
            raise ValueError(f"it unpacks to {size} bytes, more than {LARGEST}")
        return {
            name.removesuffix(".npy"): np.lib.format.read_array(io.BytesIO(archive.read(name)), allow_pickle=False)
            for name in archive.namelist()
        }


def _header(text: Any) -> dict[str, Any]:
    try:
        header = json.loads(str(text))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"no readable header: {error}") from None
    if not isinstance(header, dict):
        raise ValueError("the header is no JSON object")
    return header
