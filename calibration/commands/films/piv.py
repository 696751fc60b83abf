"""The command that measures how far the texture of one picture has moved in another: piv."""

from pathlib import Path

import click

from calibration.commands.options import answers_options, figures_option
from calibration.result import finish
from granulab.campaign.cli.commandline import quiet_option


@click.command(short_help="Displacement field between two pictures")
@click.argument("a", type=click.Path(path_type=Path))
@click.argument("b", type=click.Path(path_type=Path))
@click.option("--window", default=32, metavar="32", help="Side of a window [px, default: 32].")
@click.option(
    "--overlap", default=0.5, metavar="0.5", help="Share of it, 0 to 0.75 [default: 0.5]."
)
@click.option(
    "--method", type=click.Choice(["piv", "flow"]), default="piv",
    help="Correlation of windows, or optical flow [default: piv].",
)  # fmt: skip
@click.option("--mask", type=click.Path(path_type=Path), help="A picture, white where to measure.")
@click.option("--scale", metavar='"0.81 mm/px"', help="Length per pixel.")
@click.option("--dt", metavar='"1 ms"', help="Time from A to B.")
@figures_option("Folder for table and diagnostic figure.")
@quiet_option
@answers_options
def command(
    a: Path, b: Path, window: int, overlap: float, method: str, mask: Path | None,
    scale: str | None, dt: str | None, out: Path | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Displacement field between pictures A and B, with its uncertainty.

    The table (CSV) has a row for each window, the diagnostic figure (PNG) shows the vectors
    over A; x to the right, y downwards.

    For example: calibrate piv a.png b.png --scale "0.1 mm/px" --dt "2 ms" -o field
    """
    from calibration.piv.result import measure_pair
    from calibration.statistics.quantity import metres_per_pixel
    from granulab.campaign.output.files import write_atomic, writing
    from granulab.campaign.output.table import as_csv
    from granulab.contact.files.units import to_si

    found = measure_pair(
        a,
        b,
        window=window,
        overlap=overlap,
        method=method,
        mask=mask,
        scale=None if scale is None else metres_per_pixel(scale),
        dt=None if dt is None else to_si(dt, "s", "--dt"),
    )
    name, table = f"{found.first.stem}-{found.field.method}", None
    if out is not None:
        table = out / f"{name}.csv"
        with writing(out, "--out"):
            out.mkdir(parents=True, exist_ok=True)
        write_atomic(table, as_csv(found.rows()))
    finish(found, as_json=as_json, quiet=quiet, out=out, name=name, files={"table": table})
