"""The command that computes how densely particles pack: pack."""

import json
from pathlib import Path
from typing import Any

import click

from damper3d.commands.options import case_command, changes_of, material_option
from granulab.campaign.cli.commandline import json_option, out_option, quiet_option, workers_option
from granulab.campaign.cli.many import stop_unless_whole

_WITHOUT = {"run.seed": "packings take the seeds 1 to --packings"}


@case_command(without=_WITHOUT)
@click.argument("case", required=False)
@material_option
@click.option("--bodies", type=int, default=100, metavar="100", help="In the periodic cell.")
@click.option("--packings", type=int, default=3, metavar="3", help="Of each kind: seeds 1 to N.")
@click.option("--no-enclosure", is_flag=True, help="The periodic cell only.")
@workers_option
@out_option
@quiet_option
@json_option
def pack(
    case: str | None, material: str | None, bodies: int, packings: int, no_enclosure: bool,
    workers: int | None, out: str, quiet: bool, as_json: bool,
    **options: Any,
) -> None:  # fmt: skip
    """Compute random close and loose packing fractions of a case's particles.

    Close: frictionless particles jam in a periodic cell. Loose, and shaken down: in the case's own
    enclosure, with its walls. For example: damper3d pack --particles prolate:1.5
    """
    if packings < 1:
        raise click.UsageError(f"--packings = {packings}: must be at least 1")
    from damper3d.case.case import DamperCase
    from damper3d.run.sweep import DAMPER
    from damper3d.studies.pack import computed
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.layout import on_screen
    from granulab.campaign.output.terminal import announce_compilation

    name, changes = case or "thesis", changes_of(material, options)
    particles = DamperCase.load(name, changes).particle.name
    refuse_unless_writable(Path(out), "--out")
    announce_compilation(quiet, DAMPER.compiled())
    rows = computed.pack(
        name, changes, out=Path(out), bodies=bodies, packings=packings, beds=not no_enclosure,
        workers=workers, quiet=quiet,
    )  # fmt: skip
    if as_json:
        click.echo(json.dumps(computed.summary(particles, bodies, rows), indent=2))
    else:
        click.echo(on_screen(computed.as_text(particles, bodies, rows)))
    stop_unless_whole(rows)
