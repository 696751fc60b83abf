"""The command that measures how far the texture of one picture has moved in another: piv."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from calibration.commands.options import sheets_option
from granulab.campaign.cli.commandline import json_option, quiet_option

if TYPE_CHECKING:
    from calibration.piv.answer import Answer


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
@sheets_option("Folder for table and sheet.")
@quiet_option
@json_option
def command(
    a: Path, b: Path, window: int, overlap: float, method: str, mask: Path | None,
    scale: str | None, dt: str | None, out: Path | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Displacement field between pictures A and B, with its uncertainty.

    The table (CSV) has a row for each window, the sheet (PNG) shows the vectors over A; x to the
    right, y downwards.

    For example: calibrate piv a.png b.png --scale "0.1 mm/px" --dt "2 ms" -o field
    """
    from calibration.piv.answer import measure_pair
    from calibration.statistics.quantity import metres_per_pixel
    from granulab.contact.files.units import to_si

    answer = measure_pair(
        a,
        b,
        window=window,
        overlap=overlap,
        method=method,
        mask=mask,
        scale=None if scale is None else metres_per_pixel(scale),
        dt=None if dt is None else to_si(dt, "s", "--dt"),
    )
    table, sheet = (None, None) if out is None else _written(answer, out)
    if as_json:
        files = {"table": table and str(table), "sheet": sheet and str(sheet)}
        click.echo(json.dumps(answer.as_json() | files, indent=2))
        return
    click.echo(_report(answer))
    if not quiet and table is not None:
        click.echo(f"table: {table}\nsheet: {sheet}", err=True)


def _written(answer: "Answer", out: Path) -> tuple[Path, Path]:
    from calibration.piv.figure import draw_sheet
    from granulab.campaign.output.table import as_csv
    from granulab.campaign.runs.folder import write_atomic

    name = f"{answer.first.stem}-{answer.field.method}"
    sheet = draw_sheet(answer, out / f"{name}.png")
    write_atomic(out / f"{name}.csv", as_csv(answer.rows()))
    return out / f"{name}.csv", sheet


def _report(answer: "Answer") -> str:
    """What was found, as text."""
    told = answer.as_json()
    lines = [
        f"{told['valid']} of {told['vectors']} vectors valid, windows of {told['window_px']} px"
    ]
    lost = {name: n for name, n in told["reasons"].items() if n and name != "measured"}
    lines += [f"  {n} {name.replace('_', ' ')}" for name, n in lost.items()]
    lines.append(f"{'[px]':6}{'mean':>10}{'sd':>10}{'lowest':>10}{'highest':>10}")
    for name in ("u", "v"):
        cells = "".join(f"{value:10.3f}" for value in told[f"{name}_px"].values())
        lines.append(f"{name:6}{cells}")
    sigma = told["sigma_px"]
    lines.append(f"sigma of a component {sigma['median']:.3f} px (median), {sigma['largest']:.3f} "
                 "px at most")  # fmt: skip
    if answer.unit != "px":
        speeds = answer.speed()[answer.field.valid]
        lines.append(f"size of a vector {speeds.mean():.4g} {answer.unit} (mean), "
                     f"{speeds.max():.4g} {answer.unit} at most")  # fmt: skip
    return "\n".join([*lines, *(f"warning: {words}" for words in answer.warnings)])
