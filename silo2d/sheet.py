"""One look for all figures: the style they are drawn in, and how they are written."""

import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from campaign.folder import write_atomic, writing
from silo2d.scene import INK, WALL

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DPI = 160
_STYLE: Any = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, so pictures look alike everywhere
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": WALL,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": WALL,
    "ytick.color": WALL,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
}


def headline(figure: "Figure", words: str) -> None:
    """Put what a figure shows over it, on the left."""
    figure.suptitle(words, x=0.01, ha="left", fontsize=13, fontweight="bold")


def write_figure(path: Path, draw: "Callable[[], Figure]") -> Path:
    """Write what `draw` makes as a PNG; its path. FolderError where it cannot be written."""
    from matplotlib import rc_context

    image = io.BytesIO()
    with rc_context(_STYLE):
        draw().savefig(image, format="png", dpi=_DPI)
    with writing(path.parent):
        path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, image.getvalue())
    return path
