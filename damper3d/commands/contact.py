"""The command on single contacts: contact."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from damper3d.studies.single_contact import Found


@click.command()
@click.argument("study", required=False)
@click.option(
    "-o",
    "--out",
    metavar="DIR",
    help="Holds picture, curves, report [default: runs/contact/STUDY].",
)
@click.option("--no-figures", is_flag=True, help="Write nothing; print the numbers only.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def contact(study: str | None, out: str | None, no_figures: bool, as_json: bool) -> None:
    """Study a single contact: numbers on stdout; picture and curves in a folder.

    Without STUDY it says which there are.
    """
    from damper3d.run.sweep import DAMPER
    from damper3d.studies.single_contact import STUDIES, find
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.layout import on_screen
    from granulab.campaign.output.terminal import announce_compilation

    if study is None:
        click.echo("\n".join(f"{name:15} {entry.text}" for name, entry in STUDIES.items()))
        return
    chosen = find(study)
    folder = Path(out) if out else Path("runs") / "contact" / study
    if not no_figures:
        refuse_unless_writable(folder, "--out")
    announce_compilation(quiet=False, already_compiled=DAMPER.compiled())
    found = chosen.compute()
    text = report(found)
    files: list[str] = []
    if not no_figures:
        from granulab.campaign.output.results import write_results

        head = [f"command: damper3d contact {study}"]
        written = write_results(folder, study, found.rows, head, text, lambda: chosen.draw(found))
        files = [str(path) for path in written]
    if as_json:
        result = {**found.numbers, "remarks": list(found.remarks), "files": files}
        click.echo(json.dumps(result, indent=2))
        return
    click.echo(on_screen(text))
    for path in files:
        click.echo(path, err=True)


def report(found: "Found") -> str:
    """The report of a study: a number a line, and the remarks."""
    lines: list[str] = []
    for key, value in found.numbers.items():
        if isinstance(value, dict):
            lines.append(key)
            lines += [f"  {name:38} {_shown(number)}" for name, number in value.items()]
        else:
            lines.append(f"{key:40} {_shown(value)}")
    return "\n".join([*lines, *found.remarks])


def _shown(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(_shown(part) for part in value)
    return f"{value:.4g}" if isinstance(value, float) else str(value)
