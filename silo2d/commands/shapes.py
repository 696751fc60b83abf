"""The command on shapes of particles: shapes import, from drawings and photographs."""

import json
from pathlib import Path
from typing import Any

import click

from granulab.campaign.cli.commandline import json_option
from granulab.errors import InputError
from silo2d.commands.options import LAYER, UNIT


@click.group()
def shapes() -> None:
    """Shapes of particles from drawings and photographs."""


@shapes.command("import")
@click.argument("file")
@click.option("-o", "--output", metavar="FILE.toml", help="Shape file [default: FILE.toml here].")
@click.option("--spheroradius", metavar='"0.5 mm"', help="[default: a tenth of the smallest one].")
@click.option(
    "--tolerance", metavar='"0.1 mm"',
    help="Distance that rounded shapes may have from outlines [default: a fiftieth of their size].",
)  # fmt: skip
@UNIT
@LAYER
@click.option("--scale", metavar='"0.05 mm"', help="Of a photograph: length of a pixel.")
@click.option("--bar", metavar='"20 mm"', help="Instead: length of a scale bar in the photograph.")
@click.option("--bar-at", metavar="x,y,x,y", help="Its ends in pixels [default: it is found].")
@click.option("--no-figures", is_flag=True, help="Make no picture of shapes over outlines.")
@json_option
def import_(
    file: str, output: str | None, spheroradius: str | None, tolerance: str | None,
    unit: str | None, layer: str | None, scale: str | None, bar: str | None, bar_at: str | None,
    no_figures: bool, as_json: bool,
) -> None:  # fmt: skip
    """Make a shape file of the particles in a drawing or a photograph.

    FILE is an SVG or DXF whose closed curves are particles; or a picture of particles that lie
    apart on an even background. Each becomes a convex polygon with rounded corners; how far that is
    from its outline is printed, and stands in the file. Look at the picture.

    For example: silo2d shapes import stones.jpg --bar "20 mm" -o stones.toml
    """
    from granulab.campaign.cli.library import write_new
    from granulab.campaign.output.figure import write_figure
    from silo2d.drawings.shapes import draw, import_shapes, positive_length

    found = import_shapes(
        file, spheroradius=positive_length(spheroradius, "--spheroradius"),
        tolerance=positive_length(tolerance, "--tolerance"), unit=unit, layer=layer,
        scale=positive_length(scale, "--scale"), bar_length=positive_length(bar, "--bar"),
        bar=_ends(bar_at),
    )  # fmt: skip
    target = Path(output or f"{Path(file).stem}.toml")
    write_new(target, found.text())
    picture = None if no_figures else write_figure(target.with_suffix(".png"), lambda: draw(found))
    if as_json:
        click.echo(json.dumps(_as_json(found, target, picture), indent=2))
        return
    click.echo("\n".join(found.lines()))
    for path in filter(None, (target, picture)):
        click.echo(path, err=True)


def _as_json(found: Any, target: Path, picture: Path | None) -> dict[str, Any]:
    photograph = found.photograph
    return {
        "file": str(target),
        "spheroradius_m": found.spheroradius,
        "scale_m_per_px": photograph and photograph.scale,
        "left_out": photograph and photograph.left_out,
        "shapes": [
            {"name": one.name, "corners": len(one.corners), "error_m": one.error,
             "concavity_m": one.concavity, "area_ratio": one.area}
            for one in found.shapes
        ],
        "picture": picture and str(picture),
    }  # fmt: skip


def _ends(text: str | None) -> tuple[float, float, float, float] | None:
    """Both ends of a bar [px]."""
    if text is None:
        return None
    try:
        x, y, to_x, to_y = map(float, text.split(","))
    except ValueError:
        raise InputError(
            f"--bar-at = {text!r}: expected both ends in pixels, such as 600,605,800,605"
        ) from None
    return x, y, to_x, to_y
