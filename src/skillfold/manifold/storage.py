"""Skill manifolds as files: plain arrays and a JSON header, every shape checked on the way back."""

from math import comb
from os import PathLike
from typing import Any

import numpy as np

from skillfold import archive
from skillfold.errors import SkillFileError
from skillfold.manifold.inputs import whole
from skillfold.manifold.kernels.surface import Field
from skillfold.manifold.model import Model, build_surface, trust_in
from skillfold.manifold.polynomials import monomials
from skillfold.manifold.route import Route
from skillfold.manifold.table import Selection, Trial
from skillfold.recordings import shortened
from skillfold.spaces import StateSpace

KIND = "skill manifold"
VERSION = 2
NUMBERS = ("scale", "step", "tolerance")
ROUTE = "route_"
SAMPLES = 2**53  # that a skill may say it was learnt from
TERMS = 100_000  # of a local surface: its neighbours, which must outnumber them, never come near


def pack(model: Model, route: Route | None, facts: dict[str, Any]) -> tuple[dict[str, Any], archive.Arrays]:
    """Header and arrays of a skill; `facts` are its other attributes as plain JSON values."""
    degree = int(model.surface.degrees[-1])
    numbers = {name: float(getattr(model, name)) for name in NUMBERS}
    header = {"kind": KIND, "version": VERSION, "degree": degree, "numbers": numbers, **facts}
    arrays = {
        "points": model.surface.points,
        "tangents": model.surface.tangents,
        "bends": model.surface.bends,
        "radii": model.surface.radii,
        "kernels": model.field.centres,
        "precision": np.array(model.field.precision),
        "weights": model.field.weights,
        "centre": model.centre,
        "kept": model.kept,
        "free": model.free,
        "free_extent": model.free_extent,
        "edges": model.edges,
        "trust": np.array(model.trust[:3]),
        "sure": model.trust.sure,
    }
    if route is not None:
        arrays |= {ROUTE + name: value for name, value in route.arrays().items()}
    return header, arrays


def unpack(path: str | PathLike[str]) -> tuple[Model, Route | None, dict[str, Any]]:
    """Model, route and other attributes of a saved skill.

    Raises:
        SkillFileError: whatever is wrong with the file.
    """
    header, arrays = archive.read(path, KIND)
    if header.get("version") != VERSION:
        raise SkillFileError(
            f"{path}: format version {shortened(header.get('version'))}; this skillfold reads {VERSION}."
        )
    with archive.blaming(path, "not a complete skill"):
        model = _model(header, arrays)
        return model, _route(arrays, model.n_dims), _facts(header, model.n_dims)


def facts_of(skill: Any) -> dict[str, Any]:
    """The attributes of a skill that are no arrays."""
    return {
        "space": skill.space.to_json(),
        "names": list(skill.names),
        "selection": skill.selection.to_json(),
        "noise": skill.noise,
        "residual": skill.residual,
        "ridge": skill.ridge,
        "converged": skill.converged,
        "n_samples": skill.n_samples,
        "notes": list(skill.notes),
    }


def _facts(header: dict[str, Any], n_dims: int) -> dict[str, Any]:
    space = StateSpace.from_json(header["space"])
    names = _texts(header["names"])
    if space.n_dims != n_dims or len(names) != n_dims:
        raise ValueError(f"{len(names)} names and {space.n_dims} kinds for {n_dims} coordinates")
    return {
        "space": space,
        "names": names,
        "selection": Selection(_trial(row) for row in header["selection"]),
        "noise": _number(header["noise"]),
        "residual": _number(header["residual"]),
        "ridge": _number(header["ridge"]),
        "converged": _only(bool, header["converged"]),
        "n_samples": whole("n_samples", header["n_samples"], 1, SAMPLES),
        "notes": _texts(header["notes"]),
    }


def _only(kind: type, value: Any) -> Any:
    """`value`, if it is of that kind and no other: to Python, true is 1 and text is a list of letters."""
    if type(value) is not kind:
        raise TypeError(f"{shortened(value)} where {kind.__name__} belongs")
    return value


def _texts(values: Any) -> tuple[str, ...]:
    return tuple(_only(str, value) for value in _only(list, values))


def _trial(row: Any) -> Trial:
    choice, setting, score, measure, chosen = _only(list, row)
    choice, setting, measure = (_only(str, text) for text in (choice, setting, measure))
    return Trial(choice, setting, float(score), measure, _only(bool, chosen))


def _number(value: Any) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not 0.0 <= value < np.inf:
        raise ValueError(f"{shortened(value)} where a finite number of 0 or more belongs")
    return float(value)


def _floats(arrays: archive.Arrays, name: str, shape: tuple[int, ...]) -> Any:
    array = arrays[name]
    if array.dtype != np.float64 or array.shape != shape or not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite float64 {shape}, found {array.dtype} {array.shape}")
    return np.array(array, order="C")


def _model(header: dict[str, Any], arrays: archive.Arrays) -> Model:
    D, inner = arrays["kept"].shape
    M = arrays["points"].shape[1]
    d, _, K = arrays["weights"].shape
    degree = whole("degree", header["degree"], 1, 8)
    terms = comb(d + degree, degree)
    # Compared before the table is made: of many dimensions and a high degree, it alone would fill the memory.
    fitting = arrays["bends"].shape == (M, inner, terms) and terms <= TERMS
    if not (1 <= d < inner <= D <= 1000 and M >= 2 and K >= 1 and fitting):
        raise ValueError(f"sizes D {D}, inner {inner}, d {d}, K {K}, M {M}, degree {degree} do not fit")
    table = monomials(d, degree)
    surface = build_surface(
        _floats(arrays, "points", (inner, M)),
        _floats(arrays, "tangents", (M, d, inner)),
        _floats(arrays, "bends", (M, inner, terms)),
        _positive("radii", _floats(arrays, "radii", (M,))),
        table,
    )
    field = Field(
        _floats(arrays, "kernels", (inner, K)),
        float(_positive("precision", _floats(arrays, "precision", ()))),
        _floats(arrays, "weights", (d, inner, K)),
    )
    edges = arrays["edges"]
    if edges.dtype != np.int64 or edges.shape[1:] != (2,) or edges.min() < 0 or edges.max() >= M:
        raise ValueError("edges do not name anchors")
    numbers = {name: _number(header["numbers"][name]) for name in NUMBERS}
    sure = arrays["sure"]
    if sure.dtype != np.bool_ or sure.shape != (M,) or not sure.any():
        raise ValueError("sure: expected a flag for each anchor, one set at least")
    spacing, doubt, cap = (float(t) for t in _positive("trust", _floats(arrays, "trust", (3,))))
    _positive("numbers", np.array([numbers["scale"], numbers["step"]]))
    return Model(
        surface=surface,
        field=field,
        centre=_floats(arrays, "centre", (D,)),
        kept=_floats(arrays, "kept", (D, inner)),
        free=_floats(arrays, "free", (D, D - inner)),
        free_extent=_floats(arrays, "free_extent", (D - inner,)),
        edges=edges,
        trust=trust_in(spacing, doubt, cap, sure),
        **numbers,
    )


def _positive(name: str, values: Any) -> Any:
    if not (values > 0.0).all():
        raise ValueError(f"{name} must be positive")
    return values


def _route(arrays: archive.Arrays, n_dims: int) -> Route | None:
    found = {name.removeprefix(ROUTE): a for name, a in arrays.items() if name.startswith(ROUTE)}
    if not found:
        return None
    route = Route.from_arrays(found)
    if len(route.centre) != n_dims:
        raise ValueError(f"a route of {len(route.centre)} coordinates in a skill of {n_dims}")
    return route
