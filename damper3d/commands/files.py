"""The commands that look around and write templates: init, list, show."""

from pathlib import Path

import click

from granulab.campaign.cli.commandline import out_option


@click.command()
@click.argument("file")
@click.option("--study", is_flag=True, help="Write a study file instead.")
def init(file: str, study: bool) -> None:
    """Write a case file with a comment on every key."""
    from granulab.campaign.cli.library import write_new
    from granulab.contact.files.datafile import data_file

    template = data_file("studies" if study else "cases", "damper")
    assert template is not None  # shipped
    write_new(Path(file), template.read_text(encoding="utf-8"))
    click.echo(f"wrote {file}; run it with: damper3d {'sweep' if study else 'run'} {file}")


@click.command("list")
@out_option
def list_(out: str) -> None:
    """What there is: presets, cases, materials; packings and runs with their state and size."""
    from damper3d.view.library import listing

    click.echo(listing(Path(out)))


@click.command()
@click.argument("name")
def show(name: str) -> None:
    """A preset, case file, materials file or run folder in words and numbers."""
    from damper3d.studies.quasistatic.report import finished_test
    from damper3d.view.library import description

    click.echo(description(name, finished_test))
