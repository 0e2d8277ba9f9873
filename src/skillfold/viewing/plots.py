"""What pictures are made of: demonstrations, plans, tangents, projections and the distance field of a skill.

Every function draws on the axes it is given, two- or three-dimensional, and returns nothing.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from mpl_toolkits.mplot3d.art3d import Line3DCollection

from skillfold.motion import Array
from skillfold.viewing.style import FIELD, INK, OFF, ON, PLANS, SOFT, TUNNEL

LIGHT = np.array([-0.3, -0.5, 0.81])  # where it comes from, in space


def demonstrations(ax: Any, recordings: Iterable[Array], color: str = SOFT) -> None:
    """Recordings (n_steps, D) as thin lines."""
    for states in recordings:
        ax.plot(*states.T, color=color, linewidth=1.0, alpha=0.85, zorder=2)


def samples(ax: Any, states: Array) -> None:
    """Samples (N, D) without order."""
    ax.plot(*states.T, linestyle="none", marker="o", color=SOFT, markersize=2.6, markeredgewidth=0.0, zorder=3)


def paths(ax: Any, states: Sequence[Array], colors: Sequence[str] = PLANS, width: float = 2.2) -> None:
    """Paths (n, D), each in its colour: open circle at the start, full one at the goal."""
    for index, path in enumerate(states):
        color = colors[index % len(colors)]
        ax.plot(*path.T, color=color, linewidth=width, zorder=5)
        ends = {"linestyle": "none", "marker": "o", "markeredgecolor": color, "markeredgewidth": 1.5, "zorder": 6}
        ax.plot(*path[:1].T, markersize=6.0, markerfacecolor="white", **ends)
        ax.plot(*path[-1:].T, markersize=4.5, markerfacecolor=color, **ends)


def distance_field(ax: Any, x: Array, y: Array, distance: Array, levels: Array) -> Any:
    """Distances (ny, nx) as soft bands with thin edges; returns what a colour bar needs."""
    bands = ax.contourf(x, y, distance, levels=levels, cmap=FIELD, extend="max", zorder=0)
    ax.contour(x, y, distance, levels=levels[1:], colors="white", linewidths=0.5, zorder=1)
    return bands


def tunnel(ax: Any, x: Array, y: Array, inside: Array) -> None:
    """The edge of what was demonstrated: where `inside` (ny, nx) is 1."""
    ax.contour(x, y, inside, levels=[1.0], colors=TUNNEL, linewidths=1.1, zorder=1.5)


def tangents(ax: Any, states: Array, bases: Array, length: float, colors: Sequence[str] = (ON, TUNNEL)) -> None:
    """Tangent bases (n, D, d) at states (n, D) as short strokes through them, a colour for each direction."""
    for axis in range(bases.shape[2]):
        strokes = bases[:, :, axis] * length / 2
        pieces = np.stack([states - strokes, states + strokes], axis=1)
        ax.add_collection(_lines(pieces, colors[axis % len(colors)], 1.6, zorder=4))


def projections(ax: Any, off: Array, on: Array, size: float = 3.6) -> None:
    """Disturbed states (n, D), the states they are brought back to, and the way between."""
    ax.add_collection(_lines(np.stack([off, on], axis=1), INK, 0.8, zorder=5, alpha=0.55))
    for states, color in ((off, OFF), (on, ON)):
        ax.plot(*states.T, linestyle="none", marker="o", color=color, markersize=size, markeredgewidth=0.0, zorder=6)


def surface(ax: Any, states: Array, dark: str, light: str = "#ffffff", every: int = 2) -> None:
    """A sheet (m, n, 3) in space, lit from above its side, with every few lines of its grid."""
    x, y, z = np.moveaxis(states, -1, 0)
    colors = LinearSegmentedColormap.from_list("sheet", [dark, light])(_brightness(states))
    ax.plot_surface(x, y, z, facecolors=colors, shade=False, linewidth=0.0, rstride=1, cstride=1, zorder=1)
    for pieces in (states[::every], np.swapaxes(states, 0, 1)[::every]):
        ax.add_collection(_lines(pieces, "white", 0.4, zorder=2))


def _brightness(states: Array) -> Array:
    """From 0 to 1 how squarely the light meets the sheet, (m, n)."""
    along, across = np.gradient(states, axis=(0, 1))
    normal = np.cross(along, across)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    lit = np.abs(normal @ LIGHT)
    return 0.75 * (lit - lit.min()) / max(float(np.ptp(lit)), 1e-12)


def _lines(pieces: Any, color: str, width: float, **options: Any) -> Any:
    kind = Line3DCollection if pieces[0].shape[1] == 3 else LineCollection
    return kind(list(pieces), colors=color, linewidths=width, capstyle="round", **options)
