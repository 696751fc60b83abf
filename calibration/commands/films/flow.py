"""Commands for the film of a discharge: flow measures it, compare sets it against a run."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from calibration.commands.options import (
    Box,
    answers_options,
    figures_option,
    fps_option,
    roi_option,
)
from calibration.result import draw, finish
from granulab.campaign.cli.commandline import quiet_option


def film_options(command: Any) -> Any:
    """Options on a film: rate, scale, and where the silo is."""
    for option in (
        roi_option("The silo's inside, outlet to top [px]."),
        click.option(
            "--width", metavar='"300 mm"', help="The silo's inner width: gives the scale."
        ),
        click.option("--scale", metavar='"0.81 mm/px"', help="Length of a pixel."),
        fps_option,
    ):
        command = option(command)
    return command


@click.command(short_help="Discharge time, curve and layers from film")
@click.argument("video")
@film_options
@click.option("--interval", metavar='"0.25 s"', help="Between profiles [default: 0.25 s].")
@click.option(
    "--columns",
    type=int,
    default=11,
    help="Across the silo, two particles wide each [default: 11].",
)
@click.option("--layer-height", metavar='"45 mm"', help="Of layers to draw where none is painted.")
@click.option("--no-velocity", is_flag=True, help="Leave out the velocity fields, which take time.")
@click.option("--collapse", is_flag=True, help="A column that spreads on a plate: its front.")
@figures_option("Draw the diagnostic figure and write the tables there.")
@quiet_option
@answers_options  # fmt: skip
def flow(
    video: str, fps: float | None, scale: str | None, width: str | None, roi: Box | None,
    interval: str | None, columns: int, layer_height: str | None, no_velocity: bool,
    collapse: bool, out: Path | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Discharge time, curve, profiles of the layers and velocities from the film of a silo.

    VIDEO is a film from a camera that stands still, from before the opening to after the last
    particle, or a folder of pictures. Without --scale or --width lengths are in pixels.

    For example: calibrate flow silo.mp4 --width "300 mm" --out figures
    """
    from granulab.campaign.output.terminal import Progress

    if collapse:
        _refuse_of_layers()
        from calibration.flow.collapse import measure_collapse, write_table

        with Progress("flow", quiet) as progress:
            seen = measure_collapse(
                video, fps=fps, scale=scale, roi=roi, report=lambda part: progress.update(part)
            )
        files = []
        if out is not None:
            figure = out / f"collapse-{seen.path.stem}.png"
            files = [write_table(seen, out), draw(seen, figure)]
        finish(seen, as_json=as_json, quiet=quiet, figure_key=None, files={"files": files})
        return
    from calibration.flow.measure import measure_flow
    from calibration.flow.result import write_tables
    from calibration.flow.silo import Settings

    settings = Settings(fps, scale, width, roi, interval, columns, layer_height, not no_velocity)
    with Progress("flow", quiet) as progress:
        found = measure_flow(video, settings, progress.update)
    tables = [] if out is None else write_tables(found, out)
    finish(found, as_json=as_json, quiet=quiet, out=out, name=f"flow-{found.name}",
           files={"tables": tables})  # fmt: skip


def _refuse_of_layers() -> None:
    """UsageError where an option was given that a column which spreads does not take."""
    given = click.get_current_context().get_parameter_source
    for name in ("width", "interval", "columns", "layer_height", "no_velocity"):
        if given(name) is not ParameterSource.DEFAULT:
            raise click.UsageError(
                f"--{name.replace('_', '-')}: --collapse does not take it; leave it out, or "
                "--collapse (which takes --fps, --scale and --roi)"
            )


@click.command(short_help="A run folder compared with a film")
@click.argument("run")
@click.argument("video")
@film_options
@click.option("--interval", metavar='"0.25 s"', help="Between profiles [default: 0.25 s].")
@figures_option("Draw the figure there.")
@quiet_option
@answers_options
def compare(
    run: str, video: str, fps: float | None, scale: str | None, width: str | None,
    roi: Box | None, interval: str | None, out: Path | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Profiles and curve of a run folder compared with those of a film, and their distance.

    Without --scale or --width the film's silo is taken to be as wide as the run's.

    For example: calibrate compare runs/A4-seed1-17ee95093a40 silo.mp4 --out figures
    """
    from calibration.compare import columns_of, compared
    from calibration.flow.measure import measure_flow
    from calibration.flow.silo import Settings
    from granulab.campaign.output.terminal import Progress

    columns, inner = columns_of(run)
    settings = Settings(fps, scale, width, roi, interval, columns, velocity=False)
    if scale is None and width is None:
        settings = replace(settings, width=f"{1e3 * inner:.9g} mm")
    with Progress("compare", quiet) as progress:
        film = measure_flow(video, settings, progress.update)
    finish(compared(run, film), as_json=as_json, quiet=quiet, out=out,
           name=f"compare-{Path(video).stem}", figure_key="figure")  # fmt: skip


commands = {"flow": flow, "compare": compare}
