"""The command damper3d: its subcommands."""

from pathlib import Path
from typing import Any

from damper3d.commands import (
    contact,
    impact,
    map,
    pack,
    predict,
    reproduce,
    results,
    run,
    shape,
    slow,
)
from granulab.campaign.cli.commandline import command_group, run_app
from granulab.campaign.cli.library import file_commands
from granulab.campaign.cli.many import sweep_command


def _study(path: str) -> Any:
    from damper3d.run.sweep import DAMPER, load_study

    return DAMPER, load_study(path)


def _template(study: bool) -> str:
    from damper3d.case.settings import commented_case
    from granulab.contact.files.datafile import data_file

    if not study:
        return commented_case()
    file = data_file("studies", "damper")
    assert file is not None  # shipped
    return file.read_text(encoding="utf-8")


def _listing(root: Path) -> str:
    from damper3d.view.library import listing

    return listing(root)


def _description(name: str) -> str:
    from damper3d.studies.quasistatic.report import finished_test
    from damper3d.view.library import description

    return description(name, finished_test)


app = command_group(
    [
        run.run,
        sweep_command("damper3d", _study),
        map.map_,
        reproduce.reproduce,
        predict.predict,
        pack.pack,
        impact.impact,
        contact.contact,
        shape.shape,
        slow.shear,
        slow.compress,
        results.render,
        results.observe,
        results.compare,
        results.export,
        *file_commands("damper3d", _template, _listing, _description, "case file, materials file"),
    ],
    """Granular dampers: the energy that shaken particles dissipate.

    A case is a preset ("thesis") or a TOML file; `damper3d init my_damper.toml` writes one with a
    comment on every key.
    """,
)


def main() -> None:
    """Run the command; one line on stderr and an exit code for whatever goes wrong."""
    from granulab.errors import InputError

    run_app(app, "damper3d", InputError)
