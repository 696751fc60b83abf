"""Shapes of particles from a drawing or photograph: spheropolygons, their file and picture."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from granulab.contact.files.units import to_si
from granulab.errors import InputError
from silo2d.case.shape import Points
from silo2d.drawings.curves import joined, read_drawing
from silo2d.drawings.particles import Fitted, shape_file, spheropolygons
from silo2d.drawings.photograph import ENDINGS, Bar, Photographed, read_photograph

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHOWN = 48  # shapes in a picture, at most


@dataclass(frozen=True, eq=False)
class Imported:
    """Particles of a file as spheropolygons; SI.

    outlines      as they are drawn or photographed
    shapes        what they became, in the same order
    photograph    of a photograph: its scale, its bar, what was left out
    """

    path: Path
    outlines: list[Points]
    shapes: list[Fitted]
    spheroradius: float
    photograph: Photographed | None

    def lines(self) -> list[str]:
        """Words on the import: scale, number, and the error of each shape."""
        head = f"{len(self.shapes)} particles, spheroradius {1e3 * self.spheroradius:.3g} mm"
        if self.photograph is not None:
            taken = self.photograph
            bar = "" if taken.bar is None else ", bar from ({:.1f}, {:.1f}) to ({:.1f}, {:.1f}) px"
            head += f"; {1e3 * taken.scale:.4g} mm/px{bar.format(*taken.bar or ())}"
            if taken.left_out:
                head += f"; {taken.left_out} specks or cut by the border left out"
        return [head, *(shape.in_words() for shape in self.shapes)]

    def text(self) -> str:
        """The shape file."""
        origin = (
            f"Particles of {self.path.name}. Of each shape: the largest distance between the "
            "rounded\nshape and the outline it was made from, and the difference of their areas."
        )
        return shape_file(self.shapes, self.spheroradius, origin)


def positive_length(text: str | None, name: str) -> float | None:
    """A length above 0 [m], of an option or a field by its name; None where there is none."""
    if text is None:
        return None
    metres = to_si(text, "m", name)
    if not metres > 0:
        raise InputError(f"{name} = {text!r}: must be above 0, such as '0.5 mm'")
    return metres


def import_shapes(
    path: str | Path,
    *,
    spheroradius: float | None = None,
    tolerance: float | None = None,
    unit: str | None = None,
    layer: str | None = None,
    scale: float | None = None,
    bar_length: float | None = None,
    bar: Bar | None = None,
) -> Imported:
    """The particles of an SVG or DXF file, or of a picture, as spheropolygons.

    spheroradius, tolerance [m]: see spheropolygons; unit, layer of a drawing: see read_drawing;
    scale [m/px], bar_length [m] and bar [px] of a picture: see read_photograph.

    Raises InputError, one line that begins with the file.
    """
    path = Path(path)
    of_picture = path.suffix.lower() in ENDINGS
    given = {"scale": scale, "bar_length": bar_length, "bar": bar} if not of_picture else {
        "unit": unit, "layer": layer}  # fmt: skip
    if spare := [name for name, value in given.items() if value is not None]:
        kind = "a photograph" if of_picture else "a drawing"
        raise InputError(f"{path}: {kind} has no {spare[0].replace('_', ' ')}; leave it out")
    photograph = None
    if of_picture:
        photograph = read_photograph(path, scale=scale, bar_length=bar_length, bar=bar)
        outlines = photograph.outlines
    else:
        drawing = read_drawing(path, unit, layer)
        assert drawing.unit is not None
        curves = joined(drawing, str(path))
        if n_open := sum(not one.closed for one in curves):
            raise InputError(f"{path}: {n_open} open curves; particles are closed ones")
        outlines = [drawing.unit * one.points for one in curves]
    shapes, r = spheropolygons(outlines, str(path), spheroradius, tolerance)
    return Imported(path, outlines, shapes, r, photograph)


def draw(found: Imported) -> "Figure":
    """The outlines with the rounded shapes that stand for them, at one scale."""
    from matplotlib.figure import Figure

    from granulab.campaign.output.figure import BLUE, VERMILION

    pairs = list(zip(found.outlines, found.shapes, strict=True))[:_SHOWN]
    columns = min(8, len(pairs))
    rows = -(-len(pairs) // columns)
    figure = Figure(figsize=(1.5 * columns + 0.4, 1.8 * rows + 0.4), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    reach = 0.5e3 * max(float((o.max(axis=0) - o.min(axis=0)).max()) for o, _ in pairs) * 1.1
    for one in axes:
        one.set_axis_off()
    for one, (outline, shape) in zip(axes, pairs, strict=False):
        centre = (outline.min(axis=0) + outline.max(axis=0)) / 2
        for points, colour, width in ((outline, VERMILION, 2.5), (shape.rounded, BLUE, 1.0)):
            one.plot(*_closed(1e3 * (points - centre)), color=colour, linewidth=width)
        one.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
        words = f"{shape.name}: {len(shape.corners)} corners\n{1e3 * shape.error:.2g} mm"
        one.set_title(words, fontsize=7)
    figure.suptitle("outlines (orange), rounded shapes (blue), largest distance", fontsize=8)
    return figure


def _closed(points: Points) -> Sequence[Points]:
    return [*points.T[:, [*range(len(points)), 0]]]
