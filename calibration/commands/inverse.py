"""The command that fits contact parameters to a measurement by simulation: inverse."""

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from calibration.result import Files, finish, report_of
from granulab.campaign.cli.commandline import (
    Ended,
    engine_options,
    json_option,
    out_option,
    quiet_option,
)

if TYPE_CHECKING:
    from calibration.inverse.fit_file import Fit
    from calibration.inverse.result import Fitted


@click.command(short_help="Parameters fitted by simulation")
@click.argument("fit")
@out_option
@engine_options
@click.option("--init", is_flag=True, help="Write FIT, with a comment on every key, and end.")
@click.option("--dry-run", is_flag=True, help="Say what would be run, and end.")
@click.option("--no-figures", is_flag=True, help="Make no pictures.")
@click.option("--into", metavar="FILE.toml", help="Write what is identifiable into this file.")
@quiet_option
@json_option
def command(
    fit: str, out: str, init: bool, dry_run: bool, no_figures: bool, into: str | None,
    quiet: bool, as_json: bool, **engine: Any,
) -> None:  # fmt: skip
    """Fit contact parameters to a measured discharge or efficiency, by simulation.

    FIT is a TOML file: simulator, case, parameters with priors, observations. Runs that are
    finished are not done again: the same command goes on after whatever stopped it.

    For example: calibrate inverse fit.toml --init; calibrate inverse fit.toml -o runs
    """
    from calibration.inverse.fit_file import read_fit

    if init:
        _write_example(Path(fit))
        return
    loaded = read_fit(fit)
    if into is not None:
        from calibration.inverse.parameter_values import check_into

        check_into(Path(into), loaded)
    if dry_run:
        planned = _plan(loaded)
        click.echo(json.dumps(planned, indent=2) if as_json else _plan_as_text(loaded, planned))
        return
    found, figures = _fitted(loaded, Path(out), into, not no_figures, quiet, engine)
    files: Files = {"table": found.folder.path / "table.csv", "figures": figures}
    finish(found, as_json=as_json, quiet=quiet, figure_key=None, files=files)
    if failed := sum(run.ended == "failed" for run in found.runs.runs):
        raise Ended(f"{failed} of {len(found.runs.runs)} runs failed; see the table", 3)


def _fitted(
    loaded: "Fit", out: Path, into: str | None, figures: bool, quiet: bool, engine: dict[str, Any]
) -> "tuple[Fitted, list[Path]]":
    """The fit and its figures, as text and summary in the folder of the fit, too."""
    from calibration.inverse.figures import write_figures
    from calibration.inverse.fit import run_fit
    from calibration.inverse.parameter_values import write_into
    from granulab.campaign.output.files import refuse_unless_writable, write_atomic

    refuse_unless_writable(out, "--out")
    found = run_fit(loaded, out=out.resolve(), quiet=quiet, **engine)
    drawn = write_figures(found) if figures else []
    write_atomic(found.folder.path / "report.txt", found.text() + "\n")
    found.folder.write_summary(found.to_dict() | {"figures": [str(path) for path in drawn]})
    if into is not None:
        written = write_into(found, Path(into))
        found = replace(found, written=tuple(written))
        for one in written:
            click.echo(report_of(one), err=True)
    return found, drawn


def _write_example(path: Path) -> None:
    from granulab.campaign.cli.library import write_new
    from granulab.contact.files.datafile import data_file

    template = data_file("fits", "example")
    assert template is not None  # shipped
    write_new(path, template.read_text(encoding="utf-8"))
    click.echo(f"wrote {path}; run it with: calibrate inverse {path}")


def _plan(loaded: "Fit") -> dict[str, Any]:
    """Plan of a fit; nothing is written."""
    costs = [
        sum(loaded.simulated.campaign.expected_cpu_s(loaded.case(number, loaded.middle)))
        for number in range(len(loaded.cases))
    ]
    return {
        "parameters": {prior.name: list(prior.ends) for prior in loaded.priors},
        "observed_values": len(loaded.observed().values),
        "points": loaded.points,
        "seeds": loaded.seeds,
        "cases": len(loaded.cases),
        "runs": loaded.runs,
        "cpu_min": sum(costs) * loaded.points * loaded.seeds / 60,
    }


def _plan_as_text(loaded: "Fit", planned: dict[str, Any]) -> str:
    priors = [
        f"  {prior.name}: {prior.kind}, {prior.ends[0]:.4g} to {prior.ends[1]:.4g}"
        + ("" if prior.unit == "1" else f" {prior.unit}")
        for prior in loaded.priors
    ]
    return "\n".join(
        [
            f"{loaded.name}: {planned['observed_values']} observed values",
            *priors,
            f"{planned['points']} points of {planned['seeds']} seeds and {planned['cases']} cases: "
            f"{planned['runs']} runs, about {planned['cpu_min']:.0f} min of CPU time",
        ]
    )
