"""The command damper3d: its subcommands."""

from functools import partial
from typing import TYPE_CHECKING, Any

from damper3d.commands import contact, impact, map, pack, predict, results, run, shape, slow
from damper3d.commands.options import EXAMPLES_OF_CASES, case_command
from damper3d.commands.structure import design, field, response
from granulab.campaign.cli.commandline import ENGINES_AND_GPU, command_group, run_app
from granulab.campaign.cli.library import file_commands
from granulab.campaign.cli.many import sweep_command
from granulab.campaign.cli.reproduce import reproduce_command
from granulab.campaign.cli.view import view_command

if TYPE_CHECKING:
    from granulab.campaign.sweeps.cases import LabelledStudy
    from granulab.campaign.sweeps.sketch import Sketch
    from granulab.campaign.sweeps.sweep import Simulator


def _simulator() -> "Simulator":
    from damper3d.run.sweep import DAMPER

    return DAMPER


def _study(path: str, given: dict[str, Any]) -> "LabelledStudy":
    from damper3d.run.sweep import load_study

    return load_study(path, given)


def _sketch() -> "Sketch":
    from damper3d.view.sketch import sketch

    return sketch


_sweep_command = partial(case_command, keys={"run.steady": ", in every run"})

app = command_group(
    [
        run.run,
        sweep_command("damper3d", _simulator, _study, _sketch, ENGINES_AND_GPU, _sweep_command),
        map.map_,
        field.field,
        response.response,
        design.design,
        reproduce_command(
            """Compute one of the thesis's tables and compare it with the published numbers.

            Without TABLE it says what there is. Runs that are there already are not done again:
            the same command goes on after whatever stopped it.
            """,
            "damper3d.reproduce",
            _simulator,
            ENGINES_AND_GPU,
            {"steady": "Also beds that are shaken until their cycles are alike."},
        ),
        predict.predict,
        pack.pack,
        impact.impact,
        contact.contact,
        shape.shape,
        slow.shear,
        slow.compress,
        results.render,
        view_command("damper3d", results.player, lambda: _simulator().means),
        results.observe,
        results.compare,
        results.export,
        *file_commands(
            "damper3d",
            "damper",
            "case file, materials file",
            ("materials", "design", *EXAMPLES_OF_CASES),
        ),
    ],
    """Granular dampers: the energy that shaken particles dissipate.

    A case is a preset ("thesis") or a TOML file; `damper3d init my_damper.toml` writes one with a
    comment on every key.
    """,
)


def main() -> None:
    """Run the command; one line on stderr and an exit code for whatever goes wrong."""
    run_app(app, "damper3d")
