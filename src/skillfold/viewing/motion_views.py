"""Motions in two or three dimensions on paper: one direction to look from, equal scales, the axes in a corner.

The world is seen from far away, so that lengths are alike wherever they are; a motion in the plane is seen as it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.motion import Array
from skillfold.viewing.envelope_pictures import view
from skillfold.viewing.style import INK, SOFT, bare

ELEVATION, ASIDE = 22.0, -68.0  # degrees, of the direction one looks from; from the level way of the motions
ROOM = 0.07  # around all that is shown, of its extent
CORNERS = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0))


@dataclass(frozen=True)
class Seen:
    """A plane (2, D) that states are seen in, and the lowest and highest corner (2,) of what is shown there."""

    plane: Array
    low: Array
    high: Array

    @classmethod
    def of(cls, recordings: Sequence[Array], turn: float = 0.0) -> "Seen":
        """What shows recordings (n, D), each from a start to a goal; turned by so many degrees about the vertical."""
        first, states = recordings[0], np.concatenate(recordings)
        plane = np.eye(2)
        if first.shape[1] == 3:
            way = first[-1] - first[0]
            plane = view(ELEVATION, float(np.degrees(np.arctan2(way[1], way[0]))) + ASIDE + turn)
        seen = states @ plane.T
        room = ROOM * np.ptp(seen, axis=0).max()
        return cls(plane, seen.min(axis=0) - room, seen.max(axis=0) + room)

    def __call__(self, states: Array) -> Array:
        """Where states (..., D) are seen: (..., 2)."""
        return states @ self.plane.T

    @property
    def ratio(self) -> float:
        """Height over width."""
        return float((self.high - self.low)[1] / (self.high - self.low)[0])

    def frame(self, ax: Any) -> None:
        """Equal units, nothing but what is drawn."""
        bare(ax)
        ax.set(xlim=(self.low[0], self.high[0]), ylim=(self.low[1], self.high[1]))

    def free_corner(self, recordings: Sequence[Array], taken: Sequence[int] = ()) -> int:
        """Which of `CORNERS` of the frame is farthest from all recordings."""
        seen = (self(np.concatenate(recordings)) - self.low) / (self.high - self.low)
        gaps = [np.linalg.norm(seen - corner, axis=1).min() for corner in np.array(CORNERS)]
        return max((i for i in range(len(CORNERS)) if i not in taken), key=lambda i: gaps[i])

    def axes(self, ax: Any, corner: int, length: float = 0.09) -> None:
        """The world's axes, of a share of the frame's width, in a corner."""
        size = length * (self.high - self.low)[0]
        inner = size * 1.9 * np.array([1.0, 1.0])
        foot = np.where(np.array(CORNERS[corner]) > 0, self.high - inner, self.low + inner)
        for name, axis in zip("xyz", self.plane.T, strict=False):
            ax.plot(*np.array([foot, foot + size * axis]).T, color=SOFT, linewidth=1.3, zorder=6)
            ax.text(*(foot + 1.3 * size * axis), name, color=SOFT, fontsize=8.5, ha="center", va="center")
        ax.plot(*foot, marker="o", color=INK, markersize=2.5, zorder=7)
