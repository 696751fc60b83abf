"""The command granulab: what there is, and the studio."""

import importlib
from pathlib import Path

import click

from granulab.campaign.cli.commandline import all_option, out_option, run_app

_PACKAGES = {"silo2d": "silo2d", "damper3d": "damper3d", "calibrate": "calibration"}  # by command
_WITH_RUNS = ("silo2d", "damper3d")
_COLUMN = 17


@click.group(
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="granulab")
@out_option
@all_option
@click.pass_context
def app(context: click.Context, out: str, every: bool) -> None:
    """GranuLab: silos, granular dampers, and their contact parameters from measurements.

    Without a command it lists the commands, presets, materials and runs that there are.
    """
    if context.invoked_subcommand is None:
        click.echo(listing(Path(out), every))


@app.command()
@click.option(
    "--folder", default=".", metavar="DIR",
    help="Cases, shapes, materials and runs of the page [default: this one].",
)  # fmt: skip
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="[default: any free one].")
@click.option("--no-browser", is_flag=True, help="Print the address, and open no browser.")
def studio(folder: str, port: int, no_browser: bool) -> None:
    """Build, run and compare cases in a browser, on this machine only.

    Serves a page on 127.0.0.1 until Ctrl-C; its address holds a token, without which nothing is
    answered. Files are read and written below DIR alone; runs go to DIR/runs.
    """
    from granulab.studio.launch import serve

    serve(Path(folder), port, open_browser=not no_browser)


def listing(root: Path, every: bool) -> str:
    """The commands, and the presets, materials and runs that there are, a line or more each."""
    from granulab.campaign.output.layout import wrapped
    from granulab.contact.files.datafile import data_names

    commands = {
        name: (importlib.import_module(package).__doc__ or "").splitlines()[0]
        for name, package in _PACKAGES.items()
    }
    commands["granulab studio"] = "Cases built, run and compared in a browser on this machine."
    lines = [f"{name:{_COLUMN}}{purpose}" for name, purpose in commands.items()]
    lines += ["", f"{'materials':{_COLUMN}}{', '.join(data_names('materials'))}"]
    runs: list[str] = []
    for package in _WITH_RUNS:
        library = importlib.import_module(f"{package}.commands.library")
        lines.append(f"{package:{_COLUMN}}presets {', '.join(library.PRESETS)}")
        for line in library.listing(root, every).splitlines():
            word, rest = line.split(maxsplit=1)
            if word in ("shapes", "cases"):
                lines.append(f"{'':{_COLUMN}}{word} {rest}")
            elif word not in ("presets", "materials"):
                runs.append(f"{word:{_COLUMN}}{rest}")
    return wrapped("\n".join([*lines, *dict.fromkeys(runs)]), _COLUMN)


def main() -> None:
    """Run the command; one line on stderr and an exit code for whatever goes wrong."""
    run_app(app, "granulab")
