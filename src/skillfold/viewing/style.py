"""One look for every picture: a small palette, thin lines, nothing that says nothing.

Figures are made and saved without pyplot, so that no global state is touched and no window is needed.
"""

from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from skillfold.errors import InputError

DPI = 160
INK, SOFT, FAINT = "#22272e", "#8a929c", "#d5d9de"  # text; demonstrations; frames
PLANS = ("#c8385a", "#0b7a75", "#d98512", "#4a4e9e")  # one colour per plan
TUNNEL = "#3b6ea5"  # the edge of what was demonstrated
OFF, ON = "#d1495b", "#0b7a75"  # states pushed off, and brought back
SURFACE = "#9db4cc"
FIELD = LinearSegmentedColormap.from_list("field", ["#ffffff", "#e3ebf3", "#b9cbe0", "#8faccd"])

SETTINGS: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 10.0,
    "text.color": INK,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.titlesize": 10.5,
    "axes.titlecolor": INK,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "lines.solid_capstyle": "round",
    "lines.solid_joinstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 9.5,
    "savefig.facecolor": "white",
}


def style() -> Any:
    """A context in which matplotlib draws in this look, and after which it draws as before."""
    return mpl.rc_context(SETTINGS)  # type: ignore[arg-type]


def figure(width: float, height: float) -> Figure:
    """An empty figure, in inches."""
    made = Figure(figsize=(width, height), layout=None, dpi=DPI)
    FigureCanvasAgg(made)
    return made


def save(made: Figure, path: Path) -> Path:
    """Write the picture.

    Raises:
        InputError: the file cannot be written.
    """
    try:
        made.savefig(path, dpi=DPI)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}.") from None
    return path


def bare(ax: Axes) -> None:
    """A plane of space: equal units on both axes, no frame and no ticks."""
    ax.set_aspect("equal")
    ax.set_xticks([])
    ax.set_yticks([])
    for spine in ax.spines.values():
        spine.set_visible(False)
