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
    from silo2d.case.beds.elastic import PAIRS, both_ways, in_lines
    from silo2d.case.case import SiloCase

    loaded = SiloCase.load(case, changes_of(mu, options))
    assert loaded.solids is not None  # of a case that was loaded
    laws = loaded.particle_law, loaded.wall_law
    found = both_ways(loaded.settings.particles.names, loaded.solids, laws)
    if as_json:
        by_pair = zip(PAIRS, (one.numbers() for one in found), strict=True)
        click.echo(json.dumps(dict(by_pair), indent=2))
    else:
        click.echo(wrapped(in_lines(found, loaded.solids), 20))
