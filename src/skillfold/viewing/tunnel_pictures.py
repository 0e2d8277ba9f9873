"""Figure 32 of paper 000: the distance from the manifold around the recordings, as three transparent shells.

Light is gathered along every line of sight through the distances on a grid: near the shells it is caught in their
colours, between them it passes. A set in the plane is shown as a field.
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from skillfold.experiments.pick_place import Compared
from skillfold.motion import Array
from skillfold.viewing.motion_views import Seen
from skillfold.viewing.style import FIELD, INK, OFF, figure, save, style

SHELLS = (1.0, 2.5, 4.0)  # distances of the shells, in the skill's tolerance
COLORS, CAUGHT = ("#3b6ea5", "#d98512", "#c8385a"), (0.85, 0.2, 0.1)  # nearest first; share of the light
TURNS = (-35.0, 0.0, 50.0)  # degrees about the vertical: three views
CELLS = 24  # of the grid along the longest side
PIXELS, DEEP = 200, 64  # of an image's width, and steps along a line of sight
WIDE, HEAD, FOOT = 4.1, 0.34, 0.42  # inches
LEVELS = 12  # of a field in the plane


def draw(compared: Compared, path: Path) -> Path:
    """Write the picture.

    Raises:
        InputError: the file cannot be written.
    """
    with style():
        return save(tunnel(compared), path)


def tunnel(compared: Compared) -> Figure:
    """Three views in space, one in the plane."""
    recordings = compared.motions.recordings
    low, high = _box(compared)
    flat = recordings[0].shape[1] == 2
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(len(low), -1).T
    shown = [_around(Seen.of(recordings, turn), corners) for turn in ((0.0,) if flat else TURNS)]
    tall = WIDE * max(seen.ratio for seen in shown)
    made = figure(len(shown) * (WIDE + 0.15) + 0.1, tall + HEAD + FOOT)
    grid = None if flat else _distances(compared, low, high)
    for i, seen in enumerate(shown):
        room = np.array([0.1 + i * (WIDE + 0.15), FOOT, WIDE, tall])
        ax = made.add_axes(tuple((room / np.tile(made.get_size_inches(), 2)).tolist()))
        seen.frame(ax)
        if grid is None:
            _field(ax, compared, seen)
        else:
            image = gathered(grid, compared.skill.tolerance * np.array(SHELLS), low, high, seen)
            extent = (seen.low[0], seen.high[0], seen.low[1], seen.high[1])
            ax.imshow(image, extent=extent, origin="lower", interpolation="bilinear", zorder=1)
            seen.frame(ax)
            seen.axes(ax, seen.free_corner(recordings), 0.07)
        _recordings(ax, compared, seen)
    title = f"distance from a manifold of d = {compared.skill.dim}"
    made.text(0.1 / made.get_figwidth(), 1.0 - 0.26 / made.get_figheight(), title, fontweight="bold", fontsize=10.5)
    made.legend(handles=_handles(compared, flat), loc="lower center", ncols=6, columnspacing=1.5)
    return made


def gathered(grid: Array, levels: Array, low: Array, high: Array, seen: Seen) -> Array:
    """What is seen of shells at levels of a grid (n, m, k) over a box: (height, width, 4), the lowest row first."""
    from scipy.ndimage import map_coordinates

    deep = np.cross(*seen.plane)
    middle, reach = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))
    across, up = (np.linspace(a, b, n) for a, b, n in zip(seen.low, seen.high, _pixels(seen), strict=True))
    away = np.linspace(reach, -reach, DEEP)  # nearest to the eye first
    places = (
        across[None, None, :, None] * seen.plane[0]
        + up[None, :, None, None] * seen.plane[1]
        + (away[:, None, None, None] + middle @ deep) * deep
    )
    steps = (np.array(grid.shape) - 1) / (high - low)
    found = map_coordinates(grid, np.moveaxis((places - low) * steps, -1, 0), order=1, cval=np.nan)
    return _composed(found, levels, (away[0] - away[1], up[1] - up[0], across[1] - across[0]))


def _composed(found: Array, levels: Array, spacing: tuple[float, float, float]) -> Array:
    """Light caught by shells, from distances (depth, height, width), front to back."""
    slopes = np.gradient(found, *spacing)
    steep = np.sqrt(sum(slope**2 for slope in slopes)) + 1e-12
    facing = np.nan_to_num(np.abs(0.8 * slopes[0] + 0.5 * slopes[1] - 0.33 * slopes[2]) / steep)
    color, clear = np.zeros((*found.shape[1:], 3)), np.ones(found.shape[1:])
    tints = np.array([to_rgb(c) for c in COLORS])
    passed = [_crossed(found, level) for level in levels]
    for i in range(len(found) - 1):
        for crossed, tint, caught in zip(passed, tints, CAUGHT, strict=True):
            here = clear * caught * crossed[i]
            color += (here * (0.72 + 0.28 * facing[i]))[..., None] * tint + (here * 0.12 * facing[i] ** 8)[..., None]
            clear = clear - here
    held = 1.0 - clear
    return np.dstack([np.clip(color / np.maximum(held, 1e-9)[..., None], 0.0, 1.0), held])


def _crossed(found: Array, level: float) -> Array:
    """1 where a shell lies between a step and the next, softly, so that no steps are seen."""
    a, b = found[:-1] - level, found[1:] - level
    return np.where(np.isfinite(a) & np.isfinite(b) & (a * b <= 0.0), 1.0, 0.0)


def _distances(compared: Compared, low: Array, high: Array) -> Array:
    """On a grid of about equal cells over the box."""
    counts = np.maximum(np.round(CELLS * (high - low) / (high - low).max()).astype(int), 4)
    axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, counts, strict=True)]
    return np.asarray(compared.skill.distance(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)), np.float64)


def _box(compared: Compared) -> tuple[Array, Array]:
    states = np.concatenate(compared.motions.recordings)
    room = 1.15 * SHELLS[-1] * float(compared.skill.tolerance)
    return states.min(axis=0) - room, states.max(axis=0) + room


def _around(seen: Seen, corners: Array) -> Seen:
    """The same view of all that lies between corners (n, D)."""
    places = seen(corners)
    return Seen(seen.plane, places.min(axis=0), places.max(axis=0))


def _pixels(seen: Seen) -> tuple[int, int]:
    return PIXELS, round(PIXELS * seen.ratio)


def _field(ax: Any, compared: Compared, seen: Seen) -> None:
    x, y = (np.linspace(a, b, 3 * CELLS) for a, b in zip(seen.low, seen.high, strict=True))
    ax.contourf(x, y, compared.skill.distance(np.stack(np.meshgrid(x, y), axis=-1)), LEVELS, cmap=FIELD, zorder=0)


def _recordings(ax: Any, compared: Compared, seen: Seen) -> None:
    for recording in compared.motions.recordings:
        ax.plot(*seen(recording).T, color="white", linewidth=2.0, alpha=0.6, zorder=3)
        ax.plot(*seen(recording).T, color=INK, linewidth=0.9, zorder=4)
        ax.plot(*seen(recording[0]), marker="x", color=OFF, markersize=5.0, zorder=5)
    ax.plot(*seen(compared.motions.goal), marker="s", color=OFF, markersize=5.5, markeredgecolor="white", zorder=6)


def _handles(compared: Compared, flat: bool) -> list[Any]:
    shells = [] if flat else list(zip(SHELLS, COLORS, CAUGHT, strict=True))
    size = float(compared.skill.tolerance)
    patches = [Patch(color=c, alpha=min(1.0, 0.25 + a), label=f"distance {s * size:.2g}") for s, c, a in shells]
    lines = [
        Line2D([], [], color=INK, linewidth=1.0, label="recordings"),
        Line2D([], [], linestyle="none", marker="x", color=OFF, markersize=5.0, label="start"),
        Line2D([], [], linestyle="none", marker="s", color=OFF, markersize=5.5, label="goal"),
    ]
    return [*patches, *lines]
