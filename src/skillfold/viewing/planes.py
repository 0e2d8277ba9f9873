"""A skill of the plane: demonstrations in their tunnel, over the field of distances from it."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from scipy.ndimage import median_filter, zoom

from skillfold.experiments.demo import FINE, Field
from skillfold.motion import Array
from skillfold.viewing import plots
from skillfold.viewing.style import bare

SMOOTH = 4  # times finer than its grid the bands of a field are drawn
BANDS = 9
MOST = 0.9  # quantile of the distances that the bands reach up to


def plane(ax: Any, field: Field, demonstrations: Iterable[Array], bands: Array) -> Any:
    """Demonstrations (n_steps, 2) in their tunnel, over the field in bands at these distances; returns the bands."""
    drawn = plots.distance_field(ax, *_smooth(field), bands)
    plots.tunnel(ax, _finer(field.x, FINE), _finer(field.y, FINE), field.inside)
    plots.demonstrations(ax, demonstrations)
    ax.set_xlim(field.x[[0, -1]])
    ax.set_ylim(field.y[[0, -1]])
    bare(ax)
    return drawn


def levels(fields: Sequence[Field]) -> Array:
    """Bands that all fields share, up to a distance that most of their states stay below; a whole number apart.

    Where they would be less than one apart, they are as far apart as that distance asks for.
    """
    largest = float(np.quantile(np.concatenate([field.distance.ravel() for field in fields]), MOST))
    apart = largest / (BANDS - 1)
    return np.arange(BANDS, dtype=np.float64) * (float(np.ceil(apart)) if apart > 0.5 else max(apart, 1e-12))


def _smooth(field: Field) -> tuple[Array, Array, Array]:
    """The field on a finer grid; specks of a single state are not drawn as large as the grid is coarse."""
    distance = zoom(median_filter(field.distance, 3), SMOOTH, order=3, mode="nearest")
    return _finer(field.x, SMOOTH), _finer(field.y, SMOOTH), np.asarray(distance, dtype=np.float64).clip(min=0.0)


def _finer(values: Array, times: int) -> Array:
    return np.linspace(float(values[0]), float(values[-1]), times * len(values))
