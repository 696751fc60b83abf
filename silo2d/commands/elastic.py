"""The command between E, nu and the stiffness of a silo's contacts: elastic."""

import json
from typing import Any

import click

from granulab.campaign.cli.commandline import json_option
from silo2d.commands.options import case_command, changes_of, mu_option


@case_command()
@click.argument("case")
@mu_option
@json_option
def elastic(case: str, mu: str | None, as_json: bool, **options: Any) -> None:
    """Stiffness of contacts from E and nu of the materials, and E and nu of the stiffness.

    By a line contact of the case's particles under its fill. E and nu are those of two bodies of
    one material, as damper3d takes them.
    For example: silo2d elastic A4; silo2d elastic A4 --kn "5e7 N/m" --kt "4.4e7 N/m"
    """
    from granulab.campaign.output.layout import wrapped
    from silo2d.case.beds.elastic import both_ways
    from silo2d.case.case import SiloCase

    loaded = SiloCase.load(case, changes_of(mu, options))
    laws = loaded.particle_law, loaded.wall_law
    found = both_ways(loaded.settings.particles.names, loaded.solids, laws)
    lines = [line for one in found for line in one.lines()]
    click.echo(
        json.dumps([one.numbers() for one in found], indent=2)
        if as_json
        else wrapped("\n".join(lines), 20)
    )
