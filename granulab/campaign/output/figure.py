"""One look for all figures: colours, the style they are drawn in, and how they are written."""

import io
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from granulab.campaign.output.files import write_atomic, writing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PAPER, INK, WALL, RULE = "#fbfaf7", "#2b2b2b", "#55504a", "#e6e3dc"
# Okabe and Ito's colours, which the colour-blind distinguish.
BLUE, VERMILION, GREEN, ORANGE = "#0072b2", "#d55e00", "#009e73", "#e69f00"
SKY, PURPLE, GREY = "#56b4e9", "#cc79a7", "#8a8a8a"

_DPI = 160
_BOLD_ADVANCE = 0.7  # mean width of a bold letter over the size of the type
_STYLE: Any = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, so pictures look alike everywhere
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": WALL,
    "axes.labelcolor": INK,
    "grid.color": RULE,
    "grid.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": WALL,
    "ytick.color": WALL,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
}


def headline(figure: "Figure", words: str) -> None:
    """Put what a figure shows over it, on the left; long words smaller, so that they fit."""
    width = 0.98 * 72.0 * figure.get_figwidth()  # points
    size = min(13.0, width / (_BOLD_ADVANCE * max(map(len, words.split("\n")))))
    figure.suptitle(words, x=0.01, ha="left", fontsize=size, fontweight="bold")


def ruled(axes: "Axes", axis: Literal["x", "y", "both"] = "y") -> None:
    """Thin lines behind what is drawn: horizontal ones at the ticks of y, upright ones of x."""
    axes.grid(axis=axis)
    axes.set_axisbelow(True)


def entries(panels: "Iterable[Axes]") -> dict[str, Any]:
    """Handles of all that panels show, by their labels, for one legend."""
    found: dict[str, Any] = {}
    for axes in panels:
        found |= dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
    return found


def ticked(
    axes: "Axes", values: Iterable[float], inside: tuple[float, float] | None = None
) -> None:
    """Set ticks of x at these values, written as numbers, and no others; those inside if given."""
    low, high = inside or (-math.inf, math.inf)
    ticks = [value for value in values if low <= value <= high]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()


def write_figure(path: Path, draw: "Callable[[], Figure]") -> Path:
    """Write what `draw` makes as a PNG; its path. FolderError where it cannot be written."""
    image = as_png(draw)
    assert image is not None
    with writing(path.parent):
        path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, image)
    return path


def as_png(draw: "Callable[[], Figure | None]") -> bytes | None:
    """The PNG of what `draw` makes, in the style of all figures; None where it makes nothing."""
    from matplotlib import rc_context

    image = io.BytesIO()
    with rc_context(_STYLE):
        drawn = draw()
        if drawn is None:
            return None
        drawn.savefig(image, format="png", dpi=_DPI)
    return image.getvalue()


def round_length(length: float) -> float:
    """The largest of 1, 2, 5, 10, ... times a power of ten that is not above a length."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(k * power for k in (1, 2, 5) if k * power <= length * (1 + 1e-9))
