"""Soft-envelopes in pictures: in the plane and in space, with poses drawn inside (paper 002, figures 2 and 3)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from skillfold.motion import Array
from skillfold.viewing.style import FAINT, INK, SOFT, TUNNEL, bare

PARENT, CHILD = "#c8385a", "#3b6ea5"  # as in the paper: red and blue
FILL = "#dfe8f1"
SLICES, AROUND = 120, 72  # of the envelope, and of each outline
RINGS = 15  # sections that are drawn in space
ARROWS = 0.12  # of the frame, the world's axes
ELEVATION, AZIMUTH = 24.0, -62.0  # degrees, of the view in space


def positions(envelope: Any, count: int = SLICES) -> tuple[Array, Array]:
    """Means (count, 3) and gated covariances (count, 3, 3) of the tool's position, along the envelope."""
    s = np.linspace(0.0, 1.0, count)
    return envelope.means_at(s)[:, :3], envelope.covariances_at(s)[:, 0]


def ellipse(mean: Array, covariance: Array) -> Array:
    """Outline (n, 2) of what v'Σ⁻¹v ≤ 1 covers of the plane."""
    angle = np.linspace(0.0, 2 * np.pi, AROUND)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    return mean + circle @ np.linalg.cholesky(covariance).T


def flat(ax: Any, envelope: Any, axes: Sequence[int], samples: Array | None = None) -> None:
    """The envelope's shadow on the plane of two axes of the world, with the two Gaussians and samples (n, 7)."""
    shadow(ax, envelope, np.eye(3)[list(axes)], samples)


def space(ax: Any, envelope: Any, samples: Array | None = None) -> None:
    """The envelope in space, seen from the side and a little above, with sections across it and the world's axes."""
    plane = view(ELEVATION, AZIMUTH)
    covered = shadow(ax, envelope, plane, samples, rings=True)
    means, covariances = positions(envelope, RINGS)
    axis = means[-1] - means[0]
    for mean, covariance in zip(means[1:-1], covariances[1:-1], strict=True):
        ax.plot(*(section(mean, covariance, axis) @ plane.T).T, color=TUNNEL, linewidth=0.6, alpha=0.6, zorder=3)
    _world(ax, plane, covered)


def shadow(ax: Any, envelope: Any, plane: Array, samples: Array | None = None, rings: bool = False) -> Array:
    """The same on any plane (2, 3) of space; with rings the Gaussians are drawn as bodies. All outlines (n, 2)."""
    means, covariances = positions(envelope)
    outlines = [ellipse(plane @ m, plane @ c @ plane.T) for m, c in zip(means, covariances, strict=True)]
    edge: dict[str, Any] = {"closed": True, "facecolor": "none", "edgecolor": TUNNEL, "linewidth": 2.4}
    for outline in outlines:  # the edges of all, covered by the insides of all, are the edge of the union
        ax.add_patch(Polygon(outline, zorder=1, **edge))
    for outline in outlines:
        ax.add_patch(Polygon(outline, closed=True, facecolor=FILL, linewidth=0.0, zorder=2))
    if samples is not None:
        look: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 2.0, "color": TUNNEL, "alpha": 0.5}
        ax.plot(*(samples[:, :3] @ plane.T).T, zorder=3, **look)
    for k, color in ((0, PARENT), (-1, CHILD)):
        ax.add_patch(Polygon(outlines[k], closed=True, fill=False, edgecolor=color, linewidth=1.8, zorder=4))
        ax.plot(*(plane @ means[k]), marker="o", color=color, markersize=5.0, zorder=5)
        for ring in principal(means[k], covariances[k]) if rings else ():
            ax.plot(*(ring @ plane.T).T, color=color, linewidth=0.9, zorder=4)
    ax.plot(*(means[[0, -1]] @ plane.T).T, color=INK, linewidth=0.8, linestyle=":", zorder=3)
    _room(ax, np.concatenate(outlines))
    bare(ax)
    return np.concatenate(outlines)


def view(elevation: float, azimuth: float) -> Array:
    """The plane (2, 3) that one looks at from a direction [degrees]: to the right, and up."""
    up, around = np.radians(elevation), np.radians(azimuth)
    right = (-np.sin(around), np.cos(around), 0.0)
    above = (-np.sin(up) * np.cos(around), -np.sin(up) * np.sin(around), np.cos(up))
    return np.array([right, above])


def principal(mean: Array, covariance: Array) -> list[Array]:
    """The three principal outlines (n, 3) of an ellipsoid."""
    values, axes = np.linalg.eigh(covariance)
    scaled = axes * np.sqrt(values)
    return [_ring(mean, scaled[:, i], scaled[:, j]) for i, j in ((0, 1), (1, 2), (0, 2))]


def section(mean: Array, covariance: Array, axis: Array) -> Array:
    """Outline (n, 3) of an ellipsoid's section through its middle, across an axis (3,)."""
    across = np.linalg.svd(axis[None])[2][1:].T
    inside = np.linalg.inv(across.T @ np.linalg.inv(covariance) @ across)
    scaled = across @ np.linalg.cholesky(inside)
    return _ring(mean, np.asarray(scaled[:, 0], np.float64), np.asarray(scaled[:, 1], np.float64))


def _ring(mean: Array, first: Array, second: Array) -> Array:
    angle = np.linspace(0.0, 2 * np.pi, AROUND)[:, None]
    return mean + np.cos(angle) * first + np.sin(angle) * second


def _world(ax: Any, plane: Array, covered: Array) -> None:
    """The world's axes, in the corner that is farthest from what is covered (n, 2)."""
    low, high = np.array([ax.get_xlim(), ax.get_ylim()]).T
    length = ARROWS * (high - low).max()
    tips = length * plane.T
    room = 1.3 * np.array([tips.min(0).clip(max=0.0), tips.max(0).clip(min=0.0)])  # that the axes take up
    corners = np.array([low, high])
    feet = np.array([(corners[i, 0] - room[i, 0], corners[j, 1] - room[j, 1]) for i in (0, 1) for j in (0, 1)])
    middles = feet + room.mean(axis=0)
    foot = feet[int(np.argmax([np.linalg.norm(covered - middle, axis=1).min() for middle in middles]))]
    for name, tip in zip("xyz", tips, strict=True):
        ax.plot(*np.array([foot, foot + tip]).T, color=SOFT, linewidth=1.4, zorder=6)
        ax.text(*(foot + 1.25 * tip), name, color=SOFT, fontsize=8.5, ha="center", va="center")
    ax.plot(*foot, marker="o", color=FAINT, markersize=3.0, zorder=6)


def _room(ax: Any, points: Array) -> None:
    low, high = points.min(0), points.max(0)
    room = 0.04 * (high - low).max()
    ax.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))


def legend() -> list[Line2D]:
    """What the colours of the two Gaussians and of the envelope stand for."""
    dot: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 6.0}
    return [
        Line2D([], [], color=PARENT, label="first Gaussian", **dot),
        Line2D([], [], color=CHILD, label="second Gaussian", **dot),
        Line2D([], [], color=TUNNEL, linewidth=2.0, label="edge of the envelope"),
    ]
