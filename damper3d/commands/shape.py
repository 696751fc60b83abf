"""The command that shows a particle's shape: shape."""

import json
from pathlib import Path
from typing import Any

import click

from granulab.campaign.cli.commandline import json_option

# Options that name a shape, the example of their values, and what they are.
_SHAPES = [
    ("prolate", "2", "Spheroid of this aspect ratio a/b, 1 to 10."),
    ("oblate", "0.7", "Spheroid of this aspect ratio, 0.2 to 1."),
    ("oblate-grid", "0.7", "The same as the thesis made it, of nine sub-spheres; 0.5 to 0.95."),
    ("toroid", "0.2", "Of this hole ratio (a - b)/(a + b), 0 to 0.8."),
    ("superquadric", "1,1,0.5,0.5", "Of b/a, c/a and the exponents e1, e2."),
    ("cylinder", "1.5,0.2", "Of this length over diameter, and radius of edges over its own."),
    ("mesh", "FILE", "Closed surface, .stl or .obj."),
    ("sphere", "5mm", "Of this diameter."),
]


def _shape_options(command: Any) -> Any:
    for name, example, text in reversed(_SHAPES):
        command = click.option(f"--{name}", metavar=example, help=text)(command)
    return command


@click.command()
@_shape_options
@click.option(
    "--equal-volume-radius", metavar='"3.8 mm"', help="Size [default: 3.8 mm; toroids 3.5 mm]."
)
@click.option("--mesh-unit", metavar="mm", help="Of a mesh that keeps its size.")
@click.option("--sub-spheres", type=int, metavar="N", help="How many stand for the shape.")
@click.option(
    "--tolerance", metavar="0.02", help="Or their surface error over the equal-volume radius."
)
@click.option("-o", "--out", default="runs/shapes", metavar="DIR", help="[default: runs/shapes]")
@click.option("--no-figures", is_flag=True, help="Make no picture.")
@json_option
def shape(
    out: str, no_figures: bool, as_json: bool, sub_spheres: int | None,
    equal_volume_radius: str | None, mesh_unit: str | None, tolerance: str | None,
    **shapes: str | None,
) -> None:  # fmt: skip
    """Make a particle of sub-spheres; print its mass properties, errors and cost; draw it.

    For example: damper3d shape --prolate 2, or damper3d shape --oblate 0.7 --tolerance 0.01
    """
    named = {kind: value for kind, value in shapes.items() if value is not None}
    if len(named) != 1:
        options = ", ".join(f"--{name}" for name, *_ in _SHAPES)
        raise click.UsageError(f"give one shape, such as --prolate 2; there are {options}")
    from damper3d.case.case import DamperCase
    from damper3d.case.parts import particle_wanted
    from damper3d.shapes.errors import curve, errors_of
    from damper3d.view.shape import as_text, summary
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.terminal import patience

    if not no_figures:
        refuse_unless_writable(Path(out), "--out")

    ((kind, value),) = named.items()
    given = {
        "shape": f"{kind}:{value}", "equal_volume_radius": equal_volume_radius,
        "sub_spheres": sub_spheres, "tolerance": tolerance, "mesh_unit": mesh_unit,
    }  # fmt: skip
    changes = {f"particles.{key}": value for key, value in given.items() if value is not None}
    with patience("preparing the particle's sub-spheres", quiet=as_json):
        case = DamperCase.load("thesis", changes)
        errors = errors_of(case.particle)
    found = summary(case, errors)
    click.echo(json.dumps(found, indent=2) if as_json else as_text(found))
    if no_figures:
        return
    from damper3d.view.shape import draw_shape
    from granulab.campaign.output.figure import write_figure

    path = Path(out) / f"{_file_name(case.particle.name)}-{len(case.particle.radii)}.png"
    points = curve(particle_wanted(case.settings.particles, Path()), errors.sub_spheres)
    write_figure(path, lambda: draw_shape(case.particle, points, errors))
    click.echo(path, err=True)


def _file_name(name: str) -> str:
    return name.replace(":", "-").replace(",", "-").replace(" ", "")
