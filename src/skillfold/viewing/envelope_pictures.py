"""Soft-envelopes in pictures: in the plane and in space, with poses drawn inside (paper 002, figures 2 and 3)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import LightSource
from matplotlib.patches import Polygon

from skillfold.motion import Array
from skillfold.viewing.style import FAINT, INK, SOFT, TUNNEL, bare

PARENT, CHILD = "#c8385a", "#3b6ea5"  # as in the paper: red and blue
FILL, SHEET = "#dfe8f1", "#c9d8e8"
SLICES, AROUND = 80, 72  # of the envelope, and of its outline
SECTIONS, ANGLES, HALVINGS = 60, 48, 22  # of its surface in space
VIEW = (22.0, -58.0)  # degrees


def positions(envelope: Any, count: int = SLICES) -> tuple[Array, Array]:
    """Means (count, 3) and gated covariances (count, 3, 3) of the tool's position, along the envelope."""
    s = np.linspace(0.0, 1.0, count)
    return envelope.means_at(s)[:, :3], envelope.covariances_at(s)[:, 0]


def ellipse(mean: Array, covariance: Array, scale: float = 1.0) -> Array:
    """Outline (n, 2) of what v'Σ⁻¹v ≤ scale² covers of the plane."""
    angle = np.linspace(0.0, 2 * np.pi, AROUND)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    return mean + scale * circle @ np.linalg.cholesky(covariance).T


def flat(ax: Any, envelope: Any, axes: Sequence[int], samples: Array | None = None) -> None:
    """The envelope's shadow on the plane of two axes of the world, with the two Gaussians and samples (n, 7)."""
    axes = list(axes)
    means, covariances = positions(envelope)
    shadows = [(m[axes], c[np.ix_(axes, axes)]) for m, c in zip(means, covariances, strict=True)]
    outlines = [ellipse(*shadow) for shadow in shadows]
    edge: dict[str, Any] = {"closed": True, "facecolor": "none", "edgecolor": TUNNEL, "linewidth": 2.4}
    for outline in outlines:  # the edges of all, covered by the insides of all, are the edge of the union
        ax.add_patch(Polygon(outline, zorder=1, **edge))
    for outline in outlines:
        ax.add_patch(Polygon(outline, closed=True, facecolor=FILL, linewidth=0.0, zorder=2))
    if samples is not None:
        ax.plot(*samples[:, axes].T, linestyle="none", marker=".", markersize=2.0, color=TUNNEL, alpha=0.5, zorder=3)
    for k, color in ((0, PARENT), (-1, CHILD)):
        ax.add_patch(Polygon(outlines[k], closed=True, fill=False, edgecolor=color, linewidth=1.8, zorder=4))
        ax.plot(*shadows[k][0], marker="o", color=color, markersize=5.0, zorder=5)
    ax.plot(*means[[0, -1]][:, axes].T, color=INK, linewidth=0.8, linestyle=":", zorder=3)
    everything = np.concatenate(outlines)
    _room(ax, everything)
    bare(ax)


def surface(envelope: Any) -> Array:
    """Points (m, n, 3) of the surface around all positions inside, from behind the parent to beyond the child."""
    means, covariances = positions(envelope, 2 * SLICES)
    axis = means[-1] - means[0]
    length = float(np.linalg.norm(axis))
    axis = axis / length
    reach = np.sqrt(np.einsum("i,nij,j->n", axis, covariances, axis))
    along = np.linspace(0.0, length, len(means))
    first, last = float((along - reach).min()), float((along + reach).max())
    middle, half = (first + last) / 2, (last - first) / 2
    at = middle + half * np.cos(np.linspace(np.pi, 0.0, SECTIONS)) * (1.0 - 1e-6)  # closer where it rounds off
    across = np.linalg.svd(axis[None])[2][1:]
    angle = np.linspace(0.0, 2 * np.pi, ANGLES)
    outward = np.cos(angle)[:, None] * across[0] + np.sin(angle)[:, None] * across[1]
    centres = means[0] + at[:, None] * axis
    return _edge(centres, outward, means, np.asarray(np.linalg.inv(covariances), np.float64))


def _edge(centres: Array, outward: Array, means: Array, inverses: Array) -> Array:
    """Where rays (n, 3) outward from centres (m, 3) leave the union of ellipsoids, by halving."""
    low = np.zeros((len(centres), len(outward)))
    high = np.full_like(low, 2.0)
    for _ in range(HALVINGS):
        radius = 0.5 * (low + high)
        points = centres[:, None] + radius[..., None] * outward
        inside = _least(points.reshape(-1, 3), means, inverses).reshape(radius.shape) <= 1.0
        low, high = np.where(inside, radius, low), np.where(inside, high, radius)
    return centres[:, None] + low[..., None] * outward


def _least(points: Array, means: Array, inverses: Array) -> Array:
    least = np.full(len(points), np.inf)
    for mean, inverse in zip(means, inverses, strict=True):
        away = points - mean
        np.minimum(least, np.einsum("ni,ni->n", away @ inverse, away), out=least)
    return least


def space(ax: Any, envelope: Any, samples: Array | None = None, limits: Array | None = None) -> None:
    """Axes in space with the envelope's surface, its Gaussians' middles and samples (n, 7)."""
    ax.computed_zorder = False
    ax.set_proj_type("ortho")
    points = surface(envelope)
    shade = LightSource(300, 55)
    ax.plot_surface(
        *np.moveaxis(points, -1, 0),
        rstride=1,
        cstride=1,
        color=SHEET,
        shade=True,
        lightsource=shade,
        linewidth=0.0,
        antialiased=False,
        zorder=1,
    )
    if samples is not None:
        ax.plot(*samples[:, :3].T, linestyle="none", marker=".", markersize=2.0, color=INK, alpha=0.35, zorder=2)
    means, covariances = positions(envelope)
    for k, color in ((0, PARENT), (-1, CHILD)):
        for ring in _rings(means[k], covariances[k]):
            ax.plot(*ring.T, color=color, linewidth=1.3, zorder=3)
        ax.plot(*means[k], marker="o", color=color, markersize=4.0, zorder=4)
    box(ax, np.array([points.min((0, 1)), points.max((0, 1))]) if limits is None else limits)


def box(ax: Any, limits: Array, view: tuple[float, float] = VIEW) -> None:
    """Bare axes of space with equal units, from limits[0] to limits[1], and a bar of 10 cm."""
    low, high = limits
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect(high - low, zoom=1.35)
    ax.view_init(*view)
    ax.set_axis_off()
    corners = np.array([[low[0], low[1], low[2]], [high[0], low[1], low[2]], [high[0], high[1], low[2]]])
    ax.plot(*corners.T, color=FAINT, linewidth=0.8, zorder=0)
    foot = np.array([high[0], low[1], low[2]])
    ends = foot + np.array([[0.0, 0.0, 0.0], [0.0, 0.1, 0.0]])
    ax.plot(*ends.T, color=SOFT, linewidth=2.0, zorder=0)
    ax.text(*(ends.mean(axis=0) - [0.0, 0.0, 0.02]), "10 cm", color=SOFT, fontsize=8.0, ha="center", va="top")


def _rings(mean: Array, covariance: Array) -> list[Array]:
    """The three principal outlines (n, 3) of an ellipsoid."""
    values, axes = np.linalg.eigh(covariance)
    angle = np.linspace(0.0, 2 * np.pi, AROUND)
    scaled = axes * np.sqrt(values)
    pairs = ((0, 1), (1, 2), (0, 2))
    return [mean + np.cos(angle)[:, None] * scaled[:, i] + np.sin(angle)[:, None] * scaled[:, j] for i, j in pairs]


def _room(ax: Any, points: Array) -> None:
    low, high = points.min(0), points.max(0)
    room = 0.04 * (high - low).max()
    ax.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))
