"""The command silo2d: its subcommands."""

from pathlib import Path
from typing import Any

from granulab.campaign.cli.commandline import command_group, run_app
from granulab.campaign.cli.library import file_commands
from granulab.campaign.cli.many import sweep_command
from silo2d.commands import reproduce, results, run


def _study(path: str) -> Any:
    from silo2d.run.sweep import SILO, load_study

    return SILO, load_study(path)


def _template(study: bool) -> str:
    from granulab.contact.files.datafile import data_file
    from silo2d.case.settings import commented_case

    if not study:
        return commented_case()
    file = data_file("studies", "friction")
    assert file is not None  # shipped
    return file.read_text(encoding="utf-8")


def _listing(root: Path) -> str:
    from silo2d.view.library import listing

    return listing(root)


def _description(name: str) -> str:
    from silo2d.view.library import description

    return description(name)


app = command_group(
    [
        run.run,
        run.packing,
        sweep_command("silo2d", _study),
        reproduce.reproduce,
        results.render,
        results.observe,
        results.compare,
        results.export,
        *file_commands(
            "silo2d", _template, _listing, _description, "case file, shape set, materials file"
        ),
    ],
    """Discharge of angular particles from 2D silos.

    A case is a preset (A1 ... D4: hopper of 60, 45, 30, 0 degrees; outlet of 40, 60, 100,
    150 mm) or a TOML file; `silo2d init my_silo.toml` writes one with a comment on every key.
    """,
)


def main() -> None:
    """Run the command; one line on stderr and an exit code for whatever goes wrong."""
    from granulab.errors import InputError

    run_app(app, "silo2d", InputError)
