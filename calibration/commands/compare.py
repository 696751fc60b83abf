"""The command that sets a simulated discharge beside a filmed one: compare."""

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from calibration.commands.film_options import Box
from calibration.commands.flow import film_options
from calibration.commands.options import sheets_option
from granulab.campaign.cli.commandline import json_option, quiet_option

if TYPE_CHECKING:
    from calibration.compare import Comparison


@click.command(short_help="A run folder beside a film")
@click.argument("run")
@click.argument("video")
@film_options
@click.option("--interval", metavar='"0.25 s"', help="Between profiles [default: 0.25 s].")
@sheets_option("Draw the figure there.")
@quiet_option
@json_option
def command(
    run: str, video: str, fps: float | None, scale: str | None, width: str | None,
    roi: Box | None, interval: str | None, out: Path | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Profiles and curve of a run folder beside those of a film, and how far they are apart.

    Without --scale or --width the film's silo is taken to be as wide as the run's.

    For example: calibrate compare runs/A4-seed1-17ee95093a40 silo.mp4 --out sheets
    """
    from calibration.compare import as_json as comparison_json
    from calibration.compare import columns_of, compare
    from calibration.flow.measure import measure_flow
    from calibration.flow.silo import Settings
    from granulab.campaign.cli.terminal import Progress

    columns, inner = columns_of(run)
    settings = Settings(fps, scale, width, roi, interval, columns, velocity=False)
    if scale is None and width is None:
        settings = replace(settings, width=f"{1e3 * inner:.9g} mm")
    with Progress("compare", quiet) as progress:
        flow = measure_flow(video, settings, progress.update)
    found = compare(run, flow)
    figure = None
    if out is not None:
        from calibration.compare_sheet import draw_comparison

        name = Path(video).stem
        figure = draw_comparison(found, out / f"compare-{name}.png", name)
    if as_json:
        answer = comparison_json(found) | {"figure": None if figure is None else str(figure)}
        click.echo(json.dumps(answer, indent=2))
    else:
        click.echo(_report(found, figure))


def _report(found: "Comparison", figure: Path | None) -> str:
    from calibration.statistics.quantity import plus_minus

    d, c = found.distance, found.curve_distance
    apart = plus_minus(1e3 * d.value, 1e3 * (d.sigma or 0))
    lines = [
        f"lines    {apart} mm apart (rms over {d.trials}); "
        f"equal flows would be {1e3 * found.floor:.2g} mm apart",
        f"curve    {plus_minus(c.value, c.sigma)} of the filling apart (rms)",
    ]
    if found.time_off is not None:
        off = plus_minus(found.time_off.value, found.time_off.sigma)
        lines.append(f"time     the run's discharge takes {off} s more than the film's")
    else:
        ended = found.scene.summary.get("outcome", "unfinished")
        lines.append(f"time     no difference: run {ended}, film {found.flow.outcome}")
    lines += [f"warning: {warning}" for warning in found.warnings]
    lines += [f"figure {figure}"] if figure is not None else []
    return "\n".join(lines)
