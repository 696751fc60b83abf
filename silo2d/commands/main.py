"""The command silo2d: its subcommands."""

from typing import TYPE_CHECKING, Any

from granulab.campaign.cli.commandline import command_group, run_app
from granulab.campaign.cli.library import file_commands
from granulab.campaign.cli.many import sweep_command
from granulab.campaign.cli.reproduce import reproduce_command
from granulab.campaign.cli.view import view_command
from silo2d.commands import clog, elastic, loads, results, run, shapes
from silo2d.commands.options import outline_options

if TYPE_CHECKING:
    from granulab.campaign.sweeps.cases import LabelledStudy
    from granulab.campaign.sweeps.sketch import Sketch
    from granulab.campaign.sweeps.sweep import Simulator


def _simulator() -> "Simulator":
    from silo2d.run.sweep import SILO

    return SILO


def _study(path: str, given: dict[str, Any]) -> "LabelledStudy":
    from silo2d.run.sweep import load_study

    return load_study(path, given)


def _sketch() -> "Sketch":
    from silo2d.view.sketch import sketch

    return sketch


app = command_group(
    [
        run.run,
        run.packing,
        sweep_command("silo2d", _simulator, _study, _sketch),
        reproduce_command(
            """Compute one of the paper's tables and compare it with the published numbers.

            Without TABLE it says what there is. Runs that are there already are not done again.
            """,
            "silo2d.reproduce",
            _simulator,
        ),
        results.render,
        view_command("silo2d", results.player, lambda: _simulator().means),
        results.observe,
        results.compare,
        results.export,
        shapes.shapes,
        loads.loads,
        clog.clog,
        elastic.elastic,
        *file_commands(
            "silo2d",
            "friction",
            "case file, shape set, materials file",
            new=("materials", "shapes", "loads"),
            case_options=outline_options,
        ),
    ],
    """Discharge of angular particles from 2D silos.

    A case is a preset (A1 ... D4: hopper of 60, 45, 30, 0 degrees; outlet of 40, 60, 100,
    150 mm) or a TOML file; `silo2d init my_silo.toml` writes one with a comment on every key.
    """,
)


def main() -> None:
    """Run the command; one line on stderr and an exit code for whatever goes wrong."""
    run_app(app, "silo2d")
