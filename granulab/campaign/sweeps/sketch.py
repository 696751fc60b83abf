"""Sketches of cases before anything is run: what holds the particles, how far they fill it, shapes.

A simulator gives the panels of a case; cases that look alike share theirs.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.figure import (
    GREY,
    INK,
    SKY,
    WALL,
    headline,
    round_length,
    write_figure,
)
from granulab.campaign.runs.provenance import to_stderr
from granulab.errors import FolderError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Points = NDArray[np.float64]

BED = "#dcebf5"  # where particles are expected
_MOST_CASES = 6  # whose panels are drawn
_MOST_LOOKED_AT = 24  # of a study, for so many that differ
_COLUMNS, _WIDE, _HIGH = 4, 3.4, 4.0  # panels in a row, and a panel [inch]
_APART, _TALL = 2.5, 1.3  # distance of two shapes over the largest radius; of rows, over that
_HEAD = 0.55  # of a panel, for title and scale [inch]
_LETTER = 0.56  # mean width of a letter over the size of the type
_MARGIN = 0.06  # of a panel, left free around what it shows


class Filled(NamedTuple):
    """A polygon (n, 2) [m] and its colours."""

    points: Points
    face: Any
    edge: Any = "none"


class Panel(NamedTuple):
    """One panel, in metres.

    lines      walls; dashed: what opens, or is taken away
    spans      sizes: from a point to a point, with words
    words      texts, centred below points; type: their size [points]
    below      room for words at the bottom [m]
    """

    title: str
    filled: Sequence[Filled] = ()
    lines: Sequence[Points] = ()
    dashed: Sequence[Points] = ()
    spans: Sequence[tuple[tuple[float, float], tuple[float, float], str]] = ()
    words: Sequence[tuple[tuple[float, float], str]] = ()
    type: float = 7.5
    below: float = 0.0

    @property
    def window(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of what it shows [m]."""
        parts = [
            *(one.points for one in self.filled), *self.lines, *self.dashed,
            *(np.array([p, q]) for p, q, _ in self.spans), *(np.array([p]) for p, _ in self.words),
        ]  # fmt: skip
        low, high = (end(np.concatenate(parts), axis=0) for end in (np.min, np.max))
        margin = _MARGIN * float(max(high - low))
        left, bottom = low - margin - (0.0, self.below)
        right, top = high + margin
        return float(left), float(right), float(bottom), float(top)


Sketch = Callable[[Any], Sequence[Panel]]  # the panels of a case


def side_by_side(title: str, shapes: Sequence[tuple[Sequence[Filled], str]]) -> Panel:
    """Shapes, each about the origin, in rows at one scale, with words below each."""
    radius = max(float(np.hypot(*part.points.T).max()) for filled, _ in shapes for part in filled)
    pitch, columns = _APART * radius, math.ceil(math.sqrt(len(shapes)))
    placed: list[Filled] = []
    words = []
    for k, (filled, text) in enumerate(shapes):
        row, column = divmod(k, columns)
        x, y = column * pitch, -row * _TALL * pitch
        placed += [one._replace(points=one.points + np.array([x, y])) for one in filled]
        words.append(((x, y - 1.08 * radius), text))
    longest = max(len(line) for _, text in words for line in text.split("\n"))
    rows = -(-len(shapes) // columns)
    wide = min(_WIDE / columns, (_HIGH - _HEAD) / (_TALL * rows))  # of one shape [inch]
    size = min(7.5, 0.9 * 72.0 * wide / (_LETTER * longest))
    return Panel(title, filled=placed, words=words, type=size, below=0.3 * pitch)


def panels_of(cases: Iterable[Any], sketch: Sketch, look: Callable[[Any], Any]) -> list[Panel]:
    """The panels of a few cases, each once; look: of a case, what cases that look alike share."""
    first: dict[Any, Any] = {}
    for case in cases:
        first.setdefault(look(case), case)
        if len(first) == _MOST_LOOKED_AT:
            break
    panels: dict[Any, Panel] = {}
    for case in first.values():
        own = {(panel.title, panel.window): panel for panel in sketch(case)}
        if len(panels.keys() | own.keys()) > 2 * _MOST_CASES:
            break
        panels |= own
    return list(panels.values())


def draw_sketch(title: str, panels: Sequence[Panel]) -> "Figure":
    """A figure of panels to scale, each with a bar of a round length."""
    from matplotlib.figure import Figure

    columns = min(len(panels), _COLUMNS)
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(_WIDE * columns, _HIGH * rows + 0.4), layout="constrained")
    headline(figure, title)
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in grid[len(panels) :]:
        axes.set_axis_off()
    for axes, panel in zip(grid, panels, strict=False):
        _draw_panel(axes, panel)
    figure.draw_without_rendering()  # a title of several lines has its place after one layout only
    return figure


def _draw_panel(axes: "Axes", panel: Panel) -> None:
    from matplotlib.collections import LineCollection, PolyCollection

    left, right, bottom, top = panel.window
    if panel.filled:
        axes.add_collection(
            PolyCollection(
                [one.points for one in panel.filled], linewidths=0.6,
                facecolors=[one.face for one in panel.filled],
                edgecolors=[one.edge for one in panel.filled],
            )
        )  # fmt: skip
    axes.add_collection(LineCollection(list(panel.lines), colors=WALL, lw=2, capstyle="round"))
    axes.add_collection(LineCollection(list(panel.dashed), colors=GREY, lw=1.2, ls=(0, (3, 3))))
    for start, end, words in panel.spans:
        axes.annotate("", start, end, arrowprops={"arrowstyle": "<->", "color": INK, "lw": 0.8,
                                                  "shrinkA": 0, "shrinkB": 0})  # fmt: skip
        middle = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
        place: dict[str, Any] = {"xytext": (0, -3), "ha": "center", "va": "top"}
        if abs(end[1] - start[1]) > abs(end[0] - start[0]):
            place = {"xytext": (-3, 0), "ha": "right", "va": "center", "rotation": 90}
        axes.annotate(words, middle, textcoords="offset points", fontsize=8, **place)
    for (x, y), words in panel.words:
        axes.text(x, y, words, ha="center", va="top", fontsize=panel.type, linespacing=1.1)
    length = round_length((right - left) / 3)
    axes.plot([left, left + length], [bottom, bottom], color=INK, lw=2.5, solid_capstyle="butt")
    axes.annotate(f"{1e3 * length:g} mm", (left, bottom), (0, -3), textcoords="offset points",
                  va="top", fontsize=8)  # fmt: skip
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    axes.set_title(panel.title, fontsize=8.5, loc="left")
    axes.set_axis_off()


def particle_beside(
    particle: Sequence[Filled], right: float, bottom: float, words: str, apart: float = 0.0
) -> tuple[list[Filled], tuple[tuple[float, float], str]]:
    """A particle to the scale of the vessel that it is beside, and the words below it.

    right, bottom: of the vessel [m]; apart: least distance of the particle's middle from it [m].
    """
    points = np.concatenate([one.points for one in particle])
    low, high = points.min(axis=0), points.max(axis=0)
    width = float(high[0] - low[0])
    move = np.array([right + max(0.6 * width, apart - 0.5 * width) - low[0], bottom - low[1]])
    placed = [one._replace(points=one.points + move) for one in particle]
    x, y = float(move[0]) + float(low[0] + high[0]) / 2, bottom
    return placed, ((x, y), words)


def write_sketch(path: Path, title: str, panels: Sequence[Panel]) -> str | None:
    """Write a sketch; its path, or None and a line on stderr where it cannot be written."""
    try:
        return str(write_figure(path, lambda: draw_sketch(title, panels)))
    except FolderError as error:
        to_stderr(f"no picture: {error}")
        return None


def lit(light: NDArray[np.float64]) -> NDArray[np.float64]:
    """Colours (m, 3) of pieces that catch so much light (m,) from 0 to 1."""
    from matplotlib.colors import to_rgb

    return np.clip(light, 0.0, 1.0)[:, None] * np.array(to_rgb(SKY))
