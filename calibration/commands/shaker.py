"""The command that takes dissipated power and efficiency from a shaken enclosure's signals."""

from pathlib import Path

import click

from calibration.commands.options import answers_options, figures_option
from calibration.result import finish
from granulab.campaign.cli.commandline import quiet_option
from granulab.contact.files.units import to_si
from granulab.errors import InputError


@click.command(short_help="Power and efficiency of a shaken enclosure")
@click.argument(
    "files", metavar="FILE | RUN...", nargs=-1, required=True, type=click.Path(path_type=Path)
)
@click.option(
    "--empty", type=click.Path(path_type=Path), multiple=True,
    help="Record of the enclosure without particles; once for each amplitude.",
)  # fmt: skip
@click.option(
    "--frequency", type=float, multiple=True, metavar="40",
    help="That the shaker was given, in Hz; once for each tone [default: the strongest].",
)  # fmt: skip
@click.option("--particle-mass", metavar='"27.9 g"', help="For the efficiency and the phase.")
@click.option(
    "--phase-error", default="1 deg", metavar='"1 deg"', show_default=True,
    help="Largest that there may be at frequencies without an --empty record.",
)  # fmt: skip
@click.option("--harmonics", type=click.IntRange(1, 50), default=5, help="Counted [default: 5].")
@click.option(
    "--column", "columns", multiple=True, metavar="NAME=HEAD",
    help='force or acceleration that is called otherwise: "force=Kraft [kN]".',
)  # fmt: skip
@click.option(
    "--against", is_flag=True,
    help="Instead of a FILE, run folders of damper3d: their phases from the particles counted "
    "against those from their records (damper3d export RUN --to shaker).",
)  # fmt: skip
@click.option("--rate", type=float, metavar="40000", help="Samples/s of tables without times.")
@figures_option("Folder for the diagnostic figure (PNG).")
@quiet_option
@answers_options
def command(
    files: tuple[Path, ...], empty: tuple[Path, ...], frequency: tuple[float, ...],
    particle_mass: str | None, phase_error: str, harmonics: int, columns: tuple[str, ...],
    against: bool, rate: float | None, out: Path | None, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Dissipated power, efficiency and phase from force and acceleration (thesis, secs 7.4, 7.6).

    For example: calibrate shaker full.csv --empty empty.csv --particle-mass "27.9 g" -o figures
    """
    if against:
        from calibration.shaker.against import against as compare

        finish(compare(files), as_json=as_json, quiet=quiet, out=out, name="against-shaker")
        return
    if len(files) > 1:
        raise InputError(f"{files[1]}: one FILE at a time; --empty names that without particles")
    from calibration.bench.sections import request_of
    from calibration.shaker.measure import dissipation
    from calibration.shaker.record import INPUTS, read_record

    mass = None if particle_mass is None else to_si(particle_mass, "kg", "--particle-mass")
    called = request_of(INPUTS, columns).columns
    loaded, *others = (
        read_record(path, rate=rate, frequencies=frequency, harmonics=harmonics, columns=called)
        for path in (files[0], *empty)
    )
    found = dissipation(loaded, others, mass, to_si(phase_error, "rad", "--phase-error"))
    finish(found, as_json=as_json, quiet=quiet, out=out, name=f"{files[0].stem}-shaker")
