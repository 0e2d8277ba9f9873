"""`Scene`: named obstacles, in memory and in JSON."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, replace
from os import PathLike
from pathlib import Path
from typing import Any, Self

import numpy as np

from skillfold.errors import SceneError
from skillfold.robots.mesh_files import read_vertices
from skillfold.robots.poses import read_pose
from skillfold.robots.shapes import KINDS, Motion, Shape, Sphere

FORMAT, VERSION = "skillfold scene", 1
_TITLES = {kind: title for title, kind in KINDS.items()}


@dataclass(frozen=True)
class Scene:
    """Obstacles, each with a name of its own: `Scene([Box(pose=…, size=…), Sphere(center=…, radius=…)])`.

    Attributes:
        shapes: the obstacles; those without a name were given one (`box_0`, `sphere_1`, …: kind and place).

    Raises:
        SceneError: something else than shapes, or a name that two of them have.
    """

    shapes: tuple[Shape, ...]

    def __init__(self, shapes: Iterable[Shape] = ()) -> None:
        if isinstance(shapes, Shape) or not isinstance(shapes, Iterable):
            raise SceneError(f"Scene: {type(shapes).__name__}; expected a list of shapes: {', '.join(_kinds())}.")
        named = []
        for i, shape in enumerate(shapes):
            if type(shape) not in _TITLES:
                kind = type(shape).__name__
                raise SceneError(f"Scene: obstacle {i} is a {kind}; possible: {', '.join(_kinds())}.")
            named.append(shape if shape.name else replace(shape, name=f"{_TITLES[type(shape)]}_{i}"))
        names = [shape.name for shape in named]
        doubled = sorted({name for name in names if names.count(name) > 1})
        if doubled:
            raise SceneError(f"Scene: several obstacles are named {', '.join(doubled)}; expected different names.")
        object.__setattr__(self, "shapes", tuple(named))

    def __len__(self) -> int:
        return len(self.shapes)

    def __iter__(self) -> Iterator[Shape]:
        return iter(self.shapes)

    def __getitem__(self, name: str) -> Shape:
        for shape in self.shapes:
            if shape.name == name:
                return shape
        raise SceneError(f"Scene: no obstacle {name!r}; there are {', '.join(self.names) or 'none'}.")

    def __repr__(self) -> str:
        return f"Scene({', '.join(self.names)})"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the obstacles."""
        return tuple(shape.name for shape in self.shapes)

    def moved(self, name: str, pose: Any) -> "Scene":
        """The same scene with one obstacle at another pose (7,) or position (3,); a motion of its own ends.

        Raises:
            SceneError: no such obstacle, or no pose.
        """
        old = self[name]
        place = read_pose(pose, f"{old.title}: pose", SceneError)
        change = {"center": place[:3]} if isinstance(old, Sphere) else {"pose": place}
        new = replace(old, motion=None, **change)
        return Scene([new if shape.name == name else shape for shape in self.shapes])

    def to_json(self) -> dict[str, Any]:
        """Plain dict of lists and numbers; `from_json` reads it back."""
        return {"format": FORMAT, "version": VERSION, "obstacles": [_plain(shape) for shape in self.shapes]}

    @classmethod
    def from_json(cls, data: Any, folder: str | PathLike[str] = ".") -> Self:
        """Scene from what `to_json` wrote; a mesh may name a `file` (with `scale`) relative to `folder` instead.

        Raises:
            SceneError: names the obstacle and what was expected.
        """
        if not isinstance(data, dict) or not isinstance(data.get("obstacles"), list):
            raise SceneError('Scene: expected {"format": "skillfold scene", "version": 1, "obstacles": […]}.')
        if data.get("format", FORMAT) != FORMAT or data.get("version", VERSION) != VERSION:
            given = f"{data.get('format')!r}, version {data.get('version')!r}"
            raise SceneError(f"Scene: format {given}; expected {FORMAT!r}, version {VERSION}.")
        return cls([_shape(item, i, Path(folder)) for i, item in enumerate(data["obstacles"])])

    def save(self, path: str | PathLike[str]) -> None:
        """Write the scene as JSON.

        Raises:
            SceneError: the file cannot be written.
        """
        text = json.dumps(self.to_json(), indent=1, allow_nan=False)
        try:
            Path(path).write_text(text + "\n", encoding="utf-8")
        except (OSError, TypeError, ValueError) as error:
            raise SceneError(f"{path}: cannot be written: {getattr(error, 'strerror', None) or error}.") from None

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Self:
        """Scene from a JSON file.

        Raises:
            SceneError: the file is missing, no JSON, or no scene; names the obstacle.
        """
        try:
            data = json.loads(Path(path).read_text(encoding="utf-8-sig"))
        except (OSError, TypeError) as error:
            raise SceneError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}.") from None
        except (ValueError, RecursionError) as error:
            raise SceneError(f"{path}: no JSON: {error}.") from None
        try:
            return cls.from_json(data, Path(path).parent)
        except SceneError as error:
            raise SceneError(f"{path}: {error}") from None


def _kinds() -> list[str]:
    return [kind.__name__ for kind in KINDS.values()]


def _plain(shape: Shape) -> dict[str, Any]:
    item: dict[str, Any] = {"shape": _TITLES[type(shape)]}
    for part in fields(shape):
        value = getattr(shape, part.name)
        if isinstance(value, Motion):
            value = {"times": value.times.tolist(), "poses": value.poses.tolist()}
        if value is not None:
            item[part.name] = value.tolist() if isinstance(value, np.ndarray) else value
    return item


def _shape(item: Any, index: int, folder: Path) -> Shape:
    where = f"obstacle {index}"
    if not isinstance(item, dict) or item.get("shape") not in list(KINDS):
        given = item.get("shape") if isinstance(item, dict) else item
        raise SceneError(f"{where}: shape {given!r:.60}; possible: {', '.join(KINDS)}.")
    kind = KINDS[item["shape"]]
    values = {key: value for key, value in item.items() if key != "shape"}
    if item["shape"] == "mesh" and "file" in values:
        values["vertices"] = _vertices(values.pop("file"), values.pop("scale", 1.0), folder, where)
    expected = [part.name for part in fields(kind)]
    if unknown := sorted(set(values) - set(expected)):
        raise SceneError(f"{where}: unknown entries {', '.join(unknown)}; possible: {', '.join(expected)}.")
    if values.get("motion") is not None:
        values["motion"] = _motion(values["motion"], where)
    try:
        return kind(**values)
    except TypeError:
        raise SceneError(
            f"{where}: {item['shape']} with {', '.join(values)}; expected {', '.join(expected)}."
        ) from None
    except SceneError as error:
        raise SceneError(f"{where}: {error}") from None


def _vertices(file: Any, scale: Any, folder: Path, where: str) -> Any:
    if not isinstance(file, str):
        raise SceneError(f"{where}: file {file!r:.60}; expected a path.")
    return read_vertices(folder / file, scale)


def _motion(value: Any, where: str) -> Motion:
    if not isinstance(value, dict) or set(value) != {"times", "poses"}:
        raise SceneError(f'{where}: motion {value!r:.60}; expected {{"times": […], "poses": [[…], …]}}.')
    try:
        return Motion(**value)
    except SceneError as error:
        raise SceneError(f"{where}: {error}") from None
