"""From samples to a `Model`, step by step: dimension, surfaces, denoised anchors, graph, tangent field."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from joblib import effective_n_jobs

from skillfold.errors import InputError
from skillfold.manifold.anchors import LocalSurfaces
from skillfold.manifold.calibration import HALF_WAY, POOL, calibrate
from skillfold.manifold.free import split_directions
from skillfold.manifold.graph import align_frames, build_graph
from skillfold.manifold.inputs import amount, seed_of, whole
from skillfold.manifold.kernels.surface import Field, Surface
from skillfold.manifold.model import Model, as_maps, build_surface
from skillfold.manifold.polynomials import monomials
from skillfold.manifold.samples import SPARE, crowds, told_apart
from skillfold.manifold.selection import choose_field
from skillfold.manifold.shapes import LARGEST, Progress, choose_shapes, spread_out
from skillfold.manifold.smoothing import denoised
from skillfold.manifold.table import Selection
from skillfold.manifold.tangent import TangentField, train
from skillfold.manifold.unrolled import Columns, unrolled

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

MOST_ANCHORS = 2000
LEAST, PER_ANCHOR = 4, 10  # times the samples per anchor: neighbourhoods tried, where samples are many
EDGES = 2000  # that the field is trained on
WORKERS = 4096  # that one may ask for; negative numbers count down from the cores, as in joblib


@dataclass(frozen=True)
class Fitted:
    """A model and what was learnt about the learning.

    Attributes:
        model: the manifold.
        field: H as trained, with its convergence flag.
        ridge: λ that was used.
        noise: standard deviation of the samples about the surface, per normal direction, in state units.
        residual: held-out rms residual, in state units.
        selection: every choice made.
    """

    model: Model
    field: TangentField
    ridge: float
    noise: float
    residual: float
    selection: Selection


@dataclass(frozen=True)
class Options:
    """What the user may fix; None leaves it to cross-validation."""

    dim: int | None = None
    kernels: int | None = None
    ridge: float | None = None
    neighbors: int | None = None
    seed: int = 0
    jobs: int = -1

    def check(self, n_samples: int, n_dims: int) -> None:
        """Refuse what cannot be fitted to so many samples of so many dimensions.

        Raises:
            InputError: says what is possible.
        """
        if n_dims < 2:
            raise InputError("A manifold needs states of two or more coordinates.")
        if n_samples < n_dims + SPARE:
            raise InputError(f"{n_samples} distinct samples of {n_dims} coordinates; {n_dims + SPARE} at least.")
        most = {"dim": n_dims - 1, "kernels": n_samples, "neighbors": n_samples - 1}
        for name, high in most.items():
            if (value := getattr(self, name)) is not None:
                whole(name, value, 1, high, or_none=True)
        if self.ridge is not None:
            amount("ridge", self.ridge)
        seed_of(self.seed)
        if whole("jobs", self.jobs, -WORKERS, WORKERS) == 0:
            raise InputError("jobs=0; expected a number of workers, or -1 for as many as there are cores.")


def fit_model(
    samples: Array, groups: Indices | None, quaternions: Columns, options: Options, progress: Progress
) -> Fitted:
    """Learn the manifold that samples (N, D) lie on.

    Args:
        samples: finite, distinct; recordings one after the other.
        groups: (N,) recording of each sample, or None for samples without order.
        quaternions: (n, 4) columns of each.
        options: what the user fixed.
        progress: called with a stage and its share done.
    """
    centre = samples.mean(0)
    scale = float(np.sqrt(((samples - centre) ** 2).sum(1).mean()))
    inner = (samples - centre) / scale
    threads = effective_n_jobs(options.jobs)  # once: to count cores takes time
    chosen = _anchor_choice(inner, options.seed)
    anchor_groups = groups[chosen] if groups is not None else None
    neighbors = options.neighbors or min(max(6, 2 * inner.shape[1]), 10)
    _check_together(inner[chosen], neighbors, anchor_groups, scale)
    progress("looking for the dimension", 0.0)
    # Samples without order may fill all orientations; their constraint is the unit length.
    shown = inner if groups is None else unrolled(samples, quaternions) / scale
    split, trials = split_directions(inner, groups, options.dim, options.seed, threads, shown)
    outer, inner, dim = inner, inner @ split.kept, split.dim
    if split.free.shape[1]:  # samples that differ in nothing else would predict each other perfectly
        inner, groups = told_apart(inner, groups)
        chosen = _anchor_choice(inner, options.seed)
        anchor_groups = groups[chosen] if groups is not None else None
        neighbors = min(neighbors, len(chosen) - 1)
    judged = choose_shapes(inner, groups, dim, _sizes(len(inner), len(chosen)), options.seed, threads, progress)
    trials += judged.trials
    progress("fitting the anchors", 0.0)
    anchors, local, more = denoised(inner, chosen, judged, dim, groups is None, options.seed, threads)
    trials += more
    graph = build_graph(anchors, neighbors, anchor_groups, too_long=np.inf)
    frames = align_frames(local.tangents, graph)
    edges = graph.edges[spread_out(len(graph.edges), EDGES, options.seed)]
    features, ridge, more = choose_field(
        anchors,
        edges,
        frames,
        anchor_groups,
        options.kernels,
        options.ridge,
        options.seed,
        options.jobs,
        progress,
    )
    trials += more
    progress("training the tangent field", 0.0)
    field = train(features, anchors, edges, frames, ridge)
    surface, kernel_field = _kernel_surface(anchors, local, judged.degree, threads), _kernel_field(field)
    stride = graph.stride(len(anchors))
    tolerance, trust = calibrate(surface, kernel_field, inner, chosen, judged, stride, options.seed, threads)
    model = Model(
        surface=surface,
        field=kernel_field,
        centre=centre,
        scale=scale,
        kept=np.ascontiguousarray(split.kept),  # as a saved one comes back: products round by the layout
        free=np.ascontiguousarray(split.free),
        free_extent=np.abs(outer @ split.free).max(0) * scale,
        edges=graph.edges,
        step=max(graph.median, HALF_WAY * stride),
        tolerance=tolerance,
        trust=trust,
    )
    progress("training the tangent field", 1.0)
    normals = max(1, inner.shape[1] - dim)
    residual = judged.residual * scale
    return Fitted(model, field, ridge, residual / np.sqrt(normals), residual, Selection(trials))


def _check_together(points: Array, neighbors: int, groups: Indices | None, scale: float) -> None:
    """Say early where samples fall apart; crowds each make one place."""
    crowd = crowds(points)
    if crowd is not None:
        points, groups = points[np.sort(np.unique(crowd, return_index=True)[1])], None
    build_graph(points, min(neighbors, len(points) - 1), groups, scale=scale)


def _anchor_choice(inner: Array, seed: int) -> Indices:
    """All samples, or so many that lie far from each other."""
    if len(inner) <= MOST_ANCHORS:
        return np.arange(len(inner))
    pool = spread_out(len(inner), POOL, seed)
    points = inner[pool]
    chosen = np.zeros(MOST_ANCHORS, dtype=np.int64)
    distance = ((points - points[0]) ** 2).sum(1)
    for i in range(1, MOST_ANCHORS):
        chosen[i] = int(distance.argmax())
        np.minimum(distance, ((points - points[chosen[i]]) ** 2).sum(1), out=distance)
    return np.sort(pool[chosen])


def _sizes(n_samples: int, n_anchors: int) -> tuple[int, int]:
    """Smallest and largest neighbourhood: where samples are many, the surfaces must reach from anchor to anchor.

    Of dense samples with noise the nearest few lie scattered evenly in all directions and show no surface; that
    they predict each other well only says that they were chosen for being near.
    """
    share = n_samples / n_anchors
    return int(LEAST * share), max(LARGEST, min(n_samples // 2, int(PER_ANCHOR * share)))


def _kernel_surface(anchors: Array, local: LocalSurfaces, degree: int, jobs: int) -> Surface:
    """Arrays for the kernels; centred on the denoised anchors, so that the constant terms vanish."""
    coefficients = np.swapaxes(local.coefficients, 1, 2).copy()
    coefficients[:, :, 0] = 0.0
    tangents, bends = as_maps(local.frames, coefficients, local.radii)
    table = monomials(local.dim, degree)
    return build_surface(np.ascontiguousarray(anchors.T), tangents, bends, local.radii, table, jobs)


def _kernel_field(field: TangentField) -> Field:
    return Field(
        np.ascontiguousarray(field.features.centres.T),
        1.0 / (2.0 * field.features.width**2),
        np.ascontiguousarray(np.swapaxes(field.weights, 1, 2)),
    )
