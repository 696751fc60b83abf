"""The commands that look around and write templates: init, list, show."""

from pathlib import Path

import click

from damper3d.commands.options import out_option


@click.command()
@click.argument("file")
def init(file: str) -> None:
    """Write a case file with a comment on every key."""
    from contact.datafile import data_file
    from damper3d.library import write_new

    template = data_file("cases", "damper")
    assert template is not None  # shipped
    write_new(Path(file), template.read_text(encoding="utf-8"))
    click.echo(f"wrote {file}; run it with: damper3d run {file}")


@click.command("list")
@out_option
def list_(out: str) -> None:
    """What there is: presets, cases, materials; packings and runs with their state and size."""
    from damper3d.library import listing

    click.echo(listing(Path(out)))


@click.command()
@click.argument("name")
def show(name: str) -> None:
    """A preset, case file, materials file or run folder in words and numbers."""
    from damper3d.library import description

    click.echo(description(name))
