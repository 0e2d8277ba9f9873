"""Vertices of meshes in OBJ and STL files; faces are not needed, obstacles are convex hulls."""

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from skillfold.errors import SceneError

Array = np.ndarray[Any, np.dtype[np.float64]]

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
LARGEST = 1e9  # times that a mesh is scaled
_HEAD = 84  # bytes before the triangles of a binary STL: 80 of text, then their number


def read_vertices(file: str | PathLike[str], scale: Any = 1.0) -> Array:
    """Vertices (n, 3) of a mesh, in its own units times `scale`.

    Raises:
        SceneError: the file is missing, of another kind, or damaged; a scale that is none.
    """
    if isinstance(scale, bool) or not isinstance(scale, int | float | np.number) or not 0 < abs(scale) < LARGEST:
        raise SceneError(f"{file}: scale {scale!r:.40}; expected a number, such as 0.001 for millimetres.")
    try:
        path = Path(file)
        data = path.read_bytes()
    except (OSError, TypeError, ValueError) as error:
        raise SceneError(f"{file}: cannot be read: {getattr(error, 'strerror', None) or error}.") from None
    readers = {".obj": _obj, ".stl": _stl}
    if path.suffix.lower() not in readers:
        raise SceneError(f"{file}: unknown kind of mesh '{path.suffix}'; possible: .obj, .stl.")
    try:
        vertices = readers[path.suffix.lower()](data)
    except (ValueError, IndexError) as error:
        raise SceneError(f"{file}: damaged: {error}.") from None
    if len(vertices) < 4:
        raise SceneError(f"{file}: {len(vertices)} vertices; expected at least 4.")
    with np.errstate(over="ignore"):  # what becomes infinite is too far away, and refused as such
        return float(scale) * vertices


def _obj(data: bytes) -> Array:
    lines = (line.split() for line in data.decode("utf-8", "replace").splitlines())
    return _array([words[1:4] for words in lines if words and words[0] == "v"])


def _stl(data: bytes) -> Array:
    count = int.from_bytes(data[80:_HEAD], "little")
    if len(data) == _HEAD + count * _TRIANGLE.itemsize:
        corners = np.frombuffer(data, _TRIANGLE, count, _HEAD)["corners"]
        return np.unique(corners.reshape(-1, 3).astype(np.float64), axis=0)
    if not data.lstrip().startswith(b"solid"):
        raise ValueError(f"{len(data)} bytes do not hold the {count} triangles that it announces")
    lines = (line.split() for line in data.decode("utf-8", "replace").splitlines())
    return _array([words[1:4] for words in lines if words and words[0] == "vertex"])


def _array(rows: list[list[str]]) -> Array:
    return np.array([[float(word) for word in row] for row in rows], np.float64).reshape(-1, 3)
