"""The command that measures the film of a discharge, or of a column that collapses: flow."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from calibration.commands.film_options import Box, fps_option, roi_option
from calibration.commands.options import sheets_option
from granulab.campaign.cli.commandline import json_option, quiet_option

if TYPE_CHECKING:
    from calibration.flow.collapse import Collapse
    from calibration.flow.result import Flow


def film_options(command: Any) -> Any:
    """What is said of a film: rate, scale, and where the silo is."""
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
    "--columns", type=int, default=11, help="Across the silo, two grains wide each [default: 11]."
)
@click.option("--layer-height", metavar='"45 mm"', help="Of layers to draw where none is painted.")
@click.option("--no-velocity", is_flag=True, help="Leave out the velocity fields, which take time.")
@click.option("--collapse", is_flag=True, help="A column that spreads on a plate: its front.")
@sheets_option("Draw the sheet and write the tables there.")
@quiet_option
@json_option
def command(
    video: str, fps: float | None, scale: str | None, width: str | None, roi: Box | None,
    interval: str | None, columns: int, layer_height: str | None, no_velocity: bool,
    collapse: bool, out: Path | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Discharge time, curve, profiles of the layers and velocities from the film of a silo.

    VIDEO is a film from a camera that stands still, from before the opening to after the last
    grain, or a folder of pictures. Without --scale or --width lengths are in pixels.

    For example: calibrate flow silo.mp4 --width "300 mm" --out sheets
    """
    from granulab.campaign.cli.terminal import Progress

    if collapse:
        from calibration.flow.collapse import measure_collapse

        with Progress("flow", quiet) as progress:
            seen = measure_collapse(
                video, fps=fps, scale=scale, roi=roi, tell=lambda part: progress.update(part)
            )
        answer = seen.as_json() | {"files": _files_of_collapse(seen, out, video)}
        click.echo(json.dumps(answer, indent=2) if as_json else _collapse_report(answer))
        return
    from calibration.flow.measure import measure_flow
    from calibration.flow.result import as_json as flow_json
    from calibration.flow.silo import Settings

    settings = Settings(fps, scale, width, roi, interval, columns, layer_height, not no_velocity)
    with Progress("flow", quiet) as progress:
        flow = measure_flow(video, settings, progress.update)
    files = _files(flow, out, video)
    if as_json:
        click.echo(json.dumps(flow_json(flow) | files, indent=2))
    else:
        click.echo(_report(flow, files))


def _files(flow: "Flow", folder: Path | None, video: str) -> dict[str, Any]:
    """The sheet and the tables, where they are wanted."""
    if folder is None:
        return {"sheet": None, "tables": []}
    from calibration.flow.figure import draw_sheet
    from calibration.flow.result import write_tables

    name = Path(video).stem.strip("*?[]") or "pictures"
    tables = write_tables(flow, folder, name)
    sheet = draw_sheet(flow, folder / f"flow-{name}.png", name)
    return {"sheet": str(sheet), "tables": [str(path) for path in tables]}


def _files_of_collapse(seen: "Collapse", folder: Path | None, video: str) -> list[str]:
    if folder is None:
        return []
    from calibration.flow.collapse import write_collapse

    return [str(path) for path in write_collapse(seen, folder, Path(video).stem)]


def _report(flow: "Flow", files: dict[str, Any]) -> str:
    import numpy as np

    from calibration.flow.figure import words
    from calibration.statistics.quantity import plus_minus

    silo, unit = flow.silo, flow.silo.unit
    lines = [
        f"{words(flow)}",
        f"opening  at frame {plus_minus(flow.opening.value, flow.opening.sigma)} of "
        f"{flow.seen.count}, {flow.rate:g} frames/s",
        f"silo     {silo.width:g} x {silo.height:g} px at ({silo.left:g}, {silo.top:g}); outlet "
        f"{flow.outlet[0]:.4g} to {flow.outlet[1]:.4g} {unit}",
    ]
    if unit == "m":
        lines.append(f"scale    {plus_minus(silo.scale.value, silo.scale.sigma)} m/px")
    depth, _ = flow.depths()
    lines.append(f"{'time [s]':>10} {'remains':>8} {'deepest V [' + unit + ']':>15} {'lines':>6}")
    for k, one in enumerate(flow.profiles):
        remains = float(np.interp(one.time, flow.curve.time, flow.curve.remaining))
        known = depth[k][np.isfinite(depth[k])]
        deepest = f"{known.max():.4g}" if len(known) else "-"
        seen = int(np.isfinite(one.lines).any(axis=1).sum())
        lines.append(f"{one.time:10.3g} {remains:8.3f} {deepest:>15} {seen:6d}")
    lines += [f"warning: {warning}" for warning in flow.warnings]
    lines += [f"table {path}" for path in files["tables"]]
    lines += [f"sheet {files['sheet']}"] if files["sheet"] else []
    return "\n".join(lines)


def _collapse_report(answer: dict[str, Any]) -> str:
    unit = answer["length_unit"]
    lines = [
        f"{'time [s]':>9} {'left':>10} {'right':>10} {'half width':>11} {'surface':>9} [{unit}]"
    ]
    shown = range(0, len(answer["time_s"]), max(len(answer["time_s"]) // 20, 1))
    for k in shown:
        cells = [answer[key][k] for key in ("front_left", "front_right", "half_width", "surface")]
        row = " ".join(f"{'-' if v is None else format(v, '.4g'):>10}" for v in cells)
        lines.append(f"{answer['time_s'][k]:9.4f} {row}")
    lines += [f"sigma {answer['sigma']:.2g} {unit}"]
    lines += [f"warning: {warning}" for warning in answer["warnings"]]
    lines += [f"wrote {path}" for path in answer["files"]]
    return "\n".join(lines)
